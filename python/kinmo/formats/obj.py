"""Wavefront OBJ: the vertices and faces of a file, polygons as fans.

Of an OBJ only `v` and `f` lines matter here. They are gathered and converted in bulk, which is several times faster than a line
at a time: a shape of PartNet-Mobility has some fifty OBJ files.
"""

from __future__ import annotations

import re
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.errors import InputError
from kinmo.formats.files import LARGEST_MESH, read_bytes
from kinmo.shape import Mesh

_LARGEST_COORDINATE = 1e60
_VERTEX = re.compile(rb"^[ \t]*v[ \t]+([^\r\n#]*)", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+([^\r\n#]*)", re.MULTILINE)
_TEXTURE_AND_NORMAL = re.compile(rb"/\S*")


def read_obj(path: Path, folder: Path) -> Mesh | None:
    """The triangles of an OBJ file in `folder`; None if it has no faces."""
    return parse_obj(read_bytes(path, folder, LARGEST_MESH), path)


def parse_obj(data: bytes, where: Path) -> Mesh | None:
    """The triangles of an OBJ's text; None if it has no faces. `where` names the file in errors."""
    if b"\\" in data:
        data = re.sub(rb"\\\r?\n", b" ", data)
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    rows = [row for line in _FACE.findall(data) if (row := _TEXTURE_AND_NORMAL.sub(b"", line).split())]
    if not rows:
        return None
    try:
        vertices = _vertices(data)
        sizes = np.fromiter(map(len, rows), np.int64, len(rows))
        corners = np.fromiter(map(int, chain.from_iterable(rows)), np.int64, int(sizes.sum()))
    except (ValueError, OverflowError) as error:
        raise InputError(where, f"expected numbers ({str(error)[:80]})") from None
    if np.any(corners < 0):
        corners = _absolute(data, corners, sizes)
    corners -= 1
    if np.any(corners < 0) or np.any(corners >= len(vertices)):
        raise InputError(where, f"a face names a vertex outside 1..{len(vertices)}", "f")
    faces = _fans(corners, sizes)
    return _compact(vertices, faces, where) if len(faces) else None


def _vertices(data: bytes) -> NDArray[np.float64]:
    rows = [line.split() for line in _VERTEX.findall(data)]
    sizes = set(map(len, rows))
    if sizes and min(sizes) < 3:
        raise ValueError("a vertex has fewer than 3")
    if sizes - {3}:
        rows = [row[:3] for row in rows]  # what follows is a weight or a colour
    return np.fromiter(map(float, chain.from_iterable(rows)), np.float64, 3 * len(rows)).reshape(-1, 3)


def _absolute(data: bytes, corners: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Negative indices count back from the last vertex above the face's line: here from the first of the file."""
    vertex_places = np.array([match.start() for match in _VERTEX.finditer(data)], np.int64)
    face_places = [match.start() for match in _FACE.finditer(data) if match.group(1).strip()]
    above = np.repeat(np.searchsorted(vertex_places, np.array(face_places, np.int64)), sizes)
    return np.where(corners < 0, above + corners + 1, corners)


def _fans(corners: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles [F, 3] of polygons whose corners stand one after the other; points and lines vanish."""
    if np.all(sizes == 3):
        return corners.reshape(-1, 3)
    starts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    first = np.repeat(starts, counts)
    step = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1)


def _compact(vertices: NDArray[np.float64], faces: NDArray[np.int64], where: Path) -> Mesh:
    """Drops vertices that no face uses, and checks the others."""
    used, renumbered = np.unique(faces, return_inverse=True)
    kept = vertices[used]
    if not np.all(np.abs(kept) <= _LARGEST_COORDINATE):
        bad = used[int(np.argmin(np.all(np.abs(kept) <= _LARGEST_COORDINATE, axis=1)))]
        raise InputError(where, f"vertex {bad + 1} is not finite", "v")
    return Mesh(kept, renumbered.reshape(-1, 3).astype(np.uint32))
