"""Binary glTF 2.0 files in memory: a JSON document and the arrays that it names."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
"""Targets of buffer views with vertices and with indices."""
_CODES = {"uint8": 5121, "uint32": 5125, "float32": 5126}
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class GlbFile:
    """A glTF document under construction. `lists` has its top-level lists, such as "nodes", by name."""

    def __init__(self) -> None:
        self.lists: dict[str, list[dict[str, Any]]] = {}
        self._binary = bytearray()

    def add(self, name: str, /, **fields: Any) -> int:
        """Add an object to a top-level list, and get its index. Fields that are None are left out."""
        entries = self.lists.setdefault(name, [])
        entries.append({key: value for key, value in fields.items() if value is not None})
        return len(entries) - 1

    def view(self, data: bytes, target: int | None = None) -> int:
        """Add bytes. Returns the index of their buffer view."""
        self._binary += b"\0" * (-len(self._binary) % 4)
        begin = len(self._binary)
        self._binary += data
        return self.add("bufferViews", buffer=0, byteOffset=begin, byteLength=len(data), target=target)

    def array(
        self, values: NDArray[Any], target: int | None = None, *, bounds: bool = False, normalized: bool | None = None
    ) -> int:
        """Add an array [count] or [count, width]. Returns the index of its accessor.

        Args:
            values: uint8, uint32 or float32.
            target: Use of the array in a mesh.
            bounds: True to state the smallest and largest values.
            normalized: True if integers stand for values from 0 to 1.
        """
        table = np.ascontiguousarray(values).reshape(len(values), -1)
        low, high = (table.min(axis=0).tolist(), table.max(axis=0).tolist()) if bounds else (None, None)
        return self.add(
            "accessors",
            bufferView=self.view(table.tobytes(), target),
            componentType=_CODES[table.dtype.name],
            count=len(table),
            type=_KINDS[table.shape[1]],
            min=low,
            max=high,
            normalized=normalized,
        )

    def to_bytes(self, **fields: Any) -> bytes:
        """The file. `fields` are further top-level fields, such as the number of the default scene."""
        buffers = {"buffers": [{"byteLength": len(self._binary)}]} if self._binary else {}
        document = {"asset": {"version": "2.0", "generator": "kinmo"}, **fields, **self.lists, **buffers}
        text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
        chunks = [(b"JSON", text + b" " * (-len(text) % 4))]
        if self._binary:
            chunks.append((b"BIN\0", bytes(self._binary) + b"\0" * (-len(self._binary) % 4)))
        body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
