"""Kinematic tree of ranked bodies: the parent of every body, and the limits of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, descendants
from kinmo.core.shape_estimate import JointEstimate
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.group_geometry import GroupGeometry, group_geometries
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.travel_features import FREE
from kinmo.methods.kinmo.body_parents import find_parents
from kinmo.methods.kinmo.body_ranking import features_of_groups
from kinmo.methods.kinmo.limits.limits_predictor import LimitsPredictor
from kinmo.methods.kinmo.limits.travel_examples import body_inputs

F64 = NDArray[np.float64]


def build_tree(
    shape: PreparedShape,
    geometry: ShapeGeometry,
    bodies: Sequence[tuple[int, ...]],
    names: Sequence[str],
    ranked: Sequence[tuple[JointEstimate, ...]],
    limiter: LimitsPredictor,
    known: Sequence[int | None] | None = None,
    features: CandidateFeatures | None = None,
) -> tuple[tuple[Body, ...], list[tuple[JointEstimate, ...]]]:
    """Bodies with their parents and best joints, and all ranked joints with limits, in the normalised frame.

    Args:
        shape: The shape; its annotation is not used.
        geometry: Geometry of its leaves.
        bodies: Positions of the leaves of each body.
        names: Name of each body.
        ranked: Ranked joints of each body, without limits.
        limiter: The limits network.
        known: Parent of each body where it is known; None where it is not.
        features: Candidate features that are computed already. None for those that the shape was prepared with.
    """
    parents = find_parents(geometry, bodies, [found[0].joint for found in ranked], known)
    with_joints = [body for body, found in zip(bodies, ranked, strict=True) if any(each.joint is not None for each in found)]
    limits = ShapeLimits(shape, geometry, features_of_groups(shape, geometry, with_joints, features), limiter)
    limited = []
    for index, (leaves, found) in enumerate(zip(bodies, ranked, strict=True)):
        moving = sorted(leaf for body in descendants(parents, index) for leaf in bodies[body])
        limited.append(limits.added(found, leaves, moving))
    tree = tuple(
        Body(index, name, tuple(shape.leaves[position] for position in leaves), parents[index], found[0].joint)
        for index, (name, leaves, found) in enumerate(zip(names, bodies, limited, strict=True))
    )
    return tree, limited


@dataclass(frozen=True, eq=False)
class ShapeLimits:
    """Input for the limits of joints of one shape.

    Attributes:
        shape: The shape.
        geometry: Geometry of its leaves.
        features: Candidate features of its bodies.
        limiter: The limits network.
    """

    shape: PreparedShape
    geometry: ShapeGeometry
    features: CandidateFeatures
    limiter: LimitsPredictor

    def added(
        self, ranked: Sequence[JointEstimate], leaves: tuple[int, ...], moving: Sequence[int]
    ) -> tuple[JointEstimate, ...]:
        """Ranked joints of one body with limits, directions that point to the longer side of the range, and the term `sweep`.

        The best joint is swept alone, so that its limits do not depend on the others. `leaves` are the positions of the body's
        leaves, `moving` those of all leaves that move with it.
        """
        if all(estimate.joint is None for estimate in ranked):
            return tuple(ranked)
        (group,) = group_geometries(self.geometry, [leaves])
        return (*self._added(ranked[:1], group, moving), *self._added(ranked[1:], group, moving))

    def _added(self, ranked: Sequence[JointEstimate], group: GroupGeometry, moving: Sequence[int]) -> list[JointEstimate]:
        joints = {place: estimate.joint for place, estimate in enumerate(ranked) if estimate.joint is not None}
        limited = list(ranked)
        if not joints:
            return limited
        inputs, scales = body_inputs(self.shape, self.geometry, self.features, group, moving, list(joints.values()))
        travel, is_limited = self.limiter.travel(inputs)
        free = inputs.directed[:, :, FREE].astype(np.float64)
        for row, (place, joint) in enumerate(joints.items()):
            found, freedom = _with_limits(joint, travel[row], bool(is_limited[row]), scales[row], free[row])
            limited[place] = replace(ranked[place], joint=found, terms={**ranked[place].terms, "sweep": freedom})
        return limited


def _with_limits(joint: Joint, travel: F64, is_limited: bool, scale: float, free: F64) -> tuple[Joint, float]:
    """The joint with limits, pointing to the longer side, and the share of the travel to that side that is free.

    `travel` [2] and the `free` travel [2] are told for the joint's direction and against it, in units of `scale`.
    """
    longer = int(np.argmax(travel))
    freedom = float(np.clip(free[longer] / max(float(travel[longer]), 1e-9), 0.0, 1.0))
    if joint.kind is JointKind.REVOLUTE and not is_limited:
        return replace(joint, lower=None, upper=None), freedom
    limited = replace(joint, lower=0.0 - float(travel[1] * scale), upper=float(travel[0] * scale))
    return (limited.reversed() if longer else limited), freedom
