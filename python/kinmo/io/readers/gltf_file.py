"""The container of glTF 2.0 (Khronos Group): its JSON document and the numbers in its buffers."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.untrusted_files import MAX_JSON_BYTES, MAX_MESH_BYTES, parse_json, read_bytes

FLOAT = 5126
"""Code of the component type float32."""
INDEX_TYPES = (5121, 5123, 5125)
"""Codes of the component types of indices: uint8, uint16 and uint32."""

_HEADER, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_HARMLESS_EXTENSIONS = (
    "KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "EXT_lights_", "MSFT_texture_", "KHR_xmp_"
)  # fmt: skip
"""Prefixes of the names of extensions that do not change geometry."""
_DTYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4", FLOAT: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3}


class GltfFile:
    """An open binary glTF file (GLB). `root` is its JSON document."""

    def __init__(self, path: Path) -> None:
        chunks = _read_chunks(path)
        if b"JSON" not in chunks:
            raise InputError(path, "expected a chunk of JSON")
        if len(chunks[b"JSON"]) > MAX_JSON_BYTES:
            raise InputError(path, f"its JSON is larger than {MAX_JSON_BYTES >> 20} MiB")
        self.root = parse_json(chunks[b"JSON"], path)
        self._binary = chunks.get(b"BIN\0", b"")
        self._lists: dict[str, list[JsonField]] = {}
        for needed in self.root["extensionsRequired"].items():
            if not needed.text().startswith(_HARMLESS_EXTENSIONS):
                raise needed.fail(f"expected a file that can be read without {needed.text()}: export it without")

    def entry(self, name: str, index: JsonField) -> JsonField:
        """The item of a top-level list, such as "nodes", at the index that a field holds."""
        if name not in self._lists:
            self._lists[name] = self.root[name].items()
        entries = self._lists[name]
        if not 0 <= index.integer() < len(entries):
            raise index.fail(f"expected one of the {len(entries)} {name}, got {index.integer()}")
        return entries[index.integer()]

    def numbers(self, index: JsonField, kind: str, component_types: tuple[int, ...]) -> NDArray[Any]:
        """The numbers of the accessor at the index that a field holds, as a read-only view [count, width] of the file.

        `kind` is the expected element type, "SCALAR" or "VEC3". `component_types` are codes of the accepted types of numbers.
        """
        accessor = self.entry("accessors", index)
        component = accessor["componentType"]
        if component.integer() not in component_types:
            names = ", ".join(np.dtype(_DTYPES[each]).name for each in component_types)
            raise component.fail(f"expected {names}, got type {component.integer()}: export without quantization")
        if accessor["type"].text() != kind:
            raise accessor["type"].fail(f"expected {kind}")
        if not accessor["sparse"].is_absent or accessor["bufferView"].is_absent:
            raise accessor.fail("expected all numbers in a bufferView: export without sparse accessors and compression")
        view = self.entry("bufferViews", accessor["bufferView"])
        data = self._buffer(view["buffer"])
        dtype = np.dtype(_DTYPES[component.integer()])
        size = dtype.itemsize * _WIDTHS[kind]
        begin = _count(view["byteOffset"]) + _count(accessor["byteOffset"])
        end = min(_count(view["byteOffset"]) + _count(view["byteLength"]), len(data))
        count, stride = _count(accessor["count"]), _count(view["byteStride"]) or size
        if count == 0 or stride < size or begin + (count - 1) * stride + size > end:
            raise accessor["count"].fail(f"expected as many numbers as the buffer holds, got {count}")
        found: NDArray[Any] = np.ndarray((count, _WIDTHS[kind]), dtype, data, begin, (stride, dtype.itemsize))
        return found

    def _buffer(self, index: JsonField) -> bytes:
        """The bytes of a buffer. The binary chunk of the file is the only buffer that is supported."""
        buffer = self.entry("buffers", index)
        if index.integer() != 0 or not buffer["uri"].is_absent:
            raise index.fail("expected data in the file itself: export one GLB with embedded buffers")
        return self._binary


def _read_chunks(path: Path) -> dict[bytes, bytes]:
    """The chunks of a binary glTF file by their type. The first one of each type counts."""
    data = read_bytes(path, path.parent, MAX_MESH_BYTES)
    if len(data) < _HEADER.size or not data.startswith(b"glTF"):
        raise InputError(path, "expected a binary glTF file")
    _, version, length = _HEADER.unpack_from(data)
    if version != 2:
        raise InputError(path, f"expected version 2 of glTF, got {version}")
    if length != len(data):
        raise InputError(path, f"expected {length} bytes, as its header says, got {len(data)}")
    chunks: dict[bytes, bytes] = {}
    begin = _HEADER.size
    while begin + _CHUNK.size <= length:
        size, kind = _CHUNK.unpack_from(data, begin)
        begin += _CHUNK.size
        if begin + size > length:
            raise InputError(path, "a chunk is longer than the file")
        chunks.setdefault(kind, data[begin : begin + size])
        begin += size
    return chunks


def _count(field: JsonField) -> int:
    """A number of items or bytes. 0 if the field is absent."""
    value = field.integer(0)
    if value < 0:
        raise field.fail("expected 0 or more")
    return value
