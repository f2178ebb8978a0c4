"""Meshes of MSH files of MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from kinmo.core.errors import InputError
from kinmo.io.readers.msh_mesh import read_msh_mesh

WHERE = Path("some.msh")
BOX = trimesh.creation.box((1.0, 2.0, 4.0))


def file_of(vertices, faces, normals=0, coordinates=0) -> bytes:
    """An MSH file with some normals and texture coordinates."""
    header = np.array([len(vertices), normals, coordinates, len(faces)], "<i4").tobytes()
    floats = np.concatenate([np.ravel(vertices), np.full(3 * normals + 2 * coordinates, 9.0)]).astype("<f4").tobytes()
    return header + floats + np.asarray(faces, "<i4").tobytes()


@pytest.mark.parametrize(("normals", "coordinates"), [(0, 0), (8, 0), (8, 8)])
def test_triangles_are_read(normals, coordinates):
    mesh = read_msh_mesh(file_of(BOX.vertices, BOX.faces, normals, coordinates), WHERE)
    np.testing.assert_allclose(mesh.triangles, BOX.triangles)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "expected an MSH file"),
        (b"\xff" * 16, "expected an MSH file"),
        (file_of(BOX.vertices, BOX.faces)[:-1], "whole MSH file"),
        (file_of(BOX.vertices, BOX.faces) + b"\0", "whole MSH file"),
        (file_of(BOX.vertices, np.zeros((0, 3))), "has no faces"),
        (file_of(BOX.vertices, [[0, 1, 8]]), r"outside 0\.\.7"),
        (file_of(BOX.vertices, [[0, -1, 2]]), r"outside 0\.\.7"),
        (file_of(np.full((3, 3), np.inf), [[0, 1, 2]]), "finite coordinates"),
        (np.array([2**31 - 1] * 4, "<i4").tobytes(), "whole MSH file"),
    ],
)
def test_a_wrong_file_is_an_error(data, problem):
    with pytest.raises(InputError, match=problem):
        read_msh_mesh(data, WHERE)
