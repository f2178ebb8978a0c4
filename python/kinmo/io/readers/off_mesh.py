"""The triangles of an OFF file in text form."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.io.readers.mesh_limits import checked
from kinmo.io.readers.polygons import triangulate


def read_off_mesh(data: bytes, path: Path) -> Mesh:
    """The triangles of an OFF file, without unused vertices. Raises InputError for broken files and those without faces.

    Args:
        data: content of the file.
        path: the file, for messages.
    """
    lines = [line for line in re.sub(rb"#[^\r\n]*", b"", data).splitlines() if line.strip()]
    if not lines or not re.match(rb"\s*(ST)?C?N?OFF\b", lines[0]):
        raise InputError(path, "expected an OFF file")
    rest = lines[0].partition(b"OFF")[2].strip()
    lines = ([rest] if rest else []) + lines[1:]
    try:
        vertex_count, face_count = (int(word) for word in lines[0].split()[:2])
        if min(vertex_count, face_count) < 0 or vertex_count + face_count > len(lines) - 1:
            raise ValueError(f"it has no {vertex_count} vertices and {face_count} faces")
        vertices = np.array([line.split()[:3] for line in lines[1 : vertex_count + 1]], np.float64).reshape(vertex_count, 3)
        rows = [line.split() for line in lines[vertex_count + 1 : vertex_count + face_count + 1]]
        loops = [np.array(row[1 : 1 + int(row[0])], np.int64) for row in rows]
        sizes = np.array([int(row[0]) for row in rows], np.int64)
    except (ValueError, IndexError, OverflowError) as error:
        raise InputError(path, f"expected a whole OFF file ({error})") from None
    corners = np.concatenate([np.zeros(0, np.int64), *loops])
    if sizes.sum() != len(corners) or np.any(sizes < 0):
        raise InputError(path, "expected faces with their number of corners")
    if np.any((corners < 0) | (corners >= vertex_count)):
        raise InputError(path, f"a face names a vertex outside 0..{vertex_count - 1}")
    faces, _ = triangulate(vertices, corners, sizes, path)
    if not len(faces):
        raise InputError(path, "has no faces")
    return checked(Mesh(vertices, faces.astype(np.uint32)).compact, path)
