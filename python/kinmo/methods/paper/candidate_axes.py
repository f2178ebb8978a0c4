"""Candidate axes from the symmetry-aligned box of the movable part (paper, section 3.3).

A box has 12 edges and 3 centre lines. The box axis nearest to `up` counts as vertical, the other two as horizontal. Every
motion type therefore has the same number of candidates for any box.

| type | candidates | further candidates through the interaction region |
|---|---|---|
| R_H_S, R_V_S | the 8 horizontal edges, the 4 vertical ones | 2, 1 (release only) |
| R_H_C, R_V_C | the 2 horizontal centre lines, the vertical one | 2, 1 (paper) |
| P_H, P_V | the 2 horizontal axes, the vertical one | |
| PR_H, PR_V | the 2 horizontal centre lines, the vertical one | 2, 1 (release only) |
| R, P, PR (coarse) | all edges and centre lines; all axes; all centre lines | 3, none, 3 (release only) |
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.oriented_box import Box
from kinmo.features.candidate_joints import CandidateJoints

F64 = NDArray[np.float64]

EDGE_SIGNS = np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)], float)
"""Signs of the four parallel edges along the two other axes of a box."""


def candidate_axes(
    motion: MotionType | CoarseType,
    box: Box,
    up: F64,
    contact: F64 | None = None,
    contact_pivots: Literal["central", "revolute", "none"] = "central",
) -> CandidateJoints:
    """Candidate axes {m_i} of a part with a given motion type (paper, section 3.3; see the table of this module).

    Args:
        motion: Motion type of the part; FIXED and NONE have no candidates.
        box: Symmetry-aligned box of the part.
        up ([3]): Unit vector.
        contact ([3]): Centroid of the interaction region with the reference part; None without a reference.
        contact_pivots: Axes that also pass through `contact`: those of the C types (`central`, as printed), all axes that
            turn (`revolute`, as in the release), or `none`.
    """
    kind = motion.kind
    if kind is None:
        return CandidateJoints.empty()
    is_central = isinstance(motion, MotionType) and motion.is_central
    axes = np.argsort(-np.abs(box.axes @ up), kind="stable")
    if isinstance(motion, MotionType):
        axes = axes[:1] if motion.is_vertical else axes[1:]
    found: list[tuple[int, F64, str]] = []
    if kind is JointKind.REVOLUTE and not is_central:
        found += [(axis, pivot, "box edge") for axis in axes for pivot in edge_midpoints(box, axis)]
    if kind is not JointKind.REVOLUTE or is_central or isinstance(motion, CoarseType):
        found += [(axis, box.center, "box centre") for axis in axes]
    wanted = is_central if contact_pivots == "central" else contact_pivots == "revolute" and kind is not JointKind.PRISMATIC
    if contact is not None and wanted:
        found += [(axis, contact, "interaction region") for axis in axes]
    return CandidateJoints(
        np.full(len(found), kind.code, np.uint8),
        box.axes[[axis for axis, _, _ in found]],
        np.array([pivot for _, pivot, _ in found]),
        tuple(source for _, _, source in found),
    )


def edge_midpoints(box: Box, axis: int) -> F64:
    """Midpoints [4, 3] of the four edges of a box along one of its axes."""
    first, second = (i for i in range(3) if i != axis)
    spread = EDGE_SIGNS[:, :1] * box.half_extents[first] * box.axes[first]
    return np.asarray(box.center + spread + EDGE_SIGNS[:, 1:] * box.half_extents[second] * box.axes[second])
