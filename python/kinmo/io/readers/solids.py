"""Meshes of solids: boxes, spheres, cylinders and capsules. They are centred at the origin, with their axis along z."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh

_SECTIONS = 32
"""Number of corners of a circle."""


def box(size: NDArray[np.float64]) -> Mesh:
    """A box with sides of the lengths `size` [3]."""
    return _mesh(_creation().box(size))


def ellipsoid(radii: NDArray[np.float64]) -> Mesh:
    """An ellipsoid with the radii [3]."""
    sphere = _creation().icosphere()
    sphere.apply_scale(radii)  # trimesh has no sphere of radius 0
    return _mesh(sphere)


def cylinder(radius: float, height: float) -> Mesh:
    """A cylinder."""
    return _mesh(_creation().cylinder(radius, height, sections=_SECTIONS))


def capsule(radius: float, height: float) -> Mesh:
    """A capsule. Its height is that of the cylinder between the half spheres."""
    solid = _creation().capsule(height, radius, count=(24, 24))
    solid.vertices -= solid.bounds.mean(axis=0)
    return _mesh(solid)


def cone(radius: float, height: float) -> Mesh:
    """A cone whose tip is at half of the height."""
    solid = _creation().cone(radius, height, sections=_SECTIONS)
    solid.vertices -= [0.0, 0.0, 0.5 * height]
    return _mesh(solid)


def _creation() -> Any:
    """The module of trimesh that makes solids. It takes long to import, and few files need it."""
    from trimesh import creation

    return creation


def _mesh(solid: Any) -> Mesh:
    return Mesh(np.array(solid.vertices, np.float64), np.array(solid.faces, np.uint32))
