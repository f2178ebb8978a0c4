"""Geometry of a cabinet of boxes: a frame, a door with a knob, and a drawer."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core
from kinmo.features.shape_geometry import ShapeGeometry

FRAME, DOOR, KNOB, DRAWER = range(4)
"""Positions of the leaves."""
UP = np.array([0.0, 1.0, 0.0])


def geometry_of(solids: list[trimesh.Trimesh], up: NDArray[np.float64] = UP) -> ShapeGeometry:
    """Geometry of leaves with the surfaces of `solids`."""
    meshes = _core.Meshes([np.array(m.vertices) for m in solids], [np.array(m.faces, np.uint32) for m in solids])
    points, normals, _ = _core.sample_surface(meshes, 512, 3)
    return ShapeGeometry.of(meshes, points, normals, meshes.areas(), up)


def cabinet_solids() -> list[trimesh.Trimesh]:
    """Leaves in the order FRAME, DOOR, KNOB, DRAWER. The door hangs at its left side, the knob is at its right side.

    Nothing is exactly parallel, so that no two distances are equal by design.
    """

    def box(size: tuple[float, float, float], center: tuple[float, float, float], tilt: float = 0.0) -> trimesh.Trimesh:
        mesh = trimesh.creation.box(size)
        mesh.apply_transform(trimesh.transformations.rotation_matrix(tilt, [1.0, 2.0, 0.0]))
        mesh.apply_translation(center)
        return mesh

    return [
        box((0.5, 0.7, 0.3), (0.0, 0.0, 0.0)),
        box((0.46, 0.4, 0.02), (0.0, -0.1, 0.165), 0.015),
        box((0.03, 0.05, 0.025), (0.19, -0.08, 0.185), 0.3),
        box((0.44, 0.18, 0.025), (0.01, 0.23, 0.1675), -0.01),
    ]


def cabinet_geometry(turn: NDArray[np.float64] | None = None) -> ShapeGeometry:
    """Geometry of the cabinet, its samples included, transformed by the rotation or reflection `turn` [3, 3]."""
    still = geometry_of(cabinet_solids())
    if turn is None:
        return still
    solids = cabinet_solids()
    vertices = [np.ascontiguousarray(m.vertices @ turn.T) for m in solids]
    meshes = _core.Meshes(vertices, [np.array(m.faces, np.uint32) for m in solids])
    points, normals = ((values @ turn.T).astype(np.float32) for values in (still.points, still.normals))
    return ShapeGeometry.of(meshes, points, normals, meshes.areas(), turn @ UP)
