"""Meshes of a GLB with their materials and images."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.look import Image, Look, Material
from kinmo.core.shape import Mesh
from kinmo.io.writers.glb_file import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GlbFile
from kinmo.io.writers.texture_images import GLTF_TYPES, Note, in_format

PLAIN: dict[str, Any] = {
    "name": "plain", "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.8}, "doubleSided": True
}  # fmt: skip
"""The material of faces that have none. glTF's own default is a metal."""


class GlbMeshes:
    """Adds meshes to a file, each material and image once.

    Args:
        file: the file.
        note: what receives a line about an image that cannot be written.
    """

    def __init__(self, file: GlbFile, note: Note) -> None:
        self._file = file
        self._note = note
        self._materials: dict[Material | None, int] = {}
        self._textures: dict[bytes, int | None] = {}

    def add(self, name: str, mesh: Mesh) -> int:
        """Add a mesh in the frame of its node, with one primitive for each material. Returns its index."""
        groups = [(None, np.ones(len(mesh.faces), bool))] if mesh.look is None else mesh.look.used()
        primitives = [self._primitive(mesh.part(faces), material) for material, faces in groups]
        return self._file.add("meshes", name=name, primitives=primitives)

    def _primitive(self, mesh: Mesh, material: Material | None) -> dict[str, Any]:
        columns, faces = _vertices(mesh)
        attributes = {
            name: self._file.array(values, ARRAY_BUFFER, bounds=name == "POSITION") for name, values in columns.items()
        }
        indices = self._file.array(faces.reshape(-1), ELEMENT_ARRAY_BUFFER)
        primitive: dict[str, Any] = {"attributes": attributes, "indices": indices}
        if material is not None or "COLOR_0" not in attributes:  # some readers take a material for all there is to see
            primitive["material"] = self._material(material)
        return primitive

    def _material(self, material: Material | None) -> int:
        if material not in self._materials:
            fields = PLAIN if material is None else self._fields(material)
            self._materials[material] = self._file.add("materials", **fields)
        return self._materials[material]

    def _fields(self, material: Material) -> dict[str, Any]:
        surface: dict[str, Any] = {
            "baseColorFactor": list(material.base_color),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        texture = None if material.image is None else self._texture(material.image)
        if texture is not None:
            surface["baseColorTexture"] = {"index": texture}
        fields: dict[str, Any] = {"name": material.name, "pbrMetallicRoughness": surface, "doubleSided": material.double_sided}
        if any(material.emissive):
            fields["emissiveFactor"] = list(material.emissive)
        if material.alpha_mode != "OPAQUE":
            fields["alphaMode"] = material.alpha_mode
        if material.alpha_mode == "MASK":
            fields["alphaCutoff"] = material.alpha_cutoff
        return fields

    def _texture(self, image: Image) -> int | None:
        if image.data not in self._textures:
            found = in_format(image, GLTF_TYPES, self._note)
            self._textures[image.data] = None
            if found is not None:
                view = self._file.view(found.data)
                source = self._file.add("images", name=found.name or None, mimeType=found.mime, bufferView=view)
                self._textures[image.data] = self._file.add("textures", source=source)
        return self._textures[image.data]


def _vertices(mesh: Mesh) -> tuple[dict[str, NDArray[np.float32]], NDArray[np.uint32]]:
    """Attributes [V, width] of the vertices by name, and the faces [F, 3]. Corners that agree in all of them share a vertex."""
    columns = {"POSITION": mesh.triangles.astype(np.float32)}
    look = mesh.look
    if look is None or (look.uvs is None and look.colors is None and look.normals is None):
        return {"POSITION": mesh.vertices.astype(np.float32)}, mesh.faces
    columns |= _columns(look)
    rows = np.concatenate([values.reshape(3 * len(mesh.faces), -1) for values in columns.values()], axis=1)
    first, places = _unique_rows(np.ascontiguousarray(rows + np.float32(0.0)))  # no negative zeros
    found = {name: values.reshape(3 * len(mesh.faces), -1)[first] for name, values in columns.items()}
    return found, places.reshape(-1, 3).astype(np.uint32)


def _columns(look: Look) -> dict[str, NDArray[np.float32]]:
    """Attributes [F, 3, width] of the corners by name."""
    found = {}
    if look.normals is not None:
        found["NORMAL"] = look.normals
    if look.uvs is not None:
        found["TEXCOORD_0"] = np.stack([look.uvs[..., 0], 1.0 - look.uvs[..., 1]], axis=-1).astype(np.float32)
    if look.colors is not None:
        found["COLOR_0"] = look.colors
    return found


def _unique_rows(rows: NDArray[np.float32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices [U] of different rows, and the place [N] of each row among those.

    Rows are compared by a 64-bit hash, which is far faster than their order. If two share one, they are compared in full.
    """
    factors = np.random.default_rng(0).integers(1, 2**63, rows.shape[1], np.uint64) * np.uint64(2) + np.uint64(1)
    bits = rows.view(np.uint32).astype(np.uint64)
    bits ^= bits << np.uint64(29)
    _, first, places = np.unique((bits * factors).sum(axis=1, dtype=np.uint64), return_index=True, return_inverse=True)
    if not np.array_equal(rows[first][places], rows):
        _, first, places = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, places.ravel()
