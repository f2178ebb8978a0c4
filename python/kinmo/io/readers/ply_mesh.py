"""The vertices and polygons of a PLY file, text or binary.

kinmo reads the meshes of PLY itself. trimesh misreads binary files whose faces differ in their number of corners, and it covers
the notches of concave faces.
"""

from __future__ import annotations

import io
import re
import struct
import warnings
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.look import NO_MATERIAL, Look
from kinmo.core.shape import Mesh
from kinmo.core.wording import clean_text
from kinmo.io.readers.mesh_limits import checked
from kinmo.io.readers.polygons import LESS_THAN_A_TRIANGLE, triangulate

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_END = re.compile(rb"[\r\n]end_header[ \t]*(?:\r\n|\n|\r)")


@dataclass(frozen=True)
class _Property:
    """A column of an element: the type of its values, and for a list that of the length in front of them."""

    name: str
    type: np.dtype[np.generic]
    length: struct.Struct | None = None


@dataclass(frozen=True)
class _Element:
    """A table of `count` rows."""

    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


@dataclass(frozen=True)
class _Column:
    """The values of all rows of a property, one row after the other, and the number of values in each row."""

    values: NDArray[np.float64]
    sizes: NDArray[np.int64]


def read_ply_mesh(data: bytes, path: Path, ignore: Callable[[str], None] = lambda what: None) -> Mesh:
    """The triangles of a PLY file without unused vertices. Raises InputError for broken files.

    Args:
        data: content of the file.
        path: the file, for messages.
        ignore: receives what is not read.
    """
    elements, rows, text = _parse(data, path)
    vertices, corners, sizes = np.zeros((0, 3)), np.zeros(0), np.zeros(0, np.int64)
    colors: NDArray[np.float64] | None = None
    try:
        for element, columns in zip(elements, _tables(rows, elements, text), strict=True):
            if element.name == "vertex":
                if not {"x", "y", "z"} <= columns.keys():
                    raise InputError(path, f"expected x, y and z, found {_listed(columns)}", "vertex")
                vertices = np.stack([columns[axis].values for axis in "xyz"], axis=1)
                colors = _colors(element, columns)
            elif element.name == "face":
                found = next((columns[name] for name in _CORNERS if name in columns), None)
                if found is None:
                    raise InputError(path, f"expected a list {' or '.join(_CORNERS)}, found {_listed(columns)}", "face")
                corners, sizes = found.values, found.sizes
    except InputError:
        raise
    except (ValueError, OverflowError, struct.error) as error:
        raise InputError(path, f"expected a whole PLY file with vertices x, y, z and faces ({error})") from None
    if not np.all((corners >= 0) & (corners < len(vertices))):
        raise InputError(path, f"a face names a vertex outside 0..{len(vertices) - 1}")
    for _ in range(int(np.count_nonzero(sizes < 3))):
        ignore(LESS_THAN_A_TRIANGLE)
    faces, _ = triangulate(vertices, corners.astype(np.int64), sizes, path)
    look = None
    if colors is not None:
        look = Look((), np.full(len(faces), NO_MATERIAL, np.int32), colors=colors[faces].astype(np.float32))
    return checked(Mesh(vertices, faces.astype(np.uint32), look).compact, path)


def _listed(columns: dict[str, _Column]) -> str:
    return clean_text(", ".join(columns))


def _colors(element: _Element, columns: dict[str, _Column]) -> NDArray[np.float64] | None:
    """Red, green, blue and opacity [V, 4] of vertices from 0 to 1. None if they have none."""
    if not all(name in columns for name in ("red", "green", "blue")):
        return None
    types = {each.name: each.type for each in element.properties}
    shown = []
    for name in ("red", "green", "blue", "alpha"):
        if name in columns:
            values, bits = columns[name].values, 8 * types[name].itemsize
            whole = {"u": 2.0**bits - 1.0, "i": 2.0 ** (bits - 1) - 1.0}
            usual = 255.0 if values.max(initial=0.0) > 1.0 else 1.0  # texts have floats alone
            shown.append(values / whole.get(types[name].kind, usual))
    opaque = [np.ones(len(shown[0]))] * (4 - len(shown))
    colors = np.stack([*shown, *opaque], axis=1)
    return np.clip(colors, 0.0, 1.0) if np.isfinite(colors).all() else None


