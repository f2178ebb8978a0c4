"""How far a part can go along a joint before it runs into the rest, and how far it is taken to go.

A sweep says how far a part is free. That alone makes poor limits of sliders: thin walls stop nothing, parts overlap at rest,
and a button is pressed into what it touches. So sliders go a fixed share of their length, chosen on procedural shapes, and the
sweep says to which side.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.features.candidate_joints import Candidates

F64 = NDArray[np.float64]

MOST_TURN = math.pi / 2
"""How far a hinge that nothing stops is taken to open, unless it may go all the way round."""
WANTED_TURN = math.pi / 3
WANTED_SLIDE = 0.5
"""What a joint must reach in one sense to be as good as free: an angle, or a share of the part's length along the axis."""

PRESSED_SIZE = 0.15
"""A slider with a smaller diagonal (of the object's) is pressed in, like a button; a larger one is drawn out, like a drawer."""
SLIDE = 0.65
"""How far either goes, as a share of its length along the axis."""
EVEN = 0.01
"""Of the reach: free lengths that differ by less do not tell which side is freer, so that away from the middle is taken."""

CENTRAL = 0.1
"""An axis nearer to the part's middle than this share of its diagonal may turn for ever, as a wheel or a knob does."""


@dataclass(frozen=True, eq=False)
class Travel:
    """Of C candidates: how far the part is taken to go backwards and forwards, `lower` <= 0 <= `upper` [C], radians or lengths.

    `unlimited` [C]: it may turn for ever. `freedom` [C] in [0, 1]: how much of what a joint must reach is free.
    """

    lower: F64
    upper: F64
    unlimited: NDArray[np.bool_]
    freedom: F64

    def range(self, index: int) -> tuple[float | None, float | None]:
        """Lower and upper limit of one candidate; None, None if it has none."""
        if self.unlimited[index]:
            return None, None
        return float(self.lower[index]), float(self.upper[index])


def free_travel(
    meshes: _core.Meshes, moving: Sequence[int], obstacles: Sequence[int], candidates: Candidates, points: F64
) -> Travel:
    """Sweep the leaves `moving` (indices of meshes, the part's descendants among them) along each candidate.

    `points` [n, 3] lie on the part. Everything is in the normalised frame.
    """
    slides = candidates.kinds != JointKind.REVOLUTE.code
    lengths = np.ptp(points @ candidates.directions.T, axis=0)
    reach = np.where(slides, np.maximum(lengths, 1e-6), math.pi)
    lower, upper = _free(meshes, moving, obstacles, candidates, slides, reach)
    wanted = np.where(slides, WANTED_SLIDE * reach, WANTED_TURN)
    freedom = np.clip(np.maximum(upper, -lower) / wanted, 0.0, 1.0)
    middle, size = 0.5 * (points.min(axis=0) + points.max(axis=0)), np.linalg.norm(np.ptp(points, axis=0))
    off_axis = np.linalg.norm(np.cross(middle - candidates.pivots, candidates.directions), axis=1)
    all_round = (upper >= 0.999 * math.pi) & (lower <= -0.999 * math.pi)
    round_about = ~slides & (off_axis < CENTRAL * size) & all_round
    is_outwards = np.where(np.abs(lower + upper) > EVEN * reach, lower + upper > 0, candidates.directions @ middle >= 0)
    is_forwards = ~is_outwards if size < PRESSED_SIZE else is_outwards
    slide = SLIDE * reach
    lower = np.where(slides, np.where(is_forwards, 0.0, -slide), np.maximum(lower, -MOST_TURN))
    upper = np.where(slides, np.where(is_forwards, slide, 0.0), np.minimum(upper, MOST_TURN))
    return Travel(lower, upper, round_about, freedom)


def _free(
    meshes: _core.Meshes,
    moving: Sequence[int],
    obstacles: Sequence[int],
    candidates: Candidates,
    slides: NDArray[np.bool_],
    reach: F64,
) -> tuple[F64, F64]:
    """How far [C] each candidate goes down and up before something is in the way, at most `reach`; screws go straight."""
    if not obstacles:
        return -reach, reach.copy()
    codes = np.where(slides, JointKind.PRISMATIC.code, candidates.kinds).astype(np.uint8)
    lower, upper, _ = _core.sweep(
        meshes, list(moving), list(obstacles), codes, candidates.directions, candidates.pivots, -reach, reach
    )
    return lower, upper
