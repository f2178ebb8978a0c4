"""Sampled surfaces with distance queries, and the matching of predicted bodies with true parts by their surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from trimesh.triangles import closest_point

from kinmo.evaluation.hierarchy_given import one_to_one
from kinmo.io.readers.robot_bodies import Triangles

Points = NDArray[np.float64]  # points [N, 3]

NEIGHBOURS = 6  # nearest samples whose triangles a distance query looks at
MAX_DISTANCE = 0.01  # largest distance of a point from a surface that it lies on, in diagonals
TIE_DISTANCE = 5e-4
"""A point also lies on surfaces that are at most this much farther than the nearest one, in diagonals."""


def triangle_areas(triangles: Triangles) -> NDArray[np.float64]:
    """Areas [T] of triangles [T, 3, 3]."""
    sides = triangles[:, 1:] - triangles[:, :1]
    return np.asarray(0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))


class Surface:
    """Triangles [T, 3, 3], connected or not, with N samples that are uniform by area.

    Attributes:
        points: The samples [N, 3].
        chosen: The triangle [N, 3, 3] of each sample.
        low, high: Corners [3] of the axis-aligned box.
    """

    def __init__(self, triangles: Triangles, count: int, rng: np.random.Generator) -> None:
        areas = triangle_areas(triangles)
        total = areas.sum()
        self.chosen: Triangles = triangles[rng.choice(len(triangles), count, p=areas / total if total > 0 else None)]
        # Uniform in the triangle: fold the unit square along its diagonal.
        weights = rng.random((count, 2))
        weights = np.where(weights.sum(axis=1, keepdims=True) > 1.0, 1.0 - weights, weights)
        corner, sides = self.chosen[:, 0], self.chosen[:, 1:] - self.chosen[:, :1]
        self.points: Points = corner + np.einsum("nk,nkd->nd", weights, sides)
        self.low, self.high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
        self._tree = cKDTree(self.points)

    @property
    def diagonal(self) -> float:
        """Diagonal of the axis-aligned box."""
        return float(np.linalg.norm(self.high - self.low))

    @property
    def middle(self) -> Points:
        """Middle [3] of the axis-aligned box."""
        return np.asarray(0.5 * (self.low + self.high))

    def nearest(self, queries: Points, neighbours: int = NEIGHBOURS) -> tuple[NDArray[np.float64], Points]:
        """Distance [N] of each query [N, 3] from the surface, and the nearest point [N, 3] of the surface.

        Exact on the triangles of the `neighbours` nearest samples, and never more than the distance to the nearest sample.
        """
        count = min(neighbours, len(self.points))
        _, index = self._tree.query(queries, k=list(range(1, count + 1)))
        triangles, repeated = self.chosen[index].reshape(-1, 3, 3), np.repeat(queries, count, axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            feet = closest_point(triangles, repeated).reshape(-1, count, 3)  # type: ignore[no-untyped-call]
        feet = np.where(np.isfinite(feet), feet, self.points[index])  # a triangle without area has no foot
        distances = np.linalg.norm(feet - queries[:, None], axis=2)
        best = distances.argmin(axis=1)[:, None]
        return np.take_along_axis(distances, best, 1)[:, 0], np.take_along_axis(feet, best[..., None], 1)[:, 0]

    def distances_within(self, queries: Points, reach: float) -> NDArray[np.float64]:
        """Distance [N] of each query [N, 3] from the surface; infinite if it is farther than `reach` from the surface's box."""
        distances = np.full(len(queries), np.inf)
        near = np.all((queries >= self.low - reach) & (queries <= self.high + reach), axis=1)
        if near.any():
            distances[near] = self.nearest(queries[near])[0]
        return distances


def sample_surfaces(pieces: Sequence[Triangles], total: int, min_samples: int, rng: np.random.Generator) -> list[Surface]:
    """Sample several surfaces with about `total` samples in proportion to their areas, and at least `min_samples` each."""
    areas = np.array([triangle_areas(piece).sum() for piece in pieces])
    share = areas / areas.sum() if areas.sum() > 0 else np.zeros(len(pieces))
    return [Surface(piece, max(min_samples, int(total * part)), rng) for piece, part in zip(pieces, share, strict=True)]


@dataclass(frozen=True, eq=False)
class Match:
    """A matching of K true parts with B bodies: overlaps [K, B], and the body of every matched part.

    `home` is the body that holds most of each part's surface, None if no body holds any.
    """

    iou: NDArray[np.float64]
    body_of: dict[int, int]
    home: tuple[int | None, ...]


def match_parts(parts: Sequence[Surface], junk: NDArray[np.bool_], bodies: Sequence[Surface], diagonal: float) -> Match:
    """Match K true parts, with a mask [K] of junk, with B bodies one to one, so that the total overlap of surfaces is largest.

    Let r be the share of a part that lies on a body. Let p be the share of the body that lies on the part, without surface that
    lies on junk or on nothing. The overlap is rp / (r + p - rp), the intersection over union of two sets with these shares.
    """
    recall, _ = surface_shares(parts, bodies, diagonal)
    precision, on_any = surface_shares(bodies, parts, diagonal)
    counted = np.maximum(on_any - precision[:, junk].sum(axis=1), 1e-9)
    precision = np.clip(precision / counted[:, None], 0.0, 1.0).T
    shared = recall * precision
    iou = np.divide(shared, recall + precision - shared, out=np.zeros_like(shared), where=shared > 0)
    iou[junk] = 0.0
    home = tuple(int(row.argmax()) if row.max() > 0 else None for row in recall)
    return Match(iou, one_to_one(iou), home)


def surface_shares(
    sources: Sequence[Surface], targets: Sequence[Surface], diagonal: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shares [S, T] of S surfaces that lie on each of T other ones, and shares [S] that lie on any of these."""
    shares, on_any = np.zeros((len(sources), len(targets))), np.zeros(len(sources))
    for index, source in enumerate(sources):
        distances = np.stack([target.distances_within(source.points, MAX_DISTANCE * diagonal) for target in targets], axis=1)
        nearest = distances.min(axis=1, keepdims=True)
        on_some = nearest <= MAX_DISTANCE * diagonal
        shares[index] = ((distances <= nearest + TIE_DISTANCE * diagonal) & on_some).mean(axis=0)
        on_any[index] = on_some.mean()
    return shares, on_any
