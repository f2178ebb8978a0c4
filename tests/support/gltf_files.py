"""Small glTF files of any form."""

from __future__ import annotations

import json
import struct
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

CODES = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class GltfBuilder:
    """Collects the arrays and meshes of a document. `document` is its JSON, to change at will."""

    def __init__(self) -> None:
        self.binary = b""
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"}, "buffers": [], "bufferViews": [], "accessors": [], "meshes": [], "nodes": []
        }  # fmt: skip

    def view(self, data: bytes, **fields: Any) -> int:
        """Add a buffer view. Returns its index."""
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.document["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **fields})
        self.binary += data
        return len(self.document["bufferViews"]) - 1

    def accessor(self, array: np.ndarray, **fields: Any) -> int:
        """Add an accessor of an array [count, width]. Returns its index."""
        table = array.reshape(len(array), -1)
        described = {"componentType": CODES[array.dtype.name], "count": len(table), "type": KINDS[table.shape[1]]}
        self.document["accessors"].append({"bufferView": self.view(table.tobytes()), **described, **fields})
        return len(self.document["accessors"]) - 1

    def mesh(self, mesh: trimesh.Trimesh, **attributes: int) -> int:
        """Add a mesh. Returns its index."""
        position = attributes.pop("POSITION", None)
        if position is None:
            position = self.accessor(mesh.vertices.astype(np.float32))
        indices = self.accessor(mesh.faces.astype(np.uint16).reshape(-1))
        self.document["meshes"].append(
            {"primitives": [{"attributes": {"POSITION": position, **attributes}, "indices": indices}]}
        )
        return len(self.document["meshes"]) - 1

    def node(self, name: str = "", **fields: Any) -> int:
        """Add a node. Returns its index."""
        self.document["nodes"].append({**({"name": name} if name else {}), **fields})
        return len(self.document["nodes"]) - 1

    def scene(self, *roots: int) -> GltfBuilder:
        """Make some nodes the roots of the default scene."""
        self.document |= {"scene": 0, "scenes": [{"nodes": list(roots)}]}
        return self

    def write_glb(self, path: Path) -> Path:
        """Write a binary file."""
        if self.binary and not self.document["buffers"]:
            self.document["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.document).encode()
        chunks = [(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", self.binary + b"\0" * (-len(self.binary) % 4))]
        body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks if data)
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
        return path

    def write_gltf(self, path: Path, binary: str | None = None) -> Path:
        """Write a JSON file, with its data in a file of the name `binary` beside it, or in the file itself."""
        uri = "data:application/octet-stream;base64," + b64encode(self.binary).decode()
        if binary is not None:
            (path.parent / binary).write_bytes(self.binary)
            uri = binary.replace(" ", "%20")
        self.document["buffers"] = [{"byteLength": len(self.binary), "uri": uri}]
        path.write_text(json.dumps(self.document), encoding="utf-8")
        return path


def box(size: tuple[float, float, float], at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    """A box with its centre at a point."""
    return trimesh.creation.box(size).apply_translation(at)


BODY, DOOR, KNOB = box((1.0, 2.0, 0.5)), box((0.9, 1.8, 0.05), (0.0, 0.0, 0.3)), box((0.05, 0.05, 0.05), (0.4, 0.0, 0.35))
PARTS = {"body": BODY, "door": DOOR, "knob": KNOB}


def cabinet() -> GltfBuilder:
    """A cabinet: a body, and a door with its knob."""
    made = GltfBuilder()
    body, door, knob = (made.node(name, mesh=made.mesh(mesh)) for name, mesh in PARTS.items())
    return made.scene(made.node("StorageFurniture", children=[body, made.node("leaf", children=[door, knob])]))
