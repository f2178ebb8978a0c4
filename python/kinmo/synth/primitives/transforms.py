"""Rigid transforms, scaling and mirroring of meshes. No mesh is changed in place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector

Point = Sequence[float] | Vector
X, Y, Z = (np.eye(3)[i] for i in range(3))
ORIGIN = (0.0, 0.0, 0.0)


def transform(mesh: Mesh, matrix: NDArray[np.float64]) -> Mesh:
    """The mesh under a rigid or affine transform [4, 4]."""
    return Mesh(mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3], mesh.faces)


def move(mesh: Mesh, offset: Point) -> Mesh:
    """The mesh moved by `offset` [3]."""
    return Mesh(mesh.vertices + np.asarray(offset, float), mesh.faces)


def scale(mesh: Mesh, factors: float | Point) -> Mesh:
    """The mesh scaled about the origin.

    Args:
        mesh: The mesh.
        factors: One factor, or one per axis [3]. A negative product mirrors the mesh; normals still point outwards.
    """
    factors = np.broadcast_to(np.asarray(factors, float), 3)
    faces = mesh.faces[:, ::-1] if np.prod(factors) < 0 else mesh.faces
    return Mesh(mesh.vertices * factors, faces)


def mirror(mesh: Mesh, axis: int = 0) -> Mesh:
    """Mirror image in the plane through the origin across axis 0, 1 or 2."""
    factors = np.ones(3)
    factors[axis] = -1.0
    return scale(mesh, factors)


def rotation(direction: Point, degrees: float) -> NDArray[np.float64]:
    """Rotation matrix [3, 3] about `direction` (any length), right-handed, by Rodrigues' formula."""
    x, y, z = np.asarray(direction, float) / np.linalg.norm(direction)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def rotation_about(direction: Point, degrees: float, origin: Point = ORIGIN) -> NDArray[np.float64]:
    """Rigid transform [4, 4] that turns about the line through `origin` along `direction`."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation(direction, degrees)
    matrix[:3, 3] = np.asarray(origin, float) - matrix[:3, :3] @ np.asarray(origin, float)
    return matrix


def facing(normal: Point, up: Point, origin: Point) -> NDArray[np.float64]:
    """Rigid transform [4, 4] from a local frame to a surface of the object.

    Args:
        normal: Unit direction [3] that +z is turned to.
        up: Unit direction [3] that +y is turned to, perpendicular to `normal`.
        origin: Point [3] that the origin is moved to.
    """
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([np.cross(up, normal), up, normal])
    matrix[:3, 3] = np.asarray(origin, float)
    return matrix


def turn(mesh: Mesh, direction: Point, degrees: float, origin: Point = ORIGIN) -> Mesh:
    """The mesh turned by `degrees` about the line through `origin` along `direction`."""
    return transform(mesh, rotation_about(direction, degrees, origin))


def along(mesh: Mesh, axis: str) -> Mesh:
    """A mesh that is built along y, laid along "x", "y" or "z"."""
    order = {"x": [1, 2, 0], "y": [0, 1, 2], "z": [2, 0, 1]}[axis]
    return Mesh(mesh.vertices[:, order], mesh.faces)


def inside_out(mesh: Mesh) -> Mesh:
    """The mesh with all faces inverted."""
    return Mesh(mesh.vertices, mesh.faces[:, ::-1])
