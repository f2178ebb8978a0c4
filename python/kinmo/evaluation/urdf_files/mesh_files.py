"""Triangles of the mesh files that a URDF names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo.errors import InputError
from kinmo.formats.obj import parse_obj
from kinmo.shape import Mesh

Triangles = NDArray[np.float64]
"""A triangle soup [T, 3, 3]."""

NO_TRIANGLES: Triangles = np.zeros((0, 3, 3))
LARGEST_FILE = 300 * 2**20


def triangles_of(mesh: Mesh) -> Triangles:
    """The triangles of a mesh."""
    return mesh.vertices[mesh.faces]


def read_triangles(path: Path) -> Triangles:
    """All triangles of a mesh file in any format that trimesh reads, scene transforms applied.

    Raises InputError where the file is missing, too large, unreadable, or holds a vertex that is not finite.
    """
    if not path.is_file():
        raise InputError(path, "expected a mesh file, found none")
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(path, f"expected a mesh file of at most {LARGEST_FILE >> 20} MiB")
    if path.suffix.lower() == ".obj":
        mesh = parse_obj(path.read_bytes(), path)
        return NO_TRIANGLES if mesh is None else triangles_of(mesh)
    try:
        scene = trimesh.load_scene(path, process=False)
        pieces = [mesh.triangles for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh)]
    except Exception as error:  # a reader may fail in any way on a broken file
        raise InputError(path, f"expected a readable mesh: {type(error).__name__}: {error}") from error
    triangles = np.concatenate([NO_TRIANGLES, *pieces])
    if not np.isfinite(triangles).all():
        raise InputError(path, "expected finite vertices")
    return triangles
