"""The container of glTF 2.0 (Khronos Group): its JSON document, its buffers and the views of them."""

from __future__ import annotations

import base64
import binascii
import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from kinmo.core.errors import InputError
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.optional_library import optional_library
from kinmo.io.readers.untrusted_files import MAX_JSON_BYTES, MAX_SCENE_BYTES, inside, named_by, parse_json, read_bytes

DRACO, INSTANCING = "KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_SUPPORTED_EXTENSIONS = (
    "KHR_mesh_quantization", "KHR_node_visibility", INSTANCING, DRACO, *MESHOPT,
    # these change no geometry
    "KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_animation_", "KHR_techniques_", "KHR_xmp", "KHR_audio",
    "EXT_materials_", "EXT_texture_", "EXT_lights_", "EXT_mesh_features", "EXT_structural_metadata", "MSFT_texture_",
    "MSFT_packing_", "MSFT_lod", "ADOBE_materials_", "FB_",
)  # fmt: skip
"""Prefixes of the names of extensions that may be required."""
_HEADER, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_MAX_RATIO = 4096
"""Most bytes that a byte of a compressed view gives."""


@dataclass(frozen=True)
class BufferView:
    """Bytes of a buffer. `stride` is the distance between elements in bytes, 0 if they are packed."""

    data: bytes | memoryview
    stride: int


