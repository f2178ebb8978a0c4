"""Checks of triangle meshes."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh

MIN_AREA = 1e-12
"""Smallest area of a surface, relative to the squared largest extent. A smaller mesh is a point or a line."""


def has_surface(mesh: Mesh) -> bool:
    """True if the faces of a mesh cover an area."""
    if not len(mesh.faces):
        return False
    extent = float(np.max(np.ptp(mesh.vertices, axis=0)))
    if extent == 0.0:
        return False
    a, b, c = np.moveaxis(((mesh.vertices - mesh.vertices[0]) / extent)[mesh.faces], 1, 0)
    return bool(0.5 * np.sum(np.linalg.norm(np.cross(b - a, c - a), axis=1)) > MIN_AREA)
