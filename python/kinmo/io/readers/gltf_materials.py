"""Materials and images of glTF 2.0, and the texture coordinates and colours of primitives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import cast, get_args

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.look import NO_MATERIAL, AlphaMode, Image, Look, Material
from kinmo.io.readers.gltf_file import GltfFile, data_of_uri, extension, file_of_uri
from kinmo.io.readers.image_files import Ignore, ImageBudget, ImageFiles
from kinmo.io.readers.json_field import JsonField

F64 = NDArray[np.float64]

Values = Callable[[str], F64 | None]
"""Gives the values [V, width] of an attribute of a primitive by its name. None if it has none."""

TRANSFORM, GLOSSY = "KHR_texture_transform", "KHR_materials_pbrSpecularGlossiness"
_OTHER_IMAGES = ("EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif")
"""Extensions that name an image of another format."""
_KNOWN_EXTENSIONS = tuple(
    f"KHR_materials_{name}"
    for name in (
        "anisotropy", "clearcoat", "dispersion", "emissive_strength", "ior", "iridescence", "sheen", "specular", "transmission",
        "unlit", "variants", "volume",
    )
)  # fmt: skip
"""Extensions that are ignored, and reported by name."""
_REPEAT = 10497
_UNUSED_TEXTURES = {"normalTexture": "normal maps", "occlusionTexture": "occlusion maps", "emissiveTexture": "emission maps"}


@dataclass(frozen=True, eq=False)
class _Texture:
    """An image, the number of the texture coordinates it uses, and the transform [2, 3] of those."""

    image: Image | None
    coordinates: int
    transform: F64 | None


_NO_TEXTURE = _Texture(None, 0, None)


class GltfMaterials:
    """Reads the materials of one file, each once. What is not read is reported to `ignore`."""

    def __init__(self, file: GltfFile, ignore: Ignore) -> None:
        self._file = file
        self._ignore = ignore
        self._files = ImageFiles(file.path.parent, ignore)
        self._budget = ImageBudget(ignore)
        self._materials: dict[int, tuple[Material, _Texture]] = {}
        self._images: dict[int, Image | None] = {}
        self._broken: str | None = None

    def look(self, primitive: JsonField, faces: NDArray[np.uint32], count: int, values: Values) -> Look | None:
        """The look of the faces [F, 3] of a primitive with `count` vertices. None if it has none, or it is broken."""
        try:
            return self._look(primitive, faces, count, values)
        except InputError as error:
            if self._broken is None:
                self._broken = f"materials that are broken (first {error.field}: {error.problem})"
            self._ignore(self._broken)
            return None

    def _look(self, primitive: JsonField, faces: NDArray[np.uint32], count: int, values: Values) -> Look | None:
        material, texture = None, _NO_TEXTURE
        if not primitive["material"].is_absent:
            material, texture = self._material(primitive["material"])

        def corners(name: str, widths: tuple[int, ...]) -> F64 | None:
            found = values(name)
            if found is None:
                return None
            if len(found) != count or found.shape[1] not in widths or not np.isfinite(found).all():
                raise primitive["attributes"][name].fail(f"expected the values of {count} vertices")
            return np.asarray(found[faces])

        uvs, colors = corners(f"TEXCOORD_{texture.coordinates}", (2,)), corners("COLOR_0", (3, 4))
        normals = corners("NORMAL", (3,))
        if material is None and uvs is None and colors is None and normals is None:
            return None
        if texture.image is not None and uvs is None:
            self._ignore("images of meshes without texture coordinates")
        if uvs is not None:
            if texture.transform is not None:
                uvs = uvs @ texture.transform[:, :2].T + texture.transform[:, 2]
            uvs = np.stack([uvs[..., 0], 1.0 - uvs[..., 1]], axis=-1)  # glTF counts from the upper left
        if colors is not None:
            opaque = np.ones((*colors.shape[:2], 4 - colors.shape[2]))
            colors = np.clip(np.concatenate([colors, opaque], axis=2), 0.0, 1.0)
        return Look(
            () if material is None else (material,),
            np.full(len(faces), NO_MATERIAL if material is None else 0, np.int32),
            uvs,
            None if colors is None else colors.astype(np.float32),
            None if normals is None else normals.astype(np.float32),
        )

    def _material(self, index: JsonField) -> tuple[Material, _Texture]:
        number = index.integer()
        if number not in self._materials:
            self._materials[number] = self._read_material(self._file.entry("materials", index))
        return self._materials[number]

    def _read_material(self, field: JsonField) -> tuple[Material, _Texture]:
        surface, glossy = field["pbrMetallicRoughness"], extension(field, GLOSSY)
        for name, what in _UNUSED_TEXTURES.items():
            if not field[name].is_absent:
                self._ignore(what)
        extensions = field["extensions"].value
        for name in extensions if isinstance(extensions, dict) else ():
            if name != GLOSSY:
                self._ignore(name if name in _KNOWN_EXTENSIONS else "other extensions of materials")
        color, texture, metallic, roughness = np.ones(4), _NO_TEXTURE, 1.0, 1.0
        if not glossy.is_absent:
            color, texture = _numbers(glossy["diffuseFactor"], color), self._texture(glossy["diffuseTexture"])
            metallic, roughness = 0.0, 1.0 - glossy["glossinessFactor"].number(1.0)
        elif not surface.is_absent:
            color, texture = _numbers(surface["baseColorFactor"], color), self._texture(surface["baseColorTexture"])
            metallic, roughness = surface["metallicFactor"].number(1.0), surface["roughnessFactor"].number(1.0)
            if not surface["metallicRoughnessTexture"].is_absent:
                self._ignore("maps of metalness and roughness")
        mode = field["alphaMode"].text("OPAQUE")
        red, green, blue, opacity = np.clip(color, 0.0, 1.0).tolist()
        emitted = np.clip(_numbers(field["emissiveFactor"], np.zeros(3)), 0.0, 1.0).tolist()
        material = Material(
            field["name"].text(""),
            (red, green, blue, opacity),
            texture.image,
            min(max(metallic, 0.0), 1.0),
            min(max(roughness, 0.0), 1.0),
            (emitted[0], emitted[1], emitted[2]),
            field["doubleSided"].flag(),
            cast(AlphaMode, mode) if mode in get_args(AlphaMode) else "OPAQUE",
            field["alphaCutoff"].number(0.5),
        )
        return material, texture

    def _texture(self, field: JsonField) -> _Texture:
        """The texture that a field of a material names."""
        if field.is_absent:
            return _NO_TEXTURE
        entry, changed = self._file.entry("textures", field["index"]), extension(field, TRANSFORM)
        coordinates = field["texCoord"].integer(0)
        if not changed.is_absent:
            coordinates = changed["texCoord"].integer(coordinates)
        source = entry["source"]
        for name in _OTHER_IMAGES:
            if not extension(entry, name).is_absent and (source.is_absent or name == _OTHER_IMAGES[0]):
                source = extension(entry, name)["source"]
        if not entry["sampler"].is_absent:
            sampler = self._file.entry("samplers", entry["sampler"])
            if any(sampler[name].integer(_REPEAT) != _REPEAT for name in ("wrapS", "wrapT")):
                self._ignore("textures that do not repeat (which matters outside of [0, 1] alone)")
        image = None if source.is_absent else self._image(source)
        return _Texture(image, coordinates, None if changed.is_absent else _transform(changed))

    def _image(self, index: JsonField) -> Image | None:
        number = index.integer()
        if number not in self._images:
            self._images[number] = self._read_image(self._file.entry("images", index))
        return self._images[number]

    def _read_image(self, field: JsonField) -> Image | None:
        name, uri = field["name"].text(""), field["uri"]
        if uri.is_absent:
            return self._budget.image(self._file.view(field["bufferView"]).data, name)
        if uri.whole_text().startswith("data:"):
            return self._budget.image(data_of_uri(uri), name)
        return self._files.read(file_of_uri(uri))


def _numbers(field: JsonField, default: F64) -> F64:
    return default if field.is_absent else field.vector(len(default))


def _transform(field: JsonField) -> F64:
    """The transform [2, 3] of KHR_texture_transform: a scale, then a rotation, then an offset."""
    scale, offset = _numbers(field["scale"], np.ones(2)), _numbers(field["offset"], np.zeros(2))
    angle = field["rotation"].number(0.0)
    cosine, sine = math.cos(angle), math.sin(angle)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    return np.column_stack([turn * scale, offset])
