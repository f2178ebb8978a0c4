"""Joining and judging triangle meshes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinmo.shape import Mesh

SMALLEST_AREA = 1e-12
"""Of the square of a mesh's largest extent: below it the mesh is a point or a line, and has no surface."""


def join(meshes: Sequence[Mesh]) -> Mesh:
    """One mesh with all vertices and faces."""
    if len(meshes) == 1:
        return meshes[0]
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    faces = [mesh.faces + np.uint32(offset) for mesh, offset in zip(meshes, offsets, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def has_surface(mesh: Mesh) -> bool:
    """Whether the faces cover any area."""
    if not len(mesh.faces):
        return False
    extent = float(np.max(np.ptp(mesh.vertices, axis=0)))
    if extent == 0.0:
        return False
    a, b, c = np.moveaxis(((mesh.vertices - mesh.vertices[0]) / extent)[mesh.faces], 1, 0)
    return bool(0.5 * np.sum(np.linalg.norm(np.cross(b - a, c - a), axis=1)) > SMALLEST_AREA)
