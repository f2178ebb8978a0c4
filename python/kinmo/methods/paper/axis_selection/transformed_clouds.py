"""Original and transformed point clouds of a shape, with the movable part labelled (paper, section 3.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.features.candidate_joints import CandidateJoints

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

MIN_SHARE = 0.25
"""Least share of a cloud's points on the moving part, and on the other parts, so that buttons are visible too."""

PARTNET_DIAGONAL = 2.0
"""Approximate diagonal of a PartNet shape in its own units, the unit of the release's translations."""

TURNS = np.radians([-80.0, -60.0, -45.0, -30.0, 30.0, 45.0, 60.0, 80.0])
"""Test angles of hinges, in radians (release)."""
SLIDES = np.linspace(-0.5, 0.5, 10) / PARTNET_DIAGONAL
"""Test distances of sliders, in diagonals (release)."""
SCREW_TURN = math.pi / 2
"""Test angle of screws, in radians (release)."""
SCREW_SLIDES = np.linspace(-0.023, 0.0257, 3) / PARTNET_DIAGONAL
"""Test distances of screws, in diagonals (release)."""

FOCUS_OVERSAMPLING = 4
"""Points drawn from the other parts for each point kept in a focused cloud."""
MIN_RADIUS = 0.1
"""Least radius of a focused cloud's unit sphere, in diagonals."""


@dataclass(frozen=True, eq=False)
class LabelledCloud:
    """Point cloud of a shape in which the moving part is labelled.

    Attributes:
        points ([n, 3] float32): Points in the normalised frame; the first `moving` points lie on the moving part.
        moving: Number of points on the moving part.
        center ([3]): Origin of the network's input.
        radius: Unit of length of the network's input, in diagonals.
    """

    points: F32
    moving: int
    center: F32
    radius: float

    def network_input(self, points: F32 | None = None) -> F32:
        """Input of the Siamese network: coordinates, and a label that is 1 on the moving part and 0 elsewhere.

        Args:
            points ([..., n, 3]): Transformed points of the cloud; None: its own points.

        Returns:
            [..., n, 4] float32.
        """
        points = self.points if points is None else points
        labelled = np.zeros((*points.shape[:-1], 4), np.float32)
        labelled[..., :3] = (points - self.center) / np.float32(self.radius)
        labelled[..., : self.moving, 3] = 1.0
        return labelled

    def transformed(self, kinds: NDArray[np.uint8], directions: F64, pivots: F64, angles: F64, shifts: F64) -> F32:
        """Points after D displacements along each of C joints.

        Args:
            kinds ([C]): Codes of the joint kinds.
            directions ([C, 3]): Unit vectors.
            pivots ([C, 3]): Points of the axes.
            angles ([C, D]): Rotations, in radians.
            shifts ([C, D]): Translations, in diagonals.

        Returns:
            [C, D, n, 3] float32; only points of the moving part change.
        """
        count = len(self.points)
        out = np.empty((*angles.shape, count, 3), np.float32)
        out[..., self.moving :, :] = self.points[self.moving :]
        part = np.ascontiguousarray(self.points[: self.moving])
        out[..., : self.moving, :] = _core.move_points(part, kinds, directions, pivots, angles, shifts)
        return out


def labelled_cloud(
    leaf_points: F32, leaf_areas: F64, moving: list[int], count: int, rng: np.random.Generator, *, focus: bool = False
) -> LabelledCloud:
    """Draw a cloud from the leaves of a shape, in proportion to area on the moving part and on the other parts.

    Args:
        leaf_points ([L, n, 3]): Samples of the leaves.
        leaf_areas ([L]): Surface areas.
        moving: Positions of the leaves that move.
        count: Number of points.
        rng: Source of the draws.
        focus: Draw more points of the other parts near the moving part, and centre and scale the input to the moving part. A
            button and a door then look alike.
    """
    rest = np.setdiff1d(np.arange(len(leaf_points)), moving)
    part = np.asarray(moving, np.int64)
    whole = max(float(leaf_areas.sum()), 1e-12)
    share = min(max(float(leaf_areas[part].sum()) / whole, MIN_SHARE), 1.0 - MIN_SHARE)
    on_part = round(share * count) if len(rest) else count
    drawn = _draw(leaf_points, leaf_areas, part, on_part, rng)
    if not focus:
        others = _draw(leaf_points, leaf_areas, rest, count - on_part, rng) if len(rest) else drawn[:0]
        return LabelledCloud(np.concatenate([drawn, others]), on_part, np.zeros(3, np.float32), 1.0)
    center = (drawn.min(axis=0) + drawn.max(axis=0)) / 2
    radius = max(float(np.linalg.norm(drawn - center, axis=1).max()), MIN_RADIUS)
    others = drawn[:0]
    if len(rest):
        others = _draw(leaf_points, leaf_areas, rest, FOCUS_OVERSAMPLING * (count - on_part), rng)
        density = 1.0 / (1.0 + np.square((others - center) / radius).sum(axis=1).astype(float)) ** 2
        others = others[rng.choice(len(others), count - on_part, replace=False, p=density / density.sum())]
    return LabelledCloud(np.concatenate([drawn, others]), on_part, center, radius)


def _draw(points: F32, areas: F64, leaves: NDArray[np.int64], count: int, rng: np.random.Generator) -> F32:
    """Draw `count` samples of some leaves in proportion to area."""
    stored = points.shape[1]
    weights = areas[leaves] if areas[leaves].sum() > 0 else np.ones(len(leaves))
    counts = rng.multinomial(count, weights / weights.sum())
    pieces = []
    for leaf, take in zip(leaves, counts, strict=True):
        order = rng.permutation(stored)
        pieces.append(points[leaf, np.resize(order, take)])
    return np.concatenate(pieces)


def displacements(kinds: NDArray[np.uint8]) -> tuple[F64, F64]:
    """Displacements that candidates are tested with, as in the release.

    Args:
        kinds ([C]): Codes of the candidates, all the same.

    Returns:
        Angles [C, D] in radians and shifts [C, D] in diagonals.
    """
    kind = int(kinds[0])
    if kind == JointKind.REVOLUTE.code:
        angles, shifts = TURNS, np.zeros(len(TURNS))
    elif kind == JointKind.PRISMATIC.code:
        angles, shifts = np.zeros(len(SLIDES)), SLIDES
    else:
        angles, shifts = np.full(len(SCREW_SLIDES), SCREW_TURN), SCREW_SLIDES
    return np.tile(angles, (len(kinds), 1)), np.tile(shifts, (len(kinds), 1))


def rows_by_kind(candidates: CandidateJoints) -> list[NDArray[np.int64]]:
    """Indices of the candidates of each kind."""
    return [np.flatnonzero(candidates.kinds == code) for code in np.unique(candidates.kinds)]
