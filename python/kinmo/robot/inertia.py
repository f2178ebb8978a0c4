"""Mass and inertia of a link, from the volume of closed parts and the boxes of open ones."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.loose_pieces import has_border, same_vertices
from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.robot.convex_hulls import box_of
from kinmo.robot.robot import Inertial, Matrix

DENSITY = 100.0
"""Density of the box of an open part, and of the volume of a closed one, in kg/m3. Furniture is mostly hollow."""
MIN_MASS = 0.01
"""Least mass of a link in kg."""
MIN_EXTENT = 1e-3
"""Least extent of a box with a mass, in metres."""
MIN_THICKNESS = 0.1 * MIN_EXTENT
"""Least mean thickness of a solid, in metres: twice its volume over its area."""
_BALL = Inertial(MIN_MASS, np.zeros(3), MIN_MASS / 6.0 * MIN_EXTENT**2 * np.eye(3))
"""A link without parts, at the origin."""


def inertial_of(meshes: Sequence[Mesh], densities: Sequence[float] | None = None, center: Vector | None = None) -> Inertial:
    """Mass and inertia of a link with some parts, or of a tiny ball if it has none.

    Args:
        meshes: The parts.
        densities: Density of each part in kg/m3. None for `DENSITY`.
        center: Place of the ball. None for the origin.
    """
    if not meshes and center is not None:
        return replace(_BALL, center=center)
    return joined(_inertial(mesh, density) for mesh, density in zip(meshes, densities or [DENSITY] * len(meshes), strict=True))


def is_solid(mesh: Mesh) -> bool:
    """True for a closed surface that faces outwards and is as thick as `MIN_EXTENT`. Boards that share edges are closed, too.

    A closed surface that cuts through itself may have moments of no body. It is not solid either.
    """
    return _solid_moments(mesh) is not None


def _inertial(mesh: Mesh, density: float) -> Inertial:
    """Mass and inertia of the volume inside a closed surface that faces outwards, or else of the box around a surface.

    Source: Tonon, Explicit Exact Formulas for the 3-D Tetrahedron Inertia Tensor, 2004.
    """
    moments = _solid_moments(mesh)
    if moments is None:
        return box_inertial(mesh, density)
    volume, center, second = moments
    spread = density * second
    return Inertial(density * volume, center, np.trace(spread) * np.eye(3) - spread)


def box_inertial(mesh: Mesh, density: float) -> Inertial:
    """Mass and inertia of the solid box around a surface."""
    center, axes, half = box_of(mesh.corners)
    size = np.maximum(2.0 * half, MIN_EXTENT)
    mass = density * float(np.prod(size))
    moments = mass / 12.0 * (np.sum(size**2) - size**2)
    return Inertial(mass, center, axes.T @ np.diag(moments) @ axes)


def joined(inertials: Iterable[Inertial]) -> Inertial:
    """Mass and inertia of several bodies as one. A lighter one than `MIN_MASS` is made denser."""
    every = tuple(inertials) or (_BALL,)
    mass = sum(each.mass for each in every)
    center = sum((each.mass * each.center for each in every), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for each in every:
        away = each.center - center
        inertia += each.inertia + each.mass * (away @ away * np.eye(3) - np.outer(away, away))
    denser = max(1.0, MIN_MASS / mass)
    return Inertial(denser * mass, center, denser * inertia)


def _solid_moments(mesh: Mesh) -> tuple[float, Vector, Matrix] | None:
    """Volume of a solid (see `is_solid`), its centre [3] and its second moments [3, 3] about that. None for other surfaces."""
    if has_border(mesh):
        return None
    corners, vertices, _ = same_vertices(mesh)
    middle = vertices[corners].mean(axis=(0, 1))  # moments about a far origin lose digits
    volume, first, second = _moments(vertices[corners] - middle)
    if 2.0 * volume <= MIN_THICKNESS * mesh.face_areas.sum():  # such as that of two sheets, which rounding makes positive
        return None
    second = second - np.outer(first, first) / volume
    if np.linalg.eigvalsh(second / volume)[0] < MIN_EXTENT**2 / 12.0:
        return None
    return volume, middle + first / volume, second


def _moments(triangles: NDArray[np.float64]) -> tuple[float, Vector, Matrix]:
    """Volume, and its first [3] and second [3, 3] moments, from the signed tetrahedra of triangles [F, 3, 3] and the origin."""
    volumes = np.linalg.det(triangles) / 6.0
    sums = triangles.sum(axis=1)
    volume = float(volumes.sum())
    first = np.einsum("f,fx->x", volumes, sums) / 4.0
    second = np.einsum("f,fx,fy->xy", volumes, sums, sums) + np.einsum("f,fcx,fcy->xy", volumes, triangles, triangles)
    return volume, first, second / 20.0
