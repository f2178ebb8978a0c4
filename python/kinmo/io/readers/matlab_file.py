"""Numeric arrays of MATLAB files of version 5 to 7.2.

kinmo reads them itself, because a damaged file of this kind can end the process within SciPy.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_HEADER_BYTES = 128
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_MATRIX, _COMPRESSED = 14, 15
_NUMERIC_CLASSES = range(6, 16)
"""Classes of arrays of real or complex numbers, from double to uint64."""
_COMPLEX = 0x0800


def read_matlab_arrays(data: bytes, names: tuple[str, ...], max_bytes: int) -> dict[str, NDArray[np.float64]]:
    """The real arrays of these names, with the axes in MATLAB's order. Others are skipped.

    Args:
        data: content of the file.
        names: names of variables.
        max_bytes: most bytes that all compressed variables may give.

    Raises:
        ValueError: the file is no MATLAB file of these versions, is damaged, or unpacks to more than `max_bytes`.
    """
    mark = data[_HEADER_BYTES - 2 : _HEADER_BYTES]
    if mark not in (b"IM", b"MI"):
        raise ValueError("no header of version 5")
    order = "<" if mark == b"IM" else ">"
    found: dict[str, NDArray[np.float64]] = {}
    left = max_bytes
    for kind, content in _elements(data[_HEADER_BYTES:], order):
        matrix = content
        if kind == _COMPRESSED:
            unpacker = zlib.decompressobj()
            try:
                packed = unpacker.decompress(content, left)
            except zlib.error as error:
                raise ValueError(str(error)) from None
            if unpacker.unconsumed_tail:
                raise ValueError("unpacks to too many bytes")
            left -= len(packed)
            kind, matrix = next(_elements(packed, order), (0, b""))
        if kind == _MATRIX:
            name, array = _matrix(matrix, order, names)
            if array is not None:
                found[name] = array
    return found


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Type and content of the data elements."""
    place = 0
    while place + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, place)
        if kind >> 16:  # a small element: its content is within the tag
            kind, size, begin, after = kind & 0xFFFF, kind >> 16, place + 4, place + 8
            if size > 4:
                raise ValueError("an element is too long for its tag")
        else:
            begin = place + 8
            after = begin + size + (-size % 8 if kind != _COMPRESSED else 0)
        if begin + size > len(data):
            raise ValueError("it ends within an element")
        yield kind, data[begin : begin + size]
        place = after


def _matrix(data: bytes, order: str, names: tuple[str, ...]) -> tuple[str, NDArray[np.float64] | None]:
    """The name of an array, and its values unless it is of another name or class."""
    elements = _elements(data, order)
    flags, shape, name = (next(elements, (0, b""))[1] for _ in range(3))
    if len(flags) < 4 or len(shape) % 4:
        raise ValueError("an array has no class or no shape")
    title = name.decode("ascii", "replace")
    (bits,) = struct.unpack_from(f"{order}I", flags)
    if title not in names or bits & 0xFF not in _NUMERIC_CLASSES or bits & _COMPLEX:
        return title, None
    kind, content = next(elements, (0, b""))
    sizes = np.frombuffer(shape, f"{order}i4").tolist()
    if kind not in _TYPES:
        raise ValueError(f"the array {title} has no numbers")
    values = np.frombuffer(content, f"{order}{_TYPES[kind]}")
    count = 1
    for size in sizes:
        count *= size
    if min(sizes, default=0) < 0 or count != len(values):
        raise ValueError(f"the array {title} has {len(values)} numbers, not those of its shape")
    return title, np.asarray(values.astype(np.float64).reshape(sizes, order="F"))
