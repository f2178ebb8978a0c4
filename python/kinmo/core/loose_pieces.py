"""Loose pieces of a mesh: its connected components, where vertices at the same place count as one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from kinmo.core.shape import Mesh

SAME_VERTEX = 5e-5
"""Step of the grid that vertices are rounded to before they are compared, in diagonals of the mesh."""
CELL_BITS = 21
"""Bits of a coordinate of a cell of that grid, where three coordinates form one number."""
MAX_PIECES = 400
"""Most pieces of one mesh."""


def loose_pieces(mesh: Mesh, *, most: int = MAX_PIECES) -> list[Mesh]:
    """Connected components of a mesh with at least one face, as `pieces_of_faces` numbers them."""
    pieces = pieces_of_faces(mesh, most=most)
    return [mesh.part(pieces == piece) for piece in range(int(pieces.max()) + 1)]


def pieces_of_faces(mesh: Mesh, *, most: int = MAX_PIECES) -> NDArray[np.int64]:
    """Number of the loose piece of every face.

    Args:
        mesh: A mesh with at least one face.
        most: Most pieces. If there are more, the smallest ones form one piece together.

    Returns:
        [F] numbers from 0, the piece with the largest area first.
    """
    corners, _, _ = same_vertices(mesh)
    edges = np.concatenate([corners[:, :2], corners[:, 1:]])
    count = int(corners.max()) + 1
    graph = coo_array((np.ones(len(edges), bool), (edges[:, 0], edges[:, 1])), shape=(count, count))
    _, component = connected_components(graph, directed=False)
    _, label = np.unique(component[corners[:, 0]], return_inverse=True)
    order = np.argsort(-np.bincount(label.ravel(), weights=mesh.face_areas), kind="stable")
    rank = np.minimum(np.argsort(order, kind="stable"), most - 1)
    return np.asarray(rank[label.ravel()], np.int64)


def same_vertices(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.float64], float]:
    """Corners of the faces where vertices at the same place have one index.

    Args:
        mesh: A mesh with at least one face.

    Returns:
        The indices [F, 3], the places [V, 3] that they mean, and the step of the grid that vertices were compared on.
    """
    used = mesh.corners
    low = used.min(axis=0)
    step = SAME_VERTEX * max(float(np.linalg.norm(used.max(axis=0) - low)), 1e-300)
    cells = np.round((mesh.vertices - low) / step).astype(np.int64)
    if cells.min() >= 0 and cells.max() < 1 << CELL_BITS:  # one number per cell, in the same order, sorts much faster
        keys = (cells[:, 0] << 2 * CELL_BITS) | (cells[:, 1] << CELL_BITS) | cells[:, 2]
        _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    else:  # vertices without a face may be far away
        _, first, place = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    return np.asarray(place.ravel()[mesh.faces], np.int64), mesh.vertices[first], step


def is_closed(mesh: Mesh) -> bool:
    """True if every edge of a mesh has two faces, where vertices at the same place count as one."""
    return bool((_faces_per_edge(mesh) == 2).all())


def has_border(mesh: Mesh) -> bool:
    """True if an edge of a mesh has an odd number of faces, as at a hole. Solids that share an edge have none."""
    return bool((_faces_per_edge(mesh) % 2 == 1).any())


def _faces_per_edge(mesh: Mesh) -> NDArray[np.int64]:
    corners, _, _ = same_vertices(mesh)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = np.sort(edges[edges[:, 0] != edges[:, 1]], axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]
