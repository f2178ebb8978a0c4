"""Wavefront OBJ: vertices and faces, and how they look.

Lines are converted in bulk, because a shape of PartNet-Mobility has about fifty OBJ files.
"""

from __future__ import annotations

import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.io.readers.mesh_limits import checked
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.obj_look import Corners, libraries_in, obj_look
from kinmo.io.readers.polygons import LESS_THAN_A_TRIANGLE, triangulate
from kinmo.io.readers.untrusted_files import MAX_MESH_BYTES, peek, read_bytes

_MAX_DIGITS = 10
"""Most digits of an index."""
_VERTEX = re.compile(rb"\n[ \t]*v(?=[ \t\n#]|\Z)([^\n#]*)")
_FACE = re.compile(rb"\n[ \t]*f[ \t]+([^\n#]*)")


def read_obj(path: Path, folder: Path, materials: MtlMaterials | None = None) -> Mesh | None:
    """The triangles of an OBJ file, which must be inside `folder` (see `parse_obj`)."""
    return parse_obj(read_bytes(path, folder, MAX_MESH_BYTES), path, materials)


def parse_obj(data: bytes, where: Path, materials: MtlMaterials | None = None) -> Mesh | None:
    """The triangles of OBJ text from the file `where`, without unused vertices. None if it has no faces.

    They have their look if `materials` is given, which reads the MTL files and receives what is not read.
    """
    found = parse_polygons(obj_lines(data), where, materials)
    return None if found is None else found[0]


def material_files(meshes: Iterable[Path], folder: Path) -> list[Path]:
    """The MTL files of OBJ files whose beginning names them, and the images of these.

    Args:
        meshes: mesh files, of which those of other formats do not count.
        folder: the folder that no path may lead out of.
    """
    materials = MtlMaterials(folder, lambda what: None)
    for mesh in meshes:
        if mesh.suffix.lower() == ".obj":
            materials.of(mesh, libraries_in(obj_lines(peek(mesh, folder))))
    return materials.paths


def obj_lines(data: bytes) -> bytes:
    """OBJ text as UTF-8, with a line break before every line, and with continued lines joined."""
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):  # from some tools of Windows
        data = data.decode("utf-16", "replace").encode()
    text = b"\n" + data.removeprefix(BOM_UTF8)
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"\\" in text:
        text = text.replace(b"\\\n", b" ")
    return text


def face_places(text: bytes) -> NDArray[np.int64]:
    """Positions in `text`, from `obj_lines`, of the lines with faces."""
    letters = np.frombuffer(text + b"\n ", np.uint8)
    breaks = np.flatnonzero(letters[:-2] == ord("\n"))
    first, second = letters[breaks + 1], letters[breaks + 2]
    if np.any((first == ord(" ")) | (first == ord("\t"))):  # indented lines are rare
        return np.array([match.start() for match in _FACE.finditer(text)], np.int64)
    return np.asarray(breaks[(first == ord("f")) & ((second == ord(" ")) | (second == ord("\t")))], np.int64)


def parse_polygons(text: bytes, where: Path, materials: MtlMaterials | None = None) -> tuple[Mesh, NDArray[np.int64]] | None:
    """The triangles of `text`, from `obj_lines`, and the number of the face line [F] of each. None if it has no faces."""
    lines, colors = _FACE.findall(text), None
    try:
        found = _corners(lines, with_look=materials is not None)
        if not np.any(found.sizes > 2):
            return None
        vertex_lines = _VERTEX.findall(text)
        vertices = _vertices(vertex_lines)
    except (ValueError, OverflowError) as error:
        raise InputError(where, f"expected numbers ({str(error)[:80]})") from None
    corners = _absolute(text, found.vertices, found.sizes) if np.any(found.vertices < 0) else found.vertices
    corners = corners - 1
    if np.any(corners < 0) or np.any(corners >= len(vertices)):
        raise InputError(where, f"a face names a vertex outside 1..{len(vertices)}", "f")
    chosen, polygons = triangulate(vertices[corners], np.arange(len(corners)), found.sizes, where)
    look = None
    if materials is not None:
        for _ in range(int(np.count_nonzero(found.sizes < 3))):
            materials.ignore(LESS_THAN_A_TRIANGLE)
        colors = _colors(vertex_lines)
        of_corners = None if colors is None else colors[corners]
        look = obj_look(text, where, found, chosen, face_places(text)[polygons], of_corners, materials)
    return checked(Mesh(vertices, corners[chosen].astype(np.uint32), look).compact, where), polygons


def _vertices(lines: list[bytes]) -> NDArray[np.float64]:
    """Coordinates [V, 3]. Numbers after the third one of a line are weights or colours."""
    if not all(map(bytes.strip, lines)):
        raise ValueError("a vertex has none")  # NumPy would skip the line
    return np.loadtxt(lines, comments=None, usecols=(0, 1, 2), ndmin=2) if lines else np.zeros((0, 3))


def _colors(lines: list[bytes]) -> NDArray[np.float64] | None:
    """Red, green and blue [V, 3] from 0 to 1 behind the coordinates. None if a vertex has none."""
    if not lines or len(lines[0].split()) < 6:
        return None
    try:
        colors = np.loadtxt(lines, comments=None, usecols=(3, 4, 5), ndmin=2)
    except (ValueError, IndexError):
        return None
    if not np.isfinite(colors).all():
        return None
    return np.clip(colors / 255.0 if colors.max() > 1.0 else colors, 0.0, 1.0)


def _corners(lines: list[bytes], *, with_look: bool) -> Corners:
    """The corners `v/vt/vn` of all faces. Without the look, they have no indices of texture coordinates and normals."""
    text = np.frombuffer(b"".join([b"\n".join(lines), b"\n", b" " * (_MAX_DIGITS + 4)]), np.uint8)
    blank = (text == 32) | (text == 10) | (text == 9)
    starts = np.flatnonzero(blank[:-1] & ~blank[1:]) + 1
    if not blank[0]:
        starts = np.concatenate([[0], starts])
    ends = np.flatnonzero(text == 10)
    sizes = np.diff(np.searchsorted(starts, ends), prepend=0)
    values, after, is_number = _indices(text, starts)
    wrong = ~is_number | ~(blank[after] | (text[after] == ord("/")))
    if wrong.any():
        start = int(starts[int(np.argmax(wrong))])
        raise ValueError(f"found {text[start : start + 16].tobytes().split()[0].decode('utf-8', 'replace')}")
    none = np.zeros(len(starts), np.int64)
    if not with_look or not np.any(text[after] == ord("/")):
        return Corners(values, none, none, sizes)
    nowhere = len(text) - _MAX_DIGITS - 3
    coordinates, after, _ = _indices(text, np.where(text[after] == ord("/"), after + 1, nowhere))
    normals, _, _ = _indices(text, np.where(text[after] == ord("/"), after + 1, nowhere))
    return Corners(values, coordinates, normals, sizes)


def _indices(
    text: NDArray[np.uint8], starts: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """The integers that begin at some positions of a text, the positions behind them, and True for those that are integers.

    The loop adds one digit to all indices at a time.
    """
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
    return np.where(negative, -values, values), after, (after > places) & ~growing


def _absolute(text: bytes, corners: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Convert negative indices, relative to the last vertex before the line of the face, to absolute ones from 1."""
    vertex_places = np.array([match.start() for match in _VERTEX.finditer(text)], np.int64)
    above = np.repeat(np.searchsorted(vertex_places, face_places(text)), sizes)
    return np.where(corners < 0, above + corners + 1, corners)
