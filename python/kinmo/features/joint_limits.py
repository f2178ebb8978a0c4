"""Joint limits of candidate joints, from collision-free travel and typical ranges.

A sweep gives the distance that a part travels until it hits other parts. The sweep alone gives poor limits for sliders: thin
walls stop nothing, parts overlap at rest, and a button is pressed into what it touches. Sliders therefore travel a fixed share
of their length, and the sweep decides the direction. The constants were chosen on procedural shapes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.features.candidate_joints import CandidateJoints

F64 = NDArray[np.float64]

MAX_HINGE_ANGLE = math.pi / 2
"""Largest opening angle of a limited hinge, in radians."""
FREE_ANGLE = math.pi / 3
"""Collision-free angle at which a hinge counts as fully free, in radians."""
FREE_SLIDE = 0.5
"""Collision-free travel at which a slider counts as fully free, as a share of the part's length along the axis."""

MAX_BUTTON_SIZE = 0.15
"""Sliders with a smaller diagonal, in diagonals of the object, are pressed in like buttons; others open like drawers."""
SLIDE_RANGE = 0.65
"""Travel of a slider, as a share of the part's length along the axis."""
SAME_TRAVEL = 0.01
"""Difference of the free travel in both directions, as a share of the reach, below which neither direction is freer."""

MAX_WHEEL_OFFSET = 0.1
"""Largest distance between the axis and the middle of a part that turns without limits, as a share of its diagonal."""
FULL_TURN = 0.999 * math.pi
"""Collision-free angle to either side from which a hinge is free all the way round, in radians."""


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of C candidate joints.

    Attributes:
        lower ([C]): Lower limits, at most 0, in radians or lengths.
        upper ([C]): Upper limits, at least 0.
        unlimited ([C] bool): True for hinges without limits, such as wheels and knobs.
        freedom ([C]): Share of the wanted travel that is free of collisions, in [0, 1].
    """

    lower: F64
    upper: F64
    unlimited: NDArray[np.bool_]
    freedom: F64

    def range(self, index: int) -> tuple[float | None, float | None]:
        """Lower and upper limit of one candidate; (None, None) if it has no limits."""
        if self.unlimited[index]:
            return None, None
        return float(self.lower[index]), float(self.upper[index])


def estimate_joint_limits(
    meshes: _core.Meshes, moving: Sequence[int], obstacles: Sequence[int], candidates: CandidateJoints, points: F64
) -> JointLimits:
    """Limits of every candidate joint of one part with the points [n, 3], in the normalised frame.

    `moving` are the positions of the leaves that move, with those of the part's descendants. `obstacles` are those that stay.
    """
    slides = candidates.kinds != JointKind.REVOLUTE.code
    lengths = np.ptp(points @ candidates.directions.T, axis=0)
    reach = np.where(slides, np.maximum(lengths, 1e-6), math.pi)
    lower, upper = -reach, reach
    if obstacles:  # screws are swept as sliders
        codes = np.where(slides, JointKind.PRISMATIC.code, candidates.kinds).astype(np.uint8)
        axes = candidates.directions, candidates.pivots
        lower, upper, _ = _core.sweep(meshes, list(moving), list(obstacles), codes, *axes, lower, upper)
    wanted = np.where(slides, FREE_SLIDE * reach, FREE_ANGLE)
    freedom = np.clip(np.maximum(upper, -lower) / wanted, 0.0, 1.0)
    middle, size = 0.5 * (points.min(axis=0) + points.max(axis=0)), np.linalg.norm(np.ptp(points, axis=0))
    axis_distance = np.linalg.norm(np.cross(middle - candidates.pivots, candidates.directions), axis=1)
    all_round = (upper >= FULL_TURN) & (lower <= -FULL_TURN)
    unlimited = ~slides & (axis_distance < MAX_WHEEL_OFFSET * size) & all_round
    is_outward = np.where(np.abs(lower + upper) > SAME_TRAVEL * reach, lower + upper > 0, candidates.directions @ middle >= 0)
    is_forward = ~is_outward if size < MAX_BUTTON_SIZE else is_outward
    slide = SLIDE_RANGE * reach
    lower = np.where(slides, np.where(is_forward, 0.0, -slide), np.maximum(lower, -MAX_HINGE_ANGLE))
    upper = np.where(slides, np.where(is_forward, slide, 0.0), np.minimum(upper, MAX_HINGE_ANGLE))
    return JointLimits(lower, upper, unlimited, freedom)
