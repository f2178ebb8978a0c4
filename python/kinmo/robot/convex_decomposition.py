"""Convex pieces of parts for collisions.

A loose piece that is about convex stays whole. Boards are taken apart along the planes of their faces. CoACD divides the rest.
Flat pieces become thin boxes, since simulators refuse flat meshes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.loose_pieces import pieces_of_faces
from kinmo.core.shape import Mesh
from kinmo.robot.coacd_pieces import divided, is_installed
from kinmo.robot.collision_shapes import CollisionShape
from kinmo.robot.convex_hulls import hull_of, simplest_shape
from kinmo.robot.plane_cuts import CONVEX_TOLERANCE, MIN_THICKNESS, bisected, concavity, cut_at_faces

MAX_LOOSE_PIECES = 64
"""Most loose pieces of a part. The smallest ones are one piece together."""


def convex_shapes(meshes: Sequence[Mesh], diagonal: float) -> tuple[list[list[CollisionShape]], int]:
    """Convex shapes that together cover each part.

    Args:
        meshes: The surfaces of the parts.
        diagonal: Diagonal of the whole object.

    Returns:
        The shapes of each part, and the number of concave pieces that were bisected, since CoACD is not installed or failed.
    """
    shapes: list[list[CollisionShape]] = [[] for _ in meshes]
    concave: list[tuple[int, Mesh]] = []

    def hull(points: NDArray[np.float64]) -> Mesh:
        return hull_of(points, MIN_THICKNESS * diagonal)

    for place, mesh in enumerate(meshes):
        pieces = pieces_of_faces(mesh, most=MAX_LOOSE_PIECES)
        for number in range(int(pieces.max()) + 1):
            piece = Mesh(mesh.vertices, mesh.faces[pieces == number]).compact
            whole = hull(piece.vertices)
            if concavity(piece, whole) <= CONVEX_TOLERANCE * diagonal:
                shapes[place].append(simplest_shape(whole))
            elif (boards := cut_at_faces(piece, diagonal)) is not None:
                shapes[place] += [simplest_shape(hull(points)) for points in boards]
            else:
                concave.append((place, piece))
    found = divided([piece for _, piece in concave]) if is_installed() else [None] * len(concave)
    for (place, piece), parts in zip(concave, found, strict=True):
        corners = bisected(piece, diagonal) if parts is None else parts
        shapes[place] += [simplest_shape(hull(points)) for points in corners]
    return shapes, found.count(None)


def hull_shape(mesh: Mesh, diagonal: float) -> CollisionShape:
    """The convex hull of a part."""
    return simplest_shape(hull_of(mesh.corners, MIN_THICKNESS * diagonal))
