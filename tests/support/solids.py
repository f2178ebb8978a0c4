"""Meshes for the tests of `kinmo._core`, as (vertices [V, 3] float64, faces [F, 3] uint32)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from hypothesis import strategies as st
from numpy.typing import NDArray

from kinmo import _core

F64 = NDArray[np.float64]
MeshArrays = tuple[F64, NDArray[np.uint32]]

seeds = st.integers(0, 2**32 - 1)


def arrays(mesh: trimesh.Trimesh) -> MeshArrays:
    return np.array(mesh.vertices, float), np.array(mesh.faces, np.uint32)


def mesh_of(vertices: Sequence[Sequence[float]], faces: Sequence[Sequence[int]]) -> MeshArrays:
    return np.array(vertices, float), np.array(faces, np.uint32)


def meshes(*parts: MeshArrays) -> _core.Meshes:
    return _core.Meshes([vertices for vertices, _ in parts], [faces for _, faces in parts])


def rotation(seed: int) -> F64:
    """A random rotation [3, 3]."""
    return trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).uniform(size=3))[:3, :3]


def moved(part: MeshArrays, turn: F64, shift: F64 | float = 0.0, scale: float = 1.0) -> MeshArrays:
    return scale * (part[0] @ turn.T) + shift, part[1]


BOX = arrays(trimesh.creation.box((3.0, 2.0, 1.0)))
CYLINDER = arrays(trimesh.creation.cylinder(1.0, 5.0, sections=40))
TETRAHEDRON = mesh_of([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
RECTANGLE = mesh_of([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
TRIANGLE = mesh_of([[0, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2]])
LINE = mesh_of([[0, 0, 0], [1, 1, 2], [3, 3, 6]], [[0, 1, 2], [2, 1, 0]])
POINT = mesh_of([[1, 2, 3]] * 3, [[0, 1, 2]])
REPEATED = mesh_of([*BOX[0], *BOX[0], *BOX[0]], [*BOX[1], *(BOX[1] + 8), *(BOX[1] + 16)])
INSIDE_OUT = (BOX[0], BOX[1][:, ::-1].copy())
FIN = mesh_of([*BOX[0], [0, 3, 0]], [*BOX[1], [0, 1, 8]])

DEGENERATE = {
    "rectangle": RECTANGLE,
    "single triangle": TRIANGLE,
    "line": LINE,
    "point": POINT,
    "repeated vertices": REPEATED,
    "inside out": INSIDE_OUT,
    "non-manifold": FIN,
}


@st.composite
def clouds(draw: st.DrawFn) -> MeshArrays:
    """Triangles between points of a small grid or in general position: flat, thin, repeated and ordinary ones."""
    rng = np.random.default_rng(draw(seeds))
    count = 3 * draw(st.integers(2, 10))
    if draw(st.booleans()):
        vertices = rng.integers(-2, 3, (count, 3)).astype(float)
    else:
        vertices = rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-2, 0, 3)
    faces = np.concatenate([np.arange(count).reshape(-1, 3), rng.integers(0, count, (count, 3))])
    return vertices, faces.astype(np.uint32)
