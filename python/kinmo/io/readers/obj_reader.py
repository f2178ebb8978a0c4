"""Wavefront OBJ: vertices and faces.

Only `v` and `f` lines are used. They are converted in bulk, because a shape of PartNet-Mobility has about fifty OBJ files.
"""

from __future__ import annotations

import re
from codecs import BOM_UTF8
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.io.readers.mesh_limits import checked
from kinmo.io.readers.polygons import triangulate
from kinmo.io.readers.untrusted_files import MAX_MESH_BYTES, read_bytes

_MAX_DIGITS = 10
"""Most digits of an index."""
_VERTEX = re.compile(rb"\n[ \t]*v(?=[ \t\n#]|\Z)([^\n#]*)")
_FACE = re.compile(rb"\n[ \t]*f[ \t]+([^\n#]*)")


def read_obj(path: Path, folder: Path) -> Mesh | None:
    """The triangles of an OBJ file, which must be inside `folder` (see `parse_obj`)."""
    return parse_obj(read_bytes(path, folder, MAX_MESH_BYTES), path)


def parse_obj(data: bytes, where: Path) -> Mesh | None:
    """The triangles of OBJ text from the file `where`, without unused vertices. None if it has no faces."""
    found = parse_polygons(obj_lines(data), where)
    return None if found is None else found[0]


def obj_lines(data: bytes) -> bytes:
    """OBJ text with a line break before every line, and with continued lines joined."""
    text = b"\n" + data.removeprefix(BOM_UTF8)
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"\\" in text:
        text = text.replace(b"\\\n", b" ")
    return text


def face_places(text: bytes) -> NDArray[np.int64]:
    """Positions in `text`, from `obj_lines`, of the lines with faces."""
    return np.array([match.start() for match in _FACE.finditer(text)], np.int64)


def parse_polygons(text: bytes, where: Path) -> tuple[Mesh, NDArray[np.int64]] | None:
    """The triangles of `text`, from `obj_lines`, and the number of the face line [F] of each. None if it has no faces."""
    lines = _FACE.findall(text)
    try:
        corners, sizes = _corners(lines)
        if not np.any(sizes > 2):
            return None
        vertices = _vertices(_VERTEX.findall(text))
    except (ValueError, OverflowError) as error:
        raise InputError(where, f"expected numbers ({str(error)[:80]})") from None
    if np.any(corners < 0):
        corners = _absolute(text, corners, sizes)
    corners -= 1
    if np.any(corners < 0) or np.any(corners >= len(vertices)):
        raise InputError(where, f"a face names a vertex outside 1..{len(vertices)}", "f")
    faces, polygons = triangulate(vertices, corners, sizes, where)
    return checked(Mesh(vertices, faces.astype(np.uint32)).compact, where), polygons


def _vertices(lines: list[bytes]) -> NDArray[np.float64]:
    """Coordinates [V, 3]. Numbers after the third one of a line are weights or colours, and ignored."""
    if not all(map(bytes.strip, lines)):
        raise ValueError("a vertex has none")  # NumPy would skip the line
    return np.loadtxt(lines, comments=None, usecols=(0, 1, 2), ndmin=2) if lines else np.zeros((0, 3))


def _corners(lines: list[bytes]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First index of every corner `v/vt/vn` of all faces, and the number of corners of each face.

    The loop adds one digit to all indices at a time.
    """
    text = np.frombuffer(b"".join([b"\n".join(lines), b"\n", b" " * (_MAX_DIGITS + 2)]), np.uint8)
    blank = (text == 32) | (text == 10) | (text == 9)
    starts = np.flatnonzero(blank[:-1] & ~blank[1:]) + 1
    if not blank[0]:
        starts = np.concatenate([[0], starts])
    ends = np.flatnonzero(text == 10)
    sizes = np.diff(np.searchsorted(starts, ends), prepend=0)
    negative = text[starts] == ord("-")
    places = starts + negative
    values, after = np.zeros(len(starts), np.int64), places.copy()
    growing = np.ones(len(starts), bool)
    for step in range(_MAX_DIGITS + 1):
        digits = text[places + step].astype(np.int64) - ord("0")
        growing &= (digits >= 0) & (digits <= 9)
        if not growing.any():
            break
        values = np.where(growing, 10 * values + digits, values)
        after += growing
    wrong = (after == places) | growing | ~(blank[after] | (text[after] == ord("/")))
    if wrong.any():
        start = int(starts[int(np.argmax(wrong))])
        raise ValueError(f"found {text[start : start + 16].tobytes().split()[0]!r}")
    return np.where(negative, -values, values), sizes


def _absolute(text: bytes, corners: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Convert negative indices, relative to the last vertex before the line of the face, to absolute ones from 1."""
    vertex_places = np.array([match.start() for match in _VERTEX.finditer(text)], np.int64)
    above = np.repeat(np.searchsorted(vertex_places, face_places(text)), sizes)
    return np.where(corners < 0, above + corners + 1, corners)