def _parse(data: bytes, path: Path) -> tuple[list[_Element], bytes, bytes | None]:
    """The elements that the header announces, their binary data, and the text below the header, None in a binary file.

    The numbers of a text become 64-bit floats.
    """
    end = _END.search(data)
    if not data.startswith(b"ply") or end is None:
        raise InputError(path, "expected a PLY file with a header")
    elements: list[_Element] = []
    order = "<"
    for line in re.split(r"[\r\n]+", data[: end.start()].decode("utf-8", "replace")):
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = _ORDERS[words[1]]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2])))
            elif words[:1] == ["property"]:
                names = [_TYPES[word] for word in words[2 if words[1] == "list" else 1 : -1]]
                types = [np.dtype(order + name if order else "<f8") for name in names]
                length = struct.Struct((order or "<") + types[0].char) if words[1] == "list" else None
                elements[-1].properties.append(_Property(words[-1], types[-1], length))
        except (ValueError, KeyError, IndexError):
            raise InputError(path, f"expected a header of PLY, found {clean_text(line)}") from None
    for element in elements:
        if not 0 <= element.count <= len(data) or not element.properties:
            raise InputError(path, f"expected a whole PLY file: it has no {element.count} rows", clean_text(element.name))
    if order:
        return elements, data[end.end() :], None
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy only warns of what is no number
        try:
            text = data[end.end() :]
            return elements, np.fromstring(text.decode("ascii", "replace"), sep=" ").tobytes(), text
        except (ValueError, DeprecationWarning):
            raise InputError(path, "expected numbers below the header") from None


def _tables(rows: bytes, elements: list[_Element], text: bytes | None) -> list[dict[str, _Column]]:
    """The columns of each element. Where lines of a text have more numbers than the header says, those are left out.

    Old versions of MeshLab write such lines.
    """
    problem: Exception | None = None
    try:
        tables, end = _read_elements(rows, elements)
    except (ValueError, OverflowError, struct.error) as error:
        tables, end, problem = [], 0, error
    if text is not None and end < len(rows):
        trimmed = _without_surplus(text, elements)
        if trimmed is not None:
            return _read_elements(trimmed, elements)[0]
    if problem is not None:
        raise problem
    return tables


def _without_surplus(text: bytes, elements: list[_Element]) -> bytes | None:
    """The numbers of a text as 64-bit floats, one row a line, without those behind the last property.

    None if a line has too few numbers, or there are too few lines.
    """
    numbers = array("d")
    lines = (words for line in io.BytesIO(text) if (words := line.split()))
    for element in elements:
        for _ in range(element.count):
            words = next(lines, [])
            needed = 0
            for each in element.properties:
                if needed >= len(words):
                    return None
                needed += 1 if each.length is None else 1 + max(int(float(words[needed])), 0)
            if needed > len(words):
                return None
            numbers.extend(map(float, words[:needed]))
    return numbers.tobytes()


def _read_elements(data: bytes, elements: list[_Element]) -> tuple[list[dict[str, _Column]], int]:
    """The columns of each element, and where the last row ends."""
    tables, place = [], 0
    for element in elements:
        columns, place = _read_element(data, place, element)
        tables.append(columns)
    return tables, place


def _read_element(data: bytes, place: int, element: _Element) -> tuple[dict[str, _Column], int]:
    """The columns of an element whose rows begin at `place`, and where they end.

    Almost all files have lists of one length. They are read at once.
    """
    if not element.count:
        return {each.name: _Column(np.zeros(0), np.zeros(0, np.int64)) for each in element.properties}, place
    _, sizes = _read_row(data, place, element)
    row = np.dtype(
        [
            (f"{place} {part}", kind, (size,))
            for place, (each, size) in enumerate(zip(element.properties, sizes, strict=True))
            for part, kind, size in (
                ("length", "u1" if each.length is None else each.length.format, 0 if each.length is None else 1),
                ("values", each.type, size),
            )
        ]
    )
    end = place + row.itemsize * element.count
    if end <= len(data):
        rows = np.frombuffer(data, row, element.count, place)
        if all(np.all(rows[f"{column} length"] == size) for column, size in enumerate(sizes)):
            columns = {
                each.name: _Column(rows[f"{column} values"].astype(np.float64).ravel(), np.full(element.count, size))
                for column, (each, size) in enumerate(zip(element.properties, sizes, strict=True))
            }
            return columns, end
    pieces: list[list[bytes]] = []
    lengths: list[list[int]] = []
    for _ in range(element.count):
        found, own = _read_row(data, place, element)
        place += sum(map(len, found)) + sum(each.length.size for each in element.properties if each.length is not None)
        pieces.append(found)
        lengths.append(own)
    columns = {}
    for column, each in enumerate(element.properties):
        values = np.frombuffer(b"".join(row[column] for row in pieces), each.type).astype(np.float64)
        columns[each.name] = _Column(values, np.array([row[column] for row in lengths], np.int64))
    return columns, place


def _read_row(data: bytes, place: int, element: _Element) -> tuple[list[bytes], list[int]]:
    """The bytes of the values of each property in the row at `place`, and their numbers."""
    found, sizes = [], []
    for each in element.properties:
        size = 1
        if each.length is not None:
            size = int(each.length.unpack_from(data, place)[0])
            place += each.length.size
        end = place + size * each.type.itemsize
        if size < 0 or end > len(data):
            raise ValueError("it ends within a row")
        found.append(data[place:end])
        sizes.append(size)
        place = end
    return found, sizes
