"""Primitives of glTF 2.0: triangles with their vertices, and the joints that move each vertex of a skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.io.readers.gltf_accessors import INDEX_TYPES, normalised, read_floats, read_numbers
from kinmo.io.readers.gltf_file import DRACO, GltfFile, extension
from kinmo.io.readers.gltf_materials import GltfMaterials
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.optional_library import optional_library

F64 = NDArray[np.float64]

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
"""Codes of primitives that have surfaces."""


@dataclass(frozen=True, eq=False)
class Primitive:
    """A primitive with triangles.

    Attributes:
        mesh: the triangles in the frame of the mesh.
        joints: numbers [V, K] of the joints that move each vertex, in the skin. None without them.
        weights: weights [V, K] of these joints.
    """

    mesh: Mesh
    joints: NDArray[np.int64] | None
    weights: F64 | None


def read_primitive(file: GltfFile, field: JsonField, materials: GltfMaterials) -> Primitive | None:
    """The triangles of a primitive, with all its vertices and its look. None for points and lines."""
    mode = field["mode"].integer(_TRIANGLES)
    position = field["attributes"]["POSITION"]
    if mode < _TRIANGLES or position.is_absent:
        return None
    if mode > _FAN:
        raise field["mode"].fail(f"expected 0 to 6, got {mode}")
    draco = extension(field, DRACO)
    if not draco.is_absent and file.entry("accessors", position)["bufferView"].is_absent:
        return _decompressed(file, field, draco, materials)
    vertices = read_floats(file, position, "VEC3")
    indices = field["indices"]
    if indices.is_absent:
        order = np.arange(len(vertices), dtype=np.uint32)
    else:
        order = read_numbers(file, indices, "SCALAR", INDEX_TYPES)[:, 0].astype(np.uint32)
        if int(order.max()) >= len(vertices):
            raise indices.fail(f"expected indices below {len(vertices)}, got {int(order.max())}")
    joints, weights = _influences(file, field["attributes"], len(vertices))
    faces, attributes = _faces(order, mode), field["attributes"]

    def values(name: str) -> F64 | None:
        width = 2 if name.startswith("TEXCOORD") else 3
        if attributes[name].is_absent:
            return None
        if name == "COLOR_0" and file.entry("accessors", attributes[name])["type"].text() == "VEC4":
            width = 4
        return read_floats(file, attributes[name], f"VEC{width}")

    return Primitive(Mesh(vertices, faces, materials.look(field, faces, len(vertices), values)), joints, weights)


def _influences(file: GltfFile, attributes: JsonField, count: int) -> tuple[NDArray[np.int64] | None, F64 | None]:
    """Joints and weights of all vertices, from all sets of four that the primitive has."""
    joints: list[NDArray[np.int64]] = []
    weights: list[F64] = []
    while not (one := attributes[f"JOINTS_{len(joints)}"]).is_absent:
        other = attributes[f"WEIGHTS_{len(joints)}"]
        joints.append(read_numbers(file, one, "VEC4", INDEX_TYPES).astype(np.int64))
        weights.append(read_floats(file, other, "VEC4"))
        if len(joints[-1]) != count or len(weights[-1]) != count:
            raise one.fail(f"expected the joints and weights of {count} vertices")
    return (np.hstack(joints), np.hstack(weights)) if joints else (None, None)


def _decompressed(file: GltfFile, field: JsonField, draco: JsonField, materials: GltfMaterials) -> Primitive:
    """A primitive compressed with Draco."""
    library = optional_library("DracoPy", "formats", file.path, "is compressed with Draco")
    data = bytes(file.view(draco["bufferView"]).data)
    try:
        decoded = library.decode(data)
        by_id = {each["unique_id"]: np.asarray(each["data"]) for each in decoded.attributes}
        faces = np.asarray(decoded.faces, np.uint32).reshape(-1, 3)
    except Exception as error:  # DracoPy raises errors of its own kinds for broken data
        raise draco.fail(f"cannot be decompressed ({type(error).__name__})") from None
    attributes = draco["attributes"]

    def values(name: str) -> NDArray[np.float64] | None:
        if attributes[name].is_absent:
            return None
        found = by_id.get(attributes[name].integer())
        if found is None or found.ndim != 2:
            raise attributes[name].fail("expected one of the attributes that are compressed")
        return found.astype(np.float64)

    vertices, joints, weights = values("POSITION"), values("JOINTS_0"), values("WEIGHTS_0")
    if vertices is None or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise draco.fail("expected finite positions")
    if len(faces) and int(faces.max()) >= len(vertices):
        raise draco.fail(f"expected indices below {len(vertices)}, got {int(faces.max())}")

    def shares(name: str) -> F64 | None:
        """Values, where normalised integers give 0 or -1 to 1 as their accessor says."""
        found, index = values(name), field["attributes"][name]
        return found if found is None or index.is_absent else normalised(found, file.entry("accessors", index))

    mesh = Mesh(vertices, faces, materials.look(field, faces, len(vertices), shares))
    if joints is None or weights is None or joints.shape != weights.shape or len(joints) != len(vertices):
        return Primitive(mesh, None, None)
    return Primitive(mesh, joints.astype(np.int64), weights)


def _faces(order: NDArray[np.uint32], mode: int) -> NDArray[np.uint32]:
    """Faces [F, 3] of a list, strip or fan of triangles."""
    if mode == _TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    count = max(len(order) - 2, 0)
    first = np.full(count, order[0]) if mode == _FAN else order[:count]
    faces = np.column_stack([first, order[1 : count + 1], order[2:]])
    if mode == _STRIP:
        faces[1::2] = faces[1::2, ::-1]
    return faces
