"""Patches of a mesh: its loose pieces, divided at concave creases.

Solids that touch often share vertices, so that one loose piece holds parts of several bodies. They meet at concave creases, or
share an edge of more than two faces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.loose_pieces import same_vertices
from kinmo.core.mesh_splitting import merge_small_parts
from kinmo.core.shape import Mesh

CREASE = np.radians(30.0)
"""Largest angle between the normals of two faces that belong together across a concave edge."""


def patches_of_faces(mesh: Mesh, pieces: NDArray[np.int64], *, most: int) -> NDArray[np.int64]:
    """Number of the patch of every face.

    Args:
        mesh: A mesh with at least one face.
        pieces: [F] numbers of the loose pieces of the faces, from 0 (`loose_pieces.pieces_of_faces`).
        most: Most patches, if there are fewer loose pieces; otherwise every loose piece is one patch. If there are more, the
            smallest ones are merged into the nearest ones of the same loose piece.

    Returns:
        [F] numbers from 0, those of a loose piece without gaps, in the order of the loose pieces.
    """
    if int(pieces.max()) + 1 >= most:
        return pieces
    corners, vertices, step = same_vertices(mesh)
    meshes = _core.Meshes([vertices], [corners.astype(np.uint32)])
    found = _core.surface_patches(meshes, 0, tolerance=2.0 * step, crease=float(CREASE))
    _, patches = np.unique(np.column_stack([pieces, found]), axis=0, return_inverse=True)
    patches = patches.ravel()
    if int(patches.max()) + 1 > most:
        patches = _fewer(mesh, pieces, patches, most)
    return np.asarray(np.unique(patches, return_inverse=True)[1].ravel(), np.int64)


def _fewer(mesh: Mesh, pieces: NDArray[np.int64], patches: NDArray[np.int64], most: int) -> NDArray[np.int64]:
    """The patches after merging the smallest ones of each loose piece, so that `most` are left."""
    areas = np.bincount(patches, weights=mesh.face_areas)
    _, first = np.unique(patches, return_index=True)
    piece_of = pieces[first]
    largest = np.lexsort((-areas, piece_of))
    is_largest = np.zeros(len(areas), bool)
    is_largest[largest[np.unique(piece_of[largest], return_index=True)[1]]] = True
    kept = np.lexsort((-areas, ~is_largest))[:most]
    quota = np.bincount(piece_of[kept])
    merged: NDArray[np.int64] = patches.copy()
    for piece in np.flatnonzero(np.bincount(piece_of) > quota):
        own = np.flatnonzero(pieces == piece)
        numbers, local = np.unique(patches[own], return_inverse=True)
        merged[own] = numbers[merge_small_parts(Mesh(mesh.vertices, mesh.faces[own]), local.ravel(), int(quota[piece]))]
    return merged
