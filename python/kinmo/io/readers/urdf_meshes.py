"""Triangles of the mesh files that a URDF names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.readers.obj_reader import parse_obj

Triangles = NDArray[np.float64]
"""A triangle soup [T, 3, 3]."""

NO_TRIANGLES: Triangles = np.zeros((0, 3, 3))
MAX_FILE_BYTES = 300 * 2**20
MAX_NUMBER = 1e30
"""Largest coordinate or scale. Areas and closest points multiply four lengths, which stays far inside the range of a float."""


def is_file(path: Path) -> bool:
    """True if the file exists. False for a name that no file can have."""
    try:
        return path.is_file()
    except OSError:
        return False


def read_triangles(path: Path) -> Triangles:
    """All triangles [T, 3, 3] of a mesh file in any format that trimesh reads, with scene transforms applied."""
    if not is_file(path):
        raise InputError(path, "expected a mesh file, found none")
    if path.stat().st_size > MAX_FILE_BYTES:
        raise InputError(path, f"expected a mesh file of at most {MAX_FILE_BYTES >> 20} MiB")
    if path.suffix.lower() == ".obj":
        mesh = parse_obj(path.read_bytes(), path)
        triangles = NO_TRIANGLES if mesh is None else mesh.triangles
    else:
        triangles = _load_with_trimesh(path)
    if not np.all(np.abs(triangles) <= MAX_NUMBER):
        raise InputError(path, f"expected finite vertices, of at most {MAX_NUMBER:g}")
    return triangles


def _load_with_trimesh(path: Path) -> Triangles:
    try:
        scene = trimesh.load_scene(path, process=False)
        pieces = [mesh.triangles for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    except Exception as error:  # trimesh raises many kinds of errors for broken files
        raise InputError(path, f"expected a readable mesh: {type(error).__name__}: {error}") from error
    return np.concatenate([NO_TRIANGLES, *pieces])
