"""Sampled surfaces with distance queries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from trimesh import triangles as trimesh_triangles

from kinmo.io.readers.urdf_meshes import Triangles

Points = NDArray[np.float64]
"""Points [N, 3]."""

NEIGHBOURS = 6
"""Nearest samples whose triangles a distance query looks at."""


def triangle_areas(triangles: Triangles) -> NDArray[np.float64]:
    """Areas [T] of triangles [T, 3, 3]."""
    sides = triangles[:, 1:] - triangles[:, :1]
    return np.asarray(0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))


class Surface:
    """Triangles with samples that are uniform by area. Each sample knows its triangle.

    Args:
        triangles: Triangles [T, 3, 3], connected or not.
        count: Number N of samples.
        rng: Source of random numbers.

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
        feet = closest_points(self.chosen[index].reshape(-1, 3, 3), np.repeat(queries, count, axis=0)).reshape(-1, count, 3)
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


def closest_points(triangles: Triangles, queries: Points) -> Points:
    """The nearest point [N, 3] of each triangle [N, 3, 3] to its query [N, 3]; not finite for a triangle without area."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(trimesh_triangles.closest_point(triangles, queries))  # type: ignore[no-untyped-call]


def sample_surfaces(pieces: Sequence[Triangles], total: int, min_samples: int, rng: np.random.Generator) -> list[Surface]:
    """Sample several surfaces with about `total` samples in proportion to their areas, and at least `min_samples` each."""
    areas = np.array([triangle_areas(piece).sum() for piece in pieces])
    share = areas / areas.sum() if areas.sum() > 0 else np.zeros(len(pieces))
    return [Surface(piece, max(min_samples, int(total * part)), rng) for piece, part in zip(pieces, share, strict=True)]
