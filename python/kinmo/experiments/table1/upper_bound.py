"""The row that frames a table from above: the best that the candidates allow."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.core.prediction import JointEstimate
from kinmo.core.vector import Vector
from kinmo.evaluation import metrics
from kinmo.evaluation.joint_records import AXIS_WITHIN, LINE_WITHIN
from kinmo.features.prepared_shape import PreparedShape

F64 = NDArray[np.float64]


def ceiling(truth: PreparedShape, candidates: Mapping[int, tuple[F64, F64]]) -> dict[int, JointEstimate]:
    """The best candidate of every movable body of `truth`, its true kind known.

    `candidates` holds directions [K, 3] (unit) and pivots [K, 3] by body, in the normalised frame. Best is the one whose
    worse error, axis over 5 degrees or line at the part over 0.05 diagonals, is smallest. It has no range. A body without
    candidates gets no answer.
    """
    mobility, boxes = truth.annotation
    best = {}
    for index, body in mobility.movable():
        true = body.joint
        directions, pivots = candidates.get(index, (np.zeros((0, 3)), np.zeros((0, 3))))
        if true is None or not len(directions):
            continue
        joints = [Joint(true.kind, d, p) for d, p in zip(directions, pivots, strict=True)]
        joint = min(joints, key=lambda found: _error(true, found, boxes[index].center))
        best[index] = JointEstimate(joint, truth.body_types[index], 1.0, source="ceiling")
    return best


def _error(true: Joint, found: Joint, middle: Vector) -> float:
    axis = metrics.axis_error(true.direction, found.direction) / AXIS_WITHIN
    return max(axis, metrics.line_distance_at_part(true, found, middle) / LINE_WITHIN) if true.has_pivot else axis
