"""Clouds of a shape with the part that moves marked, and moved."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.features.candidate_joints import Candidates

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

LEAST_SHARE = 0.25
"""Of a cloud's points, at least this share lies on the moving part and on the rest: a button has to be seen too."""

PARTNET_DIAGONAL = 2.0
"""About the diagonal of a PartNet shape in its own units, in which the release gives its translations."""

TURNS = np.radians([-80.0, -60.0, -45.0, -30.0, 30.0, 45.0, 60.0, 80.0])
SLIDES = np.linspace(-0.5, 0.5, 10) / PARTNET_DIAGONAL
SCREW_TURN = math.pi / 2
SCREW_SLIDES = np.linspace(-0.023, 0.0257, 3) / PARTNET_DIAGONAL


CANDIDATES = 4
"""So many points of the rest are drawn for one that is kept, where the cloud is focused."""

LEAST_REACH = 0.1
"""Half the size, in diagonals, of the smallest surroundings that a focused cloud looks at."""


@dataclass(frozen=True, eq=False)
class MarkedCloud:
    """`points` [n, 3] float32 of a shape in the normalised frame; the first `moving` of them lie on the part that moves.

    The network sees them from `center` [3], in units of `reach`.
    """

    points: F32
    moving: int
    center: F32
    reach: float

    def shown(self, points: F32 | None = None) -> F32:
        """What the network sees [..., n, 4] of the cloud, or of `points` [..., n, 3] that it was moved to: places, and a mark,
        1 on the moving part and 0 elsewhere.
        """
        points = self.points if points is None else points
        seen = np.zeros((*points.shape[:-1], 4), np.float32)
        seen[..., :3] = (points - self.center) / np.float32(self.reach)
        seen[..., : self.moving, 3] = 1.0
        return seen

    def moved(self, kinds: NDArray[np.uint8], directions: F64, pivots: F64, angles: F64, shifts: F64) -> F32:
        """The cloud [C, D, n, 3] after each of D displacements [C, D] along each of C joints (as in `_core.move_points`)."""
        count = len(self.points)
        out = np.empty((*angles.shape, count, 3), np.float32)
        out[..., self.moving :, :] = self.points[self.moving :]
        part = np.ascontiguousarray(self.points[: self.moving])
        out[..., : self.moving, :] = _core.move_points(part, kinds, directions, pivots, angles, shifts)
        return out


def marked_cloud(
    leaf_points: F32, leaf_areas: F64, moving: list[int], count: int, rng: np.random.Generator, *, focus: bool = False
) -> MarkedCloud:
    """`count` points drawn from the leaves [L, n, 3], by area on either side; `moving` are places of leaves.

    With `focus` the points of the rest are the denser the nearer they are to the part, and the network sees the cloud from the
    part's middle, in units of its size: a button and a door then look alike in what matters.
    """
    rest = np.setdiff1d(np.arange(len(leaf_points)), moving)
    part = np.asarray(moving, np.int64)
    whole = max(float(leaf_areas.sum()), 1e-12)
    share = min(max(float(leaf_areas[part].sum()) / whole, LEAST_SHARE), 1.0 - LEAST_SHARE)
    on_part = round(share * count) if len(rest) else count
    drawn = _drawn(leaf_points, leaf_areas, part, on_part, rng)
    if not focus:
        others = _drawn(leaf_points, leaf_areas, rest, count - on_part, rng) if len(rest) else drawn[:0]
        return MarkedCloud(np.concatenate([drawn, others]), on_part, np.zeros(3, np.float32), 1.0)
    center = (drawn.min(axis=0) + drawn.max(axis=0)) / 2
    reach = max(float(np.linalg.norm(drawn - center, axis=1).max()), LEAST_REACH)
    others = drawn[:0]
    if len(rest):
        others = _drawn(leaf_points, leaf_areas, rest, CANDIDATES * (count - on_part), rng)
        odds = 1.0 / (1.0 + np.square((others - center) / reach).sum(axis=1).astype(float)) ** 2
        others = others[rng.choice(len(others), count - on_part, replace=False, p=odds / odds.sum())]
    return MarkedCloud(np.concatenate([drawn, others]), on_part, center, reach)


def _drawn(points: F32, areas: F64, leaves: NDArray[np.int64], count: int, rng: np.random.Generator) -> F32:
    stored = points.shape[1]
    weights = areas[leaves] if areas[leaves].sum() > 0 else np.ones(len(leaves))
    takes = rng.multinomial(count, weights / weights.sum())
    pieces = []
    for leaf, take in zip(leaves, takes, strict=True):
        order = rng.permutation(stored)
        pieces.append(points[leaf, np.resize(order, take)])
    return np.concatenate(pieces)


def displacements(kinds: NDArray[np.uint8]) -> tuple[F64, F64]:
    """Angles and shifts [C, D] to judge candidates of `kinds` [C] by, all of one kind: those of the release."""
    kind = int(kinds[0])
    if kind == JointKind.REVOLUTE.code:
        angles, shifts = TURNS, np.zeros(len(TURNS))
    elif kind == JointKind.PRISMATIC.code:
        angles, shifts = np.zeros(len(SLIDES)), SLIDES
    else:
        angles, shifts = np.full(len(SCREW_SLIDES), SCREW_TURN), SCREW_SLIDES
    return np.tile(angles, (len(kinds), 1)), np.tile(shifts, (len(kinds), 1))


def of_one_kind(candidates: Candidates) -> list[NDArray[np.int64]]:
    """Indices of the candidates, grouped by kind."""
    return [np.flatnonzero(candidates.kinds == code) for code in np.unique(candidates.kinds)]
