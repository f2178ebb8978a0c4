"""A cabinet of boxes: a frame, a door with a knob, and a drawer; as meshes, samples and the scene they make."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core
from kinmo.features.candidate_features import Scene

FRAME, DOOR, KNOB, DRAWER = range(4)
UP = np.array([0.0, 1.0, 0.0])


def solids() -> list[trimesh.Trimesh]:
    """Leaves in the order FRAME, DOOR, KNOB, DRAWER; the door hangs at its left side, the knob is at its right.

    Nothing is quite parallel, so that no two distances are equal by design.
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


def scene(turn: NDArray[np.float64] | None = None, up: NDArray[np.float64] = UP) -> Scene:
    """The cabinet as a scene, turned as a whole by the rotation matrix `turn`."""
    turn = np.eye(3) if turn is None else turn
    made = solids()
    still = _core.Meshes([np.array(m.vertices) for m in made], [np.array(m.faces, np.uint32) for m in made])
    points, normals, _ = _core.sample_surface(still, 512, 3)
    meshes = _core.Meshes(
        [np.ascontiguousarray(m.vertices @ turn.T) for m in made], [np.array(m.faces, np.uint32) for m in made]
    )
    turned = [(values.astype(float) @ turn.T).astype(np.float32) for values in (points, normals)]
    return Scene.of(meshes, turned[0], turned[1], meshes.areas(), turn @ up)
