"""Triangles of the mesh files that a URDF names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.io.readers.obj_reader import parse_obj

Triangles = NDArray[np.float64]
"""A triangle soup [T, 3, 3]."""

NO_TRIANGLES: Triangles = np.zeros((0, 3, 3))
LARGEST_FILE = 300 * 2**20
LARGEST_NUMBER = 1e30
"""Of coordinates and scales: products of four lengths, as areas and nearest points take, stay far inside what a float holds."""


def triangles_of(mesh: Mesh) -> Triangles:
    """The triangles of a mesh."""
    return mesh.vertices[mesh.faces]


def is_file(path: Path) -> bool:
    """Whether there is such a file; a name that no file can have is none."""
    try:
        return path.is_file()
    except OSError:
        return False


def read_triangles(path: Path) -> Triangles:
    """All triangles of a mesh file in any format that trimesh reads, scene transforms applied.

    Raises InputError where the file is missing, too large, unreadable, or a coordinate is not finite or over `LARGEST_NUMBER`.
    """
    if not is_file(path):
        raise InputError(path, "expected a mesh file, found none")
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(path, f"expected a mesh file of at most {LARGEST_FILE >> 20} MiB")
    if path.suffix.lower() == ".obj":
        mesh = parse_obj(path.read_bytes(), path)
        triangles = NO_TRIANGLES if mesh is None else triangles_of(mesh)
    else:
        triangles = _loaded(path)
    if not np.all(np.abs(triangles) <= LARGEST_NUMBER):
        raise InputError(path, f"expected finite vertices, of at most {LARGEST_NUMBER:g}")
    return triangles


def _loaded(path: Path) -> Triangles:
    try:
        scene = trimesh.load_scene(path, process=False)
        pieces = [mesh.triangles for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    except Exception as error:  # a reader may fail in any way on a broken file
        raise InputError(path, f"expected a readable mesh: {type(error).__name__}: {error}") from error
    return np.concatenate([NO_TRIANGLES, *pieces])
