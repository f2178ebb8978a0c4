"""Surfaces for parts that a file gives as point clouds."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.shape import Mesh

_NEIGHBOURS = 8
"""Number of nearest neighbours that give the normal and the area of a point."""


def surface_of_points(points: NDArray[np.float64]) -> Mesh:
    """A mesh with one small equilateral triangle around each point of a sampled surface.

    A triangle lies in the plane of the nearest neighbours of its point and covers the area that belongs to the point. Areas,
    samples, boxes and distances match those of the sampled surface up to the spacing of the samples.

    Args:
        points: [n, 3] with n >= 3.

    Returns:
        A mesh with n faces.
    """
    count = min(_NEIGHBOURS, len(points) - 1)
    distances, indices = cKDTree(points).query(points, count + 1)
    offsets = points[indices] - points[:, None]
    _, axes = np.linalg.eigh(np.einsum("pki,pkj->pij", offsets, offsets))
    area = math.pi * distances[:, -1] ** 2 / count
    radius = np.sqrt(4.0 * area / (3.0 * math.sqrt(3.0)))
    angles = 2.0 * math.pi / 3.0 * np.arange(3)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    plane = np.moveaxis(axes[:, :, 1:], 2, 1)
    corners = points[:, None] + radius[:, None, None] * np.einsum("ck,pki->pci", circle, plane)
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(points), dtype=np.uint32).reshape(-1, 3))
