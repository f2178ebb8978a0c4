"""Triangles of polygons, for formats whose faces have any number of corners."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def triangle_fans(corners: NDArray[np.int64], sizes: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles [F, 3] of polygons, and the polygon [F] of each. Points and lines give none.

    Args:
        corners: vertices of all polygons, one after the other.
        sizes: number of corners of each polygon.
    """
    starts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    polygons = np.repeat(np.arange(len(sizes)), counts)
    first = starts[polygons]
    step = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1), polygons
