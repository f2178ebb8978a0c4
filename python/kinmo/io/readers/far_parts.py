"""Stray parts of a file, so far from the object that they cannot belong to it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from kinmo.core.shape import Mesh

MIN_DISTANCE = 10.0
"""Least distance of a stray part from the object, in diagonals of the object."""
MAX_MESHES = 2000
"""Most meshes that are looked at."""


def far_parts(meshes: Mapping[int, Mesh]) -> list[int]:
    """Keys of the meshes that are far from the object, at most all but one.

    The object is the largest group of meshes that are less than `MIN_DISTANCE` times the larger one's diagonal apart.

    Args:
        meshes: Meshes with surfaces, in one frame.
    """
    keys = list(meshes)
    if not 1 < len(keys) <= MAX_MESHES:
        return []
    corners = [meshes[key].corners for key in keys]
    low, high = np.array([each.min(axis=0) for each in corners]), np.array([each.max(axis=0) for each in corners])
    sizes = np.linalg.norm(high - low, axis=1)
    if _extent(low, high) <= MIN_DISTANCE * sizes.max():
        return []
    near = _gaps(low, high, low[:, None], high[:, None]) < MIN_DISTANCE * np.maximum(sizes, sizes[:, None])
    count, group = connected_components(csr_array(near), directed=False)
    extents = [_extent(low[group == index], high[group == index]) for index in range(count)]
    largest = int(np.argmax(extents))
    own = group == largest
    away = _gaps(low, high, low[own].min(axis=0), high[own].max(axis=0)) > MIN_DISTANCE * extents[largest]
    return [key for key, is_far in zip(keys, away.tolist(), strict=True) if is_far]


def _extent(low: np.ndarray, high: np.ndarray) -> float:
    """Diagonal of the box around boxes."""
    return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))


def _gaps(low: np.ndarray, high: np.ndarray, lowest: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """Distances between axis-aligned boxes."""
    return np.asarray(np.linalg.norm(np.maximum(np.maximum(low - highest, lowest - high), 0.0), axis=-1))
