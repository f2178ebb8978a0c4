"""Candidate joints of a movable part (paper, section 3.3).

A box has 12 edges and 3 centre lines. Which of its three axes is *vertical* is a matter of order, not of angle: the one nearest
to `up` is, the other two are horizontal; so each type has as many candidates whatever the box.

| type | candidates | with a contact pivot |
|---|---|---|
| R_H_S, R_V_S | the 8 horizontal edges, the 4 vertical ones | +2, +1 (the release) |
| R_H_C, R_V_C | the 2 horizontal centre lines, the vertical one | +2, +1 (the paper) |
| P_H, P_V | the 2 horizontal axes, the vertical one | |
| PR_H, PR_V | the 2 horizontal centre lines, the vertical one | +2, +1 (the release) |
| R, P, PR (coarse) | all edges and centre lines; all axes; all centre lines | +3, none, +3 (the release) |
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo.core.box import Box
from kinmo.core.joint import KINDS, CoarseType, JointKind, MotionType
from kinmo.features.candidate_lines import Lines, Source, distinct_directions

F64 = NDArray[np.float64]
ContactPivots = Literal["central", "revolute", "none"]

EDGE_SIGNS = np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)], float)
SAME_ANGLE = np.cos(np.radians(0.1))
SAME_DISTANCE = 1e-3


@dataclass(frozen=True, eq=False)
class Candidates:
    """C candidate joints: `kinds` [C] uint8 (`JointKind.code`), unit `directions` [C, 3], `pivots` [C, 3], `sources` [C] (words)."""

    kinds: NDArray[np.uint8]
    directions: F64
    pivots: F64
    sources: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.kinds)

    def kind(self, index: int) -> JointKind:
        return KINDS[int(self.kinds[index])]


def paper_candidates(
    motion: MotionType | CoarseType,
    box: Box,
    up: F64,
    contact: F64 | None = None,
    contact_pivots: ContactPivots = "central",
) -> Candidates:
    """The paper's candidates for a part of motion type `motion` with the oriented box `box`; see the table above.

    `contact` [3] is the centroid of the interaction region with the reference part, a second pivot for axes through the middle:
    `central` for the C types only (as printed), `revolute` for every axis that turns (as released), or `none`. FIXED and NONE
    have no candidates.
    """
    kind = motion.kind
    if kind is None:
        return no_candidates()
    order = np.argsort(-np.abs(box.axes @ up), kind="stable")
    axes = order
    if isinstance(motion, MotionType):
        axes = order[:1] if motion.is_vertical else order[1:]
    found: list[tuple[int, F64, str]] = []
    on_side = isinstance(motion, CoarseType) or not motion.is_central
    if kind is JointKind.REVOLUTE and on_side:
        found += [(a, pivot, "box edge") for a in axes for pivot in edge_midpoints(box, a)]
    if kind is not JointKind.REVOLUTE or isinstance(motion, CoarseType) or motion.is_central:
        found += [(a, box.center, "box centre") for a in axes]
    central = isinstance(motion, MotionType) and motion.is_central
    wanted = (contact_pivots == "central" and central) or (contact_pivots == "revolute" and kind is not JointKind.PRISMATIC)
    if contact is not None and wanted:
        found += [(a, contact, "interaction region") for a in axes]
    return Candidates(
        np.full(len(found), kind.code, np.uint8),
        box.axes[[a for a, _, _ in found]],
        np.array([pivot for _, pivot, _ in found]),
        tuple(source for _, _, source in found),
    )


def edge_midpoints(box: Box, axis: int) -> F64:
    """Midpoints [4, 3] of the box's edges along `axis`."""
    first, second = (i for i in range(3) if i != axis)
    spread = EDGE_SIGNS[:, :1] * box.half_extents[first] * box.axes[first]
    midpoints: F64 = box.center + spread + EDGE_SIGNS[:, 1:] * box.half_extents[second] * box.axes[second]
    return midpoints


def no_candidates() -> Candidates:
    """None at all."""
    return Candidates(np.empty(0, np.uint8), np.empty((0, 3)), np.empty((0, 3)), ())


def line_candidates(motion: MotionType | CoarseType, lines: Lines, up: F64, sources: Sequence[Source]) -> Candidates:
    """Those of `lines` (`hypotheses.candidate_lines`) that come from one of `sources` and fit the motion type.

    A fine type asks for an axis on its side of 45 degrees from `up`, unless no line is there. Whether an axis is central is
    left to the score. Prismatic joints get one candidate a direction.
    """
    kind = motion.kind
    if kind is None or len(lines) == 0:
        return no_candidates()
    chosen = np.flatnonzero(lines.sources[:, list(sources)].any(axis=1))
    if kind is JointKind.PRISMATIC:
        chosen = np.intersect1d(chosen, distinct_directions(lines))
    if isinstance(motion, MotionType):
        vertical = np.abs(lines.directions[chosen] @ up) > np.cos(np.radians(45.0))
        fitting = chosen[vertical == motion.is_vertical]
        chosen = fitting if len(fitting) else chosen
    names = tuple(Source(int(np.argmax(lines.sources[i]))).name.lower().replace("_", " ") for i in chosen)
    kinds = np.full(len(chosen), kind.code, np.uint8)
    return Candidates(kinds, lines.directions[chosen], lines.pivots[chosen], names)


def merged(*sets: Candidates) -> Candidates:
    """All candidates of several sets; of those that mean the same joint (0.1 degree, 1e-3 lengths) the first."""
    kinds = np.concatenate([s.kinds for s in sets])
    directions, pivots = (np.concatenate([getattr(s, name) for s in sets]) for name in ("directions", "pivots"))
    sources = [source for s in sets for source in s.sources]
    kept: list[int] = []
    for index in range(len(kinds)):
        parallel = np.abs(directions[kept] @ directions[index]) > SAME_ANGLE
        offset = pivots[kept] - pivots[index]
        across = np.linalg.norm(offset - (offset @ directions[index])[:, None] * directions[index], axis=1)
        slides = kinds[index] == JointKind.PRISMATIC.code
        if not (parallel & (kinds[kept] == kinds[index]) & (slides | (across < SAME_DISTANCE))).any():
            kept.append(index)
    return Candidates(kinds[kept], directions[kept], pivots[kept], tuple(sources[i] for i in kept))
