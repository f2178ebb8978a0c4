"""Convex hulls of points, and the box, cylinder or polyhedron that a hull is written as."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from kinmo import _core
from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh
from kinmo.robot.collision_shapes import CollisionShape, Cylinder, Hull

BOX_FILL = 0.99
"""Least share of its box that a hull fills to be replaced by it."""
EXACT_FILL = 1.0 - 1e-9
"""The share that a box fills of itself."""
CYLINDER_FILL = 0.96
"""Least share of its cylinder that a hull fills to be replaced by it: a prism with 13 sides does."""
ROUNDNESS = 0.9
"""Least ratio of the two extents across the axis of a cylinder."""
MAX_HULL_VERTICES = 64
"""Most vertices of a hull."""


def hull_of(points: NDArray[np.float64], thickness: float) -> Mesh:
    """Convex hull of points [P, 3], made at least as thick as `thickness` in the directions of its box.

    The triangles face outwards.
    """
    hull, corners, least = None, points, 0.5 * thickness
    with suppress(QhullError):  # flat points have no hull until they are thick
        hull = ConvexHull(points - points.mean(axis=0))
        corners = points[hull.vertices]  # fewer points: their box is found faster
    center, axes, half = box_of(corners)
    thin = np.flatnonzero(half < least)
    for axis in thin:
        aside = (least - half[axis]) * axes[axis]
        corners = np.concatenate([corners + aside, corners - aside])
    if hull is None or len(thin):
        points = corners
        hull = ConvexHull(points - center)
    inside = points[hull.vertices].mean(axis=0)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    vertices, faces = points[used], faces.reshape(-1, 3)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    inward = np.einsum("fx,fx->f", np.cross(b - a, c - a), a - inside) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return Mesh(vertices, faces.astype(np.uint32))


def box_of(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Centre [3], axes as rows [3, 3] and half extents [3] of the smallest box around points [P, 3]."""
    faces = np.arange(len(points) // 3 * 3, dtype=np.uint32).reshape(-1, 3)
    rest = np.array([[len(points) - 1] * 3], np.uint32)
    centers, axes, half = _core.fit_boxes(_core.Meshes([points], [np.concatenate([faces, rest])]))
    return centers[0], axes[0], half[0]


def volume_of(mesh: Mesh) -> float:
    """Volume inside a closed surface that faces outwards."""
    a, b, c = np.moveaxis(mesh.triangles - mesh.vertices.mean(axis=0), 1, 0)
    return float(np.einsum("fx,fx->f", np.cross(a, b), c).sum() / 6.0)


def simplest_shape(hull: Mesh, is_exact: bool = False) -> CollisionShape:
    """The box or the cylinder of a hull if the hull about fills it, else the hull, with at most `MAX_HULL_VERTICES` vertices.

    If `is_exact`, only a box replaces a hull, and only the same box.
    """
    center, axes, half = box_of(hull.vertices)
    volume = volume_of(hull)
    if np.all(half > 0.0) and volume >= (EXACT_FILL if is_exact else BOX_FILL) * 8.0 * float(np.prod(half)):
        return Box(center, axes, half)
    for axis in range(0 if is_exact else 3):
        across = np.delete(half, axis)
        if across.min() > ROUNDNESS * across.max() and half[axis] > 0.0:
            cylinder = _cylinder_around(hull, center, axes[axis], half[axis])
            if volume >= CYLINDER_FILL * cylinder.volume:
                return cylinder
    return Hull(fewer_vertices(hull))


def _cylinder_around(hull: Mesh, center: NDArray[np.float64], axis: NDArray[np.float64], half_length: float) -> Cylinder:
    away = hull.vertices - center
    across = away - np.outer(away @ axis, axis)
    return Cylinder(center, axis, float(np.linalg.norm(across, axis=1).max()), half_length)


def fewer_vertices(hull: Mesh) -> Mesh:
    """A hull inside a hull, of the vertices that are farthest in evenly spread directions."""
    if len(hull.vertices) <= MAX_HULL_VERTICES:
        return hull
    count = np.arange(MAX_HULL_VERTICES) + 0.5
    polar, turn = np.arccos(1.0 - 2.0 * count / MAX_HULL_VERTICES), np.pi * (1.0 + 5.0**0.5) * count
    ways = np.column_stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)])
    scale = np.maximum(np.ptp(hull.vertices, axis=0), 1e-300)
    kept = np.unique(np.argmax(ways @ (hull.vertices / scale).T, axis=1))
    return hull_of(hull.vertices[kept], 0.0)
