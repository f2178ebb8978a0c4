"""Candidate motions of one part, and features of each motion relative to the contact region."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import KINDS, JointKind
from kinmo.features.candidate_lines import CENTRAL_SOURCES, CandidateLines, distinct_directions
from kinmo.features.group_geometry import GroupGeometry

F64 = NDArray[np.float64]


def candidate_motions(lines: CandidateLines) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Kind and line of every candidate joint.

    A part may turn about each line, slide along each distinct direction, and screw about each central line.

    Args:
        lines: Candidate axes of the part.

    Returns:
        Codes of the kinds [C] (`JointKind.code`) and indices of the lines [C].
    """
    slides = distinct_directions(lines)
    screws = np.flatnonzero(lines.sources[:, list(CENTRAL_SOURCES)].any(axis=1))
    kinds = np.repeat([kind.code for kind in KINDS], [len(lines), len(slides), len(screws)])
    return kinds, np.concatenate([np.arange(len(lines)), slides, screws])


def motion_features(group: GroupGeometry, kinds: NDArray[np.int64], directions: F64, pivots: F64) -> F64:
    """Features of each motion: its kind, and the share of its velocity that slides along or runs into the contact.

    Swept collisions (`kinmo.features.joint_limits`) are no features: they cost more time than all others and did not improve
    the ranking.

    Args:
        group: The moving part.
        kinds ([C]): Codes of the kinds.
        directions ([C, 3]): Unit vectors along the axes.
        pivots ([C, 3]): Points of the axes.

    Returns:
        [C, 7] features.
    """
    w = group.contact_weights
    turning = np.cross(directions[:, None], group.contact[None] - pivots[:, None])
    turning /= np.maximum(np.linalg.norm(turning, axis=-1).max(axis=1), 1e-6)[:, None, None]
    velocity = np.where((kinds == JointKind.PRISMATIC.code)[:, None, None], directions[:, None], turning)
    normal_velocity = np.einsum("hni,ni->hn", velocity, group.toward)
    speed = np.linalg.norm(velocity, axis=-1) @ w
    normal_speed = np.abs(normal_velocity) @ w
    one_sided = np.abs(normal_velocity @ w) / np.maximum(normal_speed, 1e-6)
    features = {
        "kind": np.eye(3)[kinds],
        "speed into the contact": normal_speed,
        "share of speed into the contact": normal_speed / np.maximum(speed, 1e-6),
        "one-sided contact": one_sided,
        "blocked in one direction": one_sided * normal_speed,
    }
    return np.column_stack(list(features.values()))
