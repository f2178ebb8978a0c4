"""The triangles of an MSH file, the binary mesh format of MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.io.readers.mesh_limits import checked

_HEADER = np.dtype("<i4")
_FLOATS = (3, 3, 2)
"""Numbers of a vertex, a normal and a texture coordinate. The file has all of each kind, then the triangles."""


def read_msh_mesh(data: bytes, path: Path) -> Mesh:
    """The triangles of an MSH file, without unused vertices. Raises InputError for broken files and those without faces.

    Args:
        data: content of the file.
        path: the file, for messages.
    """
    counts = [int(count) for count in np.frombuffer(data[:16], _HEADER)] if len(data) >= 16 else []
    if not counts or min(counts) < 0:
        raise InputError(path, "expected an MSH file of MuJoCo")
    *floats, face_count = counts
    start = 16 + 4 * sum(width * count for width, count in zip(_FLOATS, floats, strict=True))
    if len(data) != start + 12 * face_count:
        raise InputError(path, "expected a whole MSH file of MuJoCo: its length and its counts differ")
    if not face_count:
        raise InputError(path, "has no faces")
    vertices = np.frombuffer(data, "<f4", 3 * floats[0], 16).reshape(-1, 3).astype(np.float64)
    faces = np.frombuffer(data, "<i4", 3 * face_count, start).reshape(-1, 3)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(path, f"a face names a vertex outside 0..{len(vertices) - 1}")
    return checked(Mesh(vertices, faces.astype(np.uint32)).compact, path)
