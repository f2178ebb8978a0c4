"""Normals of surfaces for shading: round where faces meet at small angles, sharp at creases."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh

CREASE = math.radians(35.0)
"""Largest angle between faces that are shaded as one round surface."""
WELD = 1e-5
"""Largest distance of vertices that count as one, in diagonals of the mesh."""
MAX_FACES = 96
"""Faces around a vertex that are compared with each other. Those of larger fans are nearly always flat."""


def corner_normals(mesh: Mesh) -> NDArray[np.float64]:
    """Unit normals [F, 3, 3] at the corners of all faces, from the faces around each corner without a crease between them."""
    triangles = mesh.triangles
    areas = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    units = areas / np.maximum(np.linalg.norm(areas, axis=1, keepdims=True), np.finfo(float).tiny)
    corner = _welded(mesh)[mesh.faces].ravel()
    order = np.argsort(corner, kind="stable")
    face, vertex = order // 3, corner[order]
    sums = areas[face].copy()
    for step in range(1, min(MAX_FACES, int(np.bincount(vertex).max(initial=1)))):
        first = np.flatnonzero(vertex[:-step] == vertex[step:])
        second = first + step
        is_round = np.einsum("ij,ij->i", units[face[first]], units[face[second]]) > math.cos(CREASE)
        first, second = first[is_round], second[is_round]
        sums[first] += areas[face[second]]  # every index appears once in a step
        sums[second] += areas[face[first]]
    normals = np.empty_like(sums)
    normals[order] = sums
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.asarray(normals.reshape(-1, 3, 3))


def with_sharp_creases(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices [V, 3] and faces [F, 3] of a mesh whose faces share a vertex only where the surface is round."""
    corners, normals = mesh.triangles.reshape(-1, 3), corner_normals(mesh).reshape(-1, 3)
    keys = np.column_stack([_welded(mesh)[mesh.faces].ravel(), np.round(1000.0 * normals).astype(np.int64)])
    _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return corners[first], place.reshape(-1, 3).astype(np.int64)


def _welded(mesh: Mesh) -> NDArray[np.int64]:
    """Number [V] of the place of every vertex."""
    low, high = mesh.vertices.min(axis=0, initial=np.inf), mesh.vertices.max(axis=0, initial=-np.inf)
    step = WELD * max(float(np.linalg.norm(high - low)), np.finfo(float).tiny)
    _, place = np.unique(np.round((mesh.vertices - low) / step), axis=0, return_inverse=True)
    return np.asarray(place.ravel(), np.int64)
