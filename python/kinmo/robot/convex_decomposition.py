"""Convex pieces of a part for collisions: its loose pieces where they are about convex, and what CoACD divides the others into.

Flat pieces become thin boxes, since simulators refuse flat meshes. CoACD: Wei et al., "Approximate Convex Decomposition for 3D
Meshes with Collision-Aware Concavity and Tree Search", SIGGRAPH 2022.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from kinmo import _core
from kinmo.core.loose_pieces import pieces_of_faces
from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh
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
MAX_HULL_VERTICES = 64
"""Most vertices of a hull."""


def convex_shapes(mesh: Mesh, diagonal: float) -> list[CollisionShape]:
    """Convex shapes that together cover a part.

    Args:
        mesh: The surface of the part.
        diagonal: Diagonal of the whole object.
    """
    shapes: list[CollisionShape] = []
    pieces = pieces_of_faces(mesh, most=MAX_LOOSE_PIECES)
    for number in range(int(pieces.max()) + 1):
        piece = Mesh(mesh.vertices, mesh.faces[pieces == number]).compact
        hull = hull_of(piece.vertices, MIN_THICKNESS * diagonal)
        if concavity(piece, hull) <= CONVEX_TOLERANCE * diagonal:
            shapes.append(simplest_shape(hull))
        else:
            shapes += [simplest_shape(hull_of(part.vertices, MIN_THICKNESS * diagonal)) for part in divided(piece)]
    return shapes


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


def simplest_shape(hull: Mesh) -> CollisionShape:
    """The box of a hull if it fills it, else the hull, with at most `MAX_HULL_VERTICES` vertices."""
    center, axes, half = box_of(hull.vertices)
    volume = float(np.einsum("fx,fx->f", *_cross_and_corner(hull)).sum() / 6.0)
    if volume >= BOX_FILL * 8.0 * float(np.prod(half)):
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




def divided(piece: Mesh) -> list[Mesh]:
    """Parts of a loose piece that are about convex, by CoACD."""
    import coacd

    coacd.set_log_level("error")
    found = coacd.run_coacd(
        coacd.Mesh(piece.vertices, piece.faces), threshold=0.05, max_convex_hull=16, mcts_iterations=40, mcts_nodes=12, resolution=1000
    )
    return [Mesh(np.asarray(vertices, np.float64), np.asarray(faces, np.uint32)) for vertices, faces in found]
