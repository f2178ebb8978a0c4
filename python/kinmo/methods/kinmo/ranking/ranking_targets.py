"""Soft targets of the ranking networks: candidate joints by their distance from the true joint."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.features.candidate_features import CandidateFeatures

F64 = NDArray[np.float64]

ANGLE_SCALE = np.radians(2.0)
"""Angle to the true axis, in radians, that lowers a candidate's target by a factor e."""
LINE_SCALE = 0.015
"""Distance from the true axis, in diagonals, that lowers a candidate's target by a factor e."""
MAX_EXTRA_COST = 4.0
"""Candidates whose cost exceeds the least cost by more than this have a target of 0."""


def candidate_costs(features: CandidateFeatures, rows: slice, joint: Joint, center: F64) -> F64:
    """Cost of each candidate for a true joint: its angle and distance errors in units of their scales.

    Args:
        features: Candidate joints of the shape.
        rows: Rows of one group.
        joint: The true joint of that group.
        center ([3]): Centre of the group. The distance is measured where the true axis passes nearest to it.

    Returns:
        [C] costs; infinite for candidates of another kind.
    """
    directions, pivots = features.directions[rows], features.pivots[rows]
    cost = np.arccos(np.clip(np.abs(directions @ joint.direction), 0.0, 1.0)) / ANGLE_SCALE
    if joint.has_pivot:
        near_center = joint.pivot + ((center - joint.pivot) @ joint.direction) * joint.direction
        offset = near_center - pivots
        offset -= np.sum(offset * directions, axis=1, keepdims=True) * directions
        cost = cost + np.linalg.norm(offset, axis=1) / LINE_SCALE
    return np.where(features.kinds[rows] == joint.kind.code, cost, np.inf)


def soft_target(costs: F64) -> F64:
    """Target probabilities [C] from costs [C]: highest for the least cost, shared with candidates about as good."""
    relative = costs - costs.min()
    target = np.where(relative < MAX_EXTRA_COST, np.exp(-np.minimum(relative, MAX_EXTRA_COST)), 0.0)
    result: F64 = target / target.sum()
    return result