class GltfFile:
    """An open glTF file: GLB, or JSON with buffers in other files and data URIs. `root` is its JSON document."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.root, self._binary = _read_document(path)
        self._lists: dict[str, list[JsonField]] = {}
        self._buffers: dict[int, bytes] = {}
        self._views: dict[int, BufferView] = {}
        if isinstance(self.root["nodes"].value, dict):
            raise InputError(path, _version_problem(1))
        for needed in self.root["extensionsRequired"].items():
            if not needed.text().startswith(_SUPPORTED_EXTENSIONS):
                raise needed.fail(f"{needed.text()} is not supported: export the file without it")

    def entry(self, name: str, index: JsonField) -> JsonField:
        """The item of a top-level list, such as "nodes", at the index that a field holds."""
        entries = self.entries(name)
        if not 0 <= index.integer() < len(entries):
            raise index.fail(f"expected one of the {len(entries)} {name}, got {index.integer()}")
        return entries[index.integer()]

    def entries(self, name: str) -> list[JsonField]:
        """All items of a top-level list."""
        if name not in self._lists:
            self._lists[name] = self.root[name].items()
        return self._lists[name]

    def view(self, index: JsonField) -> BufferView:
        """The buffer view at the index that a field holds, decompressed."""
        number = index.integer()
        if number not in self._views:
            self._views[number] = self._read_view(self.entry("bufferViews", index))
        return self._views[number]

    def _read_view(self, view: JsonField) -> BufferView:
        for name in MESHOPT:
            packed = extension(view, name)
            if not packed.is_absent and not self._has_copy(view):
                return self._decompressed(packed)
        return BufferView(self._bytes(view), count_of(view["byteStride"]))

    def _has_copy(self, view: JsonField) -> bool:
        """True if the data of a compressed view are in the file without compression too."""
        buffer, number = self.entry("buffers", view["buffer"]), view["buffer"].integer()
        packed = [found for name in MESHOPT if not (found := extension(buffer, name)).is_absent]
        is_fallback = any(each["fallback"].flag() for each in packed)
        return not is_fallback and (not buffer["uri"].is_absent or (number == 0 and self._binary is not None))

    def _decompressed(self, packed: JsonField) -> BufferView:
        """A view compressed with meshoptimizer."""
        data = self._bytes(packed)
        count, stride = count_of(packed["count"]), count_of(packed["byteStride"])
        if count * stride > _MAX_RATIO * len(data):
            raise packed["count"].fail(f"expected fewer elements in {len(data)} bytes, got {count}")
        mode, kind = packed["mode"].text(), packed["filter"].text("NONE")
        meshopt = optional_library("meshopt", "formats", self.path, "is compressed with meshoptimizer")
        try:
            numbers = meshopt.decode_gltf_buffer(bytes(data), count, stride, mode, kind)
        except (ValueError, RuntimeError, TypeError) as error:
            raise packed.fail(f"cannot be decompressed ({error})") from None
        return BufferView(numbers.tobytes(), stride if mode == "ATTRIBUTES" else 0)

    def _bytes(self, view: JsonField) -> memoryview:
        """The bytes that a view names by `buffer`, `byteOffset` and `byteLength`."""
        data = self._buffer(view["buffer"])
        begin, length = count_of(view["byteOffset"]), count_of(view["byteLength"])
        if begin + length > len(data):
            raise view["byteLength"].fail(f"expected at most the {len(data)} bytes of the buffer, got {begin + length}")
        return memoryview(data)[begin : begin + length]

    def _buffer(self, index: JsonField) -> bytes:
        number = index.integer()
        if number not in self._buffers:
            self._buffers[number] = self._read_buffer(self.entry("buffers", index), number)
        return self._buffers[number]

    def _read_buffer(self, buffer: JsonField, number: int) -> bytes:
        uri = buffer["uri"]
        if uri.is_absent:
            if number != 0 or self._binary is None:
                raise buffer.fail("expected an uri: it has no data")
            return self._binary
        if not isinstance(uri.value, str):
            raise uri.fail("expected a text")
        if not uri.value.startswith("data:"):
            file = file_of_uri(uri)
            try:
                return read_bytes(file, self.path.parent, MAX_SCENE_BYTES)
            except InputError as error:
                raise named_by(self.path, uri.path, uri.value, error) from None
        return data_of_uri(uri)


def _version_problem(version: int) -> str:
    return f"expected version 2 of glTF, got {version}: export it as glTF 2.0"


def data_of_uri(uri: JsonField) -> bytes:
    """The bytes in a data URI."""
    head, comma, text = uri.whole_text().partition(",")
    if not comma or not head.endswith(";base64"):
        raise uri.fail("expected data as base64")
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        raise uri.fail("expected data as base64") from None


def extension(field: JsonField, name: str) -> JsonField:
    """The extension of an object. It is absent if the object has none of the name."""
    extensions = field["extensions"]
    return extensions if extensions.is_absent else extensions[name]


def count_of(field: JsonField) -> int:
    """A number of items or bytes. 0 if the field is absent."""
    value = field.integer(0)
    if value < 0:
        raise field.fail("expected 0 or more")
    return value


def other_files(path: Path) -> list[Path]:
    """The files with the buffers and images of a glTF file. None if the file cannot be read."""
    try:
        root, _ = _read_document(path)
        uris = [entry["uri"] for name in ("buffers", "images") for entry in root[name].items()]
    except InputError:
        return []
    found = []
    for uri in uris:
        if isinstance(uri.value, str) and not uri.value.startswith("data:"):
            with suppress(InputError):
                found.append(file_of_uri(uri))
    return found


def file_of_uri(uri: JsonField) -> Path:
    """The file that a URI in a glTF file names. Raises InputError if it leads out of the folder."""
    name, folder = uri.whole_text(), uri.where.parent
    if "://" in name:
        raise uri.fail(f"its data is at {name}: download it, or export one GLB")
    try:
        return inside(folder / unquote(name), folder)
    except InputError as error:
        raise named_by(uri.where, uri.path, name, error) from None


def _read_document(path: Path) -> tuple[JsonField, bytes | None]:
    """The JSON document, and the binary chunk of a GLB."""
    data = read_bytes(path, path.parent, MAX_SCENE_BYTES)
    if not data.startswith(b"glTF"):
        if path.suffix.lower() == ".glb":
            raise InputError(path, "expected a binary glTF file: export it again")
        return parse_json(data, path), None
    chunks = dict(reversed(list(_chunks(data, path))))  # the first one of each type counts
    if b"JSON" not in chunks:
        raise InputError(path, "expected a chunk of JSON")
    if len(chunks[b"JSON"]) > MAX_JSON_BYTES:
        raise InputError(path, f"its JSON is larger than {MAX_JSON_BYTES >> 20} MiB")
    return parse_json(chunks[b"JSON"], path), chunks.get(b"BIN\0")


def _chunks(data: bytes, path: Path) -> Iterator[tuple[bytes, bytes]]:
    """Type and content of the chunks of a binary glTF file."""
    if len(data) < _HEADER.size:
        raise InputError(path, "expected a binary glTF file: export it again")
    _, version, length = _HEADER.unpack_from(data)
    if version != 2:
        raise InputError(path, _version_problem(version))
    if length != len(data):
        raise InputError(path, f"expected {length} bytes, as its header says, got {len(data)}")
    begin = _HEADER.size
    while begin + _CHUNK.size <= length:
        size, kind = _CHUNK.unpack_from(data, begin)
        begin += _CHUNK.size
        if begin + size > length:
            raise InputError(path, "a chunk is longer than the file")
        yield kind, data[begin : begin + size]
        begin += size
