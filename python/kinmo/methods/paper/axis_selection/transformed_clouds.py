"""Original and transformed point clouds of a shape, with the movable part labelled (paper, section 3.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind

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
TEST_DISPLACEMENTS = {JointKind.REVOLUTE: TURNS, JointKind.PRISMATIC: SLIDES, JointKind.SCREW: SCREW_SLIDES}
"""Displacements that candidates are tested with, whatever the range of a joint; training pairs have the same."""

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
        """Input [..., n, 4] of the Siamese network: coordinates, and a label that is 1 on the moving part and 0 elsewhere.

        It is made of transformed points [..., n, 3] of the cloud, or of its own points.
        """
        points = self.points if points is None else points
        labelled = np.zeros((*points.shape[:-1], 4), np.float32)
        labelled[..., :3] = (points - self.center) / np.float32(self.radius)
        labelled[..., : self.moving, 3] = 1.0
        return labelled

    def transformed(self, kinds: NDArray[np.uint8], directions: F64, pivots: F64, angles: F64, shifts: F64) -> F32:
        """Points [C, D, n, 3] after D rotations `angles` [C, D] and translations `shifts` [C, D] along each of C joints.

        Only points of the moving part change.
        """
        out = np.empty((*angles.shape, len(self.points), 3), np.float32)
        out[..., self.moving :, :] = self.points[self.moving :]
        part = np.ascontiguousarray(self.points[: self.moving])
        out[..., : self.moving, :] = _core.move_points(part, kinds, directions, pivots, angles, shifts)
        return out


def labelled_cloud(
    leaf_points: F32, leaf_areas: F64, moving: list[int], count: int, rng: np.random.Generator, *, focus: bool = False
) -> LabelledCloud:
    """Draw a cloud of `count` points from the leaves of a shape, in proportion to area on the moving part and on the others.

    With `focus`, more points of the other parts are drawn near the moving part, and the input is centred and scaled to the
    moving part. A button and a door then look alike.
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


def angles_and_shifts(kind: JointKind, values: F64) -> tuple[F64, F64]:
    """Rotations in radians and translations in diagonals that move a joint by some values; a screw turns by `SCREW_TURN`."""
    zeros = np.zeros_like(values)
    if kind is JointKind.REVOLUTE:
        return values, zeros
    return zeros if kind is JointKind.PRISMATIC else np.full_like(values, SCREW_TURN), values
