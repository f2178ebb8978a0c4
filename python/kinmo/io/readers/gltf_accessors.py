"""Accessors of glTF 2.0: arrays of numbers in buffers, also normalised and sparse ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.io.readers.gltf_file import GltfFile, count_of
from kinmo.io.readers.json_field import JsonField

F64 = NDArray[np.float64]

FLOAT = 5126
"""Code of the component type float32."""
INDEX_TYPES = (5121, 5123, 5125)
"""Codes of the component types of indices: uint8, uint16 and uint32."""
NUMBER_TYPES = (5120, 5121, 5122, 5123, 5125, FLOAT)
"""Codes of all component types."""
MAX_NUMBERS = 200_000_000
"""Most numbers of one accessor. A sparse accessor has no data of its own that would limit them."""

_DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", FLOAT: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def read_numbers(file: GltfFile, index: JsonField, kind: str, component_types: tuple[int, ...] = NUMBER_TYPES) -> NDArray[Any]:
    """The numbers [count, width] of an accessor, as they are stored.

    Args:
        file: The open file.
        index: The field that holds the accessor's index.
        kind: Expected element type, a key of `_WIDTHS`.
        component_types: Codes of the accepted types of numbers.
    """
    accessor = file.entry("accessors", index)
    component = accessor["componentType"]
    if component.integer() not in component_types:
        names = ", ".join(np.dtype(_DTYPES[each]).name for each in component_types)
        raise component.fail(f"expected {names}, got type {component.integer()}")
    if accessor["type"].text() != kind:
        raise accessor["type"].fail(f"expected {kind}")
    count, dtype, width = count_of(accessor["count"]), np.dtype(_DTYPES[component.integer()]), _WIDTHS[kind]
    if count == 0 or count * width > MAX_NUMBERS:
        raise accessor["count"].fail(f"expected 1 to {MAX_NUMBERS // width}, got {count}")
    if accessor["bufferView"].is_absent:
        if accessor["sparse"].is_absent:
            raise accessor.fail("has no data: its compression is not supported, export without it")
        numbers: NDArray[Any] = np.zeros((count, width), dtype)
    else:
        numbers = _packed(file, accessor, dtype, count, width)
    sparse = accessor["sparse"]
    return numbers if sparse.is_absent else _with_sparse(file, numbers, sparse)


def read_floats(file: GltfFile, index: JsonField, kind: str) -> F64:
    """The values [count, width] of an accessor. Normalised integers give values from 0 or -1 to 1."""
    accessor = file.entry("accessors", index)
    values = normalised(read_numbers(file, index, kind).astype(np.float64), accessor)
    if not np.isfinite(values).all():
        raise index.fail("expected finite numbers")
    return values


def normalised(values: F64, accessor: JsonField) -> F64:
    """Values of an accessor, divided by the largest one of its type if it says so."""
    dtype = np.dtype(_DTYPES[accessor["componentType"].integer()])
    if dtype.kind == "f" or not accessor["normalized"].flag():
        return values
    return np.maximum(values / np.iinfo(dtype).max, -1.0)


def _packed(file: GltfFile, place: JsonField, dtype: np.dtype[Any], count: int, width: int) -> NDArray[Any]:
    """A read-only view [count, width] of the numbers in the buffer view that an object names."""
    view = file.view(place["bufferView"])
    size, begin = dtype.itemsize * width, count_of(place["byteOffset"])
    stride = view.stride or size
    if stride < size or begin + (count - 1) * stride + size > len(view.data):
        problem = f"expected as many numbers as the buffer holds, got {count}"
        raise (place["count"] if not place["count"].is_absent else place).fail(problem)
    found: NDArray[Any] = np.ndarray((count, width), dtype, view.data, begin, (stride, dtype.itemsize))
    return found


def _with_sparse(file: GltfFile, numbers: NDArray[Any], sparse: JsonField) -> NDArray[Any]:
    """The numbers with those elements replaced that a sparse accessor lists."""
    count, code = count_of(sparse["count"]), sparse["indices"]["componentType"]
    if not 0 < count <= len(numbers):
        raise sparse["count"].fail(f"expected 1 to {len(numbers)}, got {count}")
    if code.integer() not in INDEX_TYPES:
        raise code.fail("expected uint8, uint16 or uint32")
    places = _packed(file, sparse["indices"], np.dtype(_DTYPES[code.integer()]), count, 1)[:, 0]
    if int(places.max()) >= len(numbers):
        raise sparse["indices"].fail(f"expected indices below {len(numbers)}, got {int(places.max())}")
    changed: NDArray[Any] = numbers.copy()
    changed[places] = _packed(file, sparse["values"], numbers.dtype, count, numbers.shape[1])
    return changed
