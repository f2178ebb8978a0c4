"""Convex pieces of parts for collisions: loose pieces where they are about convex, and what CoACD divides the others into.

Flat pieces become thin boxes, since simulators refuse flat meshes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from kinmo import _core
from kinmo.core.loose_pieces import pieces_of_faces
from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh
from kinmo.robot.coacd_pieces import divided, is_installed
from kinmo.robot.collision_shapes import CollisionShape, Hull

MAX_LOOSE_PIECES = 64
"""Most loose pieces of a part. The smallest ones are one piece together."""
CONVEX_TOLERANCE = 0.01
"""Largest distance of a hull from the surface inside it that still counts as convex, in diagonals of the object."""
MIN_THICKNESS = 0.002
"""Least thickness of a piece, in diagonals of the object."""
BOX_FILL = 0.99
"""Least share of its box that a hull fills to be replaced by it."""
SAMPLES = 400
"""Points on a hull that its distance from the surface is measured at."""
MAX_BISECTED = 32
"""Most pieces of a surface that is bisected."""
MAX_HULL_VERTICES = 64
"""Most vertices of a hull."""


def convex_shapes(meshes: Sequence[Mesh], diagonal: float) -> tuple[list[list[CollisionShape]], int]:
    """Convex shapes that together cover each part.

    Args:
        meshes: The surfaces of the parts.
        diagonal: Diagonal of the whole object.

    Returns:
        The shapes of each part, and the number of concave pieces that were bisected, since CoACD is not installed or failed.
    """
    thickness = MIN_THICKNESS * diagonal
    shapes: list[list[CollisionShape]] = [[] for _ in meshes]
    concave: list[tuple[int, Mesh]] = []
    for place, mesh in enumerate(meshes):
        pieces = pieces_of_faces(mesh, most=MAX_LOOSE_PIECES)
        for number in range(int(pieces.max()) + 1):
            piece = Mesh(mesh.vertices, mesh.faces[pieces == number]).compact
            hull = hull_of(piece.vertices, thickness)
            if concavity(piece, hull) > CONVEX_TOLERANCE * diagonal:
                concave.append((place, piece))
            else:
                shapes[place].append(simplest_shape(hull))
    found = divided([piece for _, piece in concave]) if is_installed() else [None] * len(concave)
    for (place, piece), parts in zip(concave, found, strict=True):
        points = bisected(piece, diagonal) if parts is None else parts
        shapes[place] += [simplest_shape(hull_of(each, thickness)) for each in points]
    return shapes, found.count(None)


def bisected(piece: Mesh, diagonal: float) -> list[NDArray[np.float64]]:
    """Corners [P, 3] of a piece, bisected across its longest side, and again where the halves are least convex.

    This is coarse and fast. `diagonal` is that of the object.
    """
    done: list[Mesh] = []
    waiting: list[tuple[float, Mesh]] = [(np.inf, piece)]
    while waiting and len(done) + len(waiting) < MAX_BISECTED:
        waiting.sort(key=lambda each: each[0])
        _, widest = waiting.pop()
        center, axes, _ = box_of(widest.vertices)
        for normal in (axes[0], -axes[0]):
            half = _cut(widest, normal, center)
            depth = concavity(half, hull_of(half.vertices, MIN_THICKNESS * diagonal)) if len(half.faces) else 0.0
            if depth > CONVEX_TOLERANCE * diagonal:
                waiting.append((depth, half))
            elif len(half.faces):
                done.append(half)
    return [each.vertices for each in (*done, *(half for _, half in waiting))]


def _cut(mesh: Mesh, normal: NDArray[np.float64], origin: NDArray[np.float64]) -> Mesh:
    """The part of a surface in front of a plane."""
    from trimesh.intersections import slice_faces_plane  # trimesh takes long to import, and few exports need it

    faces = mesh.faces.astype(np.int64)
    vertices, faces, _ = slice_faces_plane(mesh.vertices, faces, normal, origin)  # type: ignore[no-untyped-call]
    return Mesh(np.asarray(vertices, np.float64), np.asarray(faces, np.uint32)).compact


def hull_shape(mesh: Mesh, diagonal: float) -> CollisionShape:
    """The convex hull of a part."""
    return simplest_shape(hull_of(mesh.corners, MIN_THICKNESS * diagonal))


def hull_of(points: NDArray[np.float64], thickness: float) -> Mesh:
    """Convex hull of points [P, 3], made at least as thick as `thickness` in the directions of its box.

    The triangles face outwards.
    """
    center, axes, half = box_of(points)
    least = 0.5 * thickness
    for axis in np.flatnonzero(half < least):
        aside = (least - half[axis]) * axes[axis]
        points = np.concatenate([points + aside, points - aside])
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


def concavity(piece: Mesh, hull: Mesh) -> float:
    """Largest distance of the hull of a piece from its surface, but for the twentieth of the hull that is farthest."""
    meshes = _core.Meshes([piece.vertices], [piece.faces])
    points, _, _ = _core.sample_surface(_core.Meshes([hull.vertices], [hull.faces]), SAMPLES)
    distances, _, _ = _core.closest_points(meshes, [0], points[0].astype(np.float64))
    return float(np.quantile(distances, 0.95))


def simplest_shape(hull: Mesh, fill: float = BOX_FILL) -> CollisionShape:
    """The box of a hull that fills it to the share `fill`, else the hull, with at most `MAX_HULL_VERTICES` vertices."""
    center, axes, half = box_of(hull.vertices)
    volume = float(np.einsum("fx,fx->f", *_cross_and_corner(hull)).sum() / 6.0)
    if np.all(half > 0.0) and volume >= fill * 8.0 * float(np.prod(half)):
        return Box(center, axes, half)
    return Hull(fewer_vertices(hull))


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


def _cross_and_corner(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    a, b, c = np.moveaxis(mesh.triangles - mesh.vertices.mean(axis=0), 1, 0)
    return np.cross(a, b), c
