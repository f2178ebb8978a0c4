"""Upper bound: the best joint among a set of candidates, the true kind known."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.joint import Joint
from kinmo.core.shape_estimate import JointEstimate
from kinmo.core.vector import Vector
from kinmo.evaluation import metrics
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.paper.leaf_roles import leaf_roles
from kinmo.methods.paper.refinement import Refiner

F64 = NDArray[np.float64]


def upper_bound(truth: PreparedShape, candidates: Mapping[int, tuple[F64, F64]]) -> dict[int, JointEstimate]:
    """Best candidate for every movable body that has any, in the normalised frame.

    The best candidate has the smallest worse error: axis error over 5 degrees, or line distance at the part over 0.05
    diagonals. It has no range. Candidates are unit directions [K, 3] and pivots [K, 3] by body, in the normalised frame.
    """
    mobility, boxes = truth.annotation
    best = {}
    for index, body in mobility.movable():
        true = body.joint
        if true is None or index not in candidates or not len(candidates[index][0]):
            continue
        joints = [Joint(true.kind, direction, pivot) for direction, pivot in zip(*candidates[index], strict=True)]
        joint = min(joints, key=lambda found: _error(true, found, boxes[index].center))
        best[index] = JointEstimate(joint, truth.body_types[index], 1.0, source="upper bound")
    return best


def true_type_candidates(
    truth: PreparedShape, meshes: _core.Meshes | None, config: RefinementConfig
) -> dict[int, tuple[F64, F64]]:
    """Candidates of every movable body for its true motion type: unit directions [K, 3] and pivots [K, 3], normalised frame.

    Candidates beyond the paper's need the meshes of the leaves, in the same frame.
    """
    mobility, _ = truth.annotation
    roles = leaf_roles(truth, mobility.bodies)
    refiner = Refiner(truth, config, None, meshes)
    found = {index: refiner.candidates(roles[index], truth.body_types[index]) for index, _ in mobility.movable()}
    return {index: (candidates.directions, candidates.pivots) for index, candidates in found.items()}


def _error(true: Joint, found: Joint, middle: Vector) -> float:
    axis = metrics.axis_error(true.direction, found.direction) / metrics.MAX_AXIS_ERROR
    return max(axis, metrics.line_distance_at_part(true, found, middle) / metrics.MAX_LINE_DISTANCE) if true.has_pivot else axis
