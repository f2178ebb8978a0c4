"""Textured GLB, glTF and OBJ files of a box with a door, and what they look like."""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from gltf_files import GltfBuilder
from PIL import Image
from scipy.spatial.transform import Rotation

PARTS = {"body": ((0.0, 0.0, 0.0), (1.0, 2.0, 1.0)), "door": ((0.0, 0.0, 1.0), (1.0, 2.0, 1.125))}
"""Corners of the boxes of both parts."""
SPLIT = np.arange(12) % 2 == 0
"""Faces of a box that have the first of two materials."""


@dataclass(frozen=True, eq=False)
class Textured:
    """A textured file.

    Attributes:
        path: the file.
        uvs: texture coordinates [12, 3, 2] of the corners of each part's faces, with v up. None if they do not matter.
        images: encoded images that it shows.
        base_colors: base colours of its materials.
        colors: uint8 [12, 3, 4], colours of the corners of each part. None without any.
    """

    path: Path
    uvs: dict[str, np.ndarray] | None
    images: frozenset[bytes] = frozenset()
    base_colors: frozenset[tuple[float, ...]] = frozenset({(1.0, 1.0, 1.0, 1.0)})
    colors: dict[str, np.ndarray] | None = None


def encoded(kind: str, seed: int = 0) -> bytes:
    """A random picture of 8 x 8 pixels as "PNG" or "JPEG"."""
    file = io.BytesIO()
    Image.fromarray(np.random.default_rng(seed).integers(0, 255, (8, 8, 3), np.uint8)).save(file, kind)
    return file.getvalue()


def triangles(part: str) -> np.ndarray:
    """The corners [12, 3, 3] of the faces of a part."""
    low, high = np.array(PARTS[part])
    return np.asarray(trimesh.creation.box(bounds=[low, high]).triangles)


def random_uvs(part: str, low: int = 0, high: int = 65) -> np.ndarray:
    """Texture coordinates [12, 3, 2] on a grid, so that all formats keep them exactly."""
    return np.random.default_rng(sorted(PARTS).index(part)).integers(low, high, (12, 3, 2)) / 64.0


class _Gltf:
    """A glTF document with both parts."""

    def __init__(self, uvs: dict[str, np.ndarray], name: str = "TEXCOORD_0") -> None:
        self.builder = GltfBuilder()
        self.uvs = uvs
        self.name = name
        self.document["materials"] = []

    @property
    def document(self) -> dict[str, Any]:
        return self.builder.document

    def image(self, **fields: Any) -> None:
        """Add an image, and a texture of it."""
        for name, entry in (("images", fields), ("textures", {"source": len(self.document.get("images", []))})):
            self.document.setdefault(name, []).append(entry)

    def embed(self, data: bytes, kind: str = "png") -> None:
        self.image(bufferView=self.builder.view(data), mimeType=f"image/{kind}", name="picture")

    def material(self, texture: int | None = 0, factor: tuple[float, ...] | None = None, **fields: Any) -> None:
        surface: dict[str, Any] = {} if factor is None else {"baseColorFactor": list(factor)}
        if texture is not None:
            surface["baseColorTexture"] = {"index": texture, **fields}
        self.document["materials"].append({"name": "wood", "pbrMetallicRoughness": surface})

    def parts(self, groups: tuple[np.ndarray, ...] = (np.ones(12, bool),), **more: Callable[[str], np.ndarray]) -> GltfBuilder:
        """Add both parts. Each group of faces is a primitive with a material of its own."""
        for part in PARTS:
            primitives = []
            for number, faces in enumerate(groups):
                corners = {
                    "POSITION": triangles(part)[faces].reshape(-1, 3).astype(np.float32),
                    self.name: (self.uvs[part] * [1.0, -1.0] + [0.0, 1.0])[faces].reshape(-1, 2).astype(np.float32),
                }
                attributes = {name: self.builder.accessor(values) for name, values in corners.items()}
                for name, values in more.items():
                    attributes[name] = self.builder.accessor(values(part)[faces].reshape(-1, 4), normalized=True)
                primitive: dict[str, Any] = {"attributes": attributes}
                if self.document["materials"]:
                    primitive["material"] = number
                primitives.append(primitive)
            self.document["meshes"].append({"primitives": primitives})
            self.builder.node(part, mesh=len(self.document["meshes"]) - 1)
        return self.builder.scene(*range(len(PARTS)))


def embedded_png(folder: Path, kind: str = "PNG", low: int = 0, high: int = 65) -> Textured:
    uvs, data = {part: random_uvs(part, low, high) for part in PARTS}, encoded(kind)
    gltf = _Gltf(uvs)
    gltf.embed(data, kind.lower())
    gltf.material()
    return Textured(gltf.parts().write_glb(folder / "a.glb"), uvs, frozenset({data}))


def embedded_jpeg(folder: Path) -> Textured:
    return embedded_png(folder, "JPEG")


def repeated_texture(folder: Path) -> Textured:
    return embedded_png(folder, low=-130, high=200)


def two_materials(folder: Path) -> Textured:
    uvs, images = {part: random_uvs(part) for part in PARTS}, [encoded("PNG", seed) for seed in (1, 2)]
    gltf = _Gltf(uvs)
    for number, data in enumerate(images):
        gltf.embed(data)
        gltf.material(number)
    return Textured(gltf.parts((SPLIT, ~SPLIT)).write_glb(folder / "a.glb"), uvs, frozenset(images))


def image_beside_gltf(folder: Path) -> Textured:
    uvs, data = {part: random_uvs(part) for part in PARTS}, encoded("PNG")
    (folder / "textures").mkdir()
    (folder / "textures" / "dark wood.png").write_bytes(data)
    gltf = _Gltf(uvs)
    gltf.image(uri="textures/dark%20wood.png")
    gltf.material()
    return Textured(gltf.parts().write_gltf(folder / "a.gltf", "a.bin"), uvs, frozenset({data}))


def image_in_a_data_uri(folder: Path) -> Textured:
    uvs, data = {part: random_uvs(part) for part in PARTS}, encoded("PNG")
    gltf = _Gltf(uvs)
    gltf.image(uri="data:image/png;base64," + b64encode(data).decode())
    gltf.material()
    return Textured(gltf.parts().write_gltf(folder / "a.gltf"), uvs, frozenset({data}))


def vertex_colors(folder: Path) -> Textured:
    rng = np.random.default_rng(5)
    colors = {part: np.concatenate([rng.integers(0, 255, (12, 3, 3)), np.full((12, 3, 1), 255)], axis=2) for part in PARTS}
    gltf = _Gltf({part: random_uvs(part) for part in PARTS}, "_UNUSED")
    path = gltf.parts(COLOR_0=lambda part: colors[part].astype(np.uint8)).write_glb(folder / "a.glb")
    return Textured(path, None, base_colors=frozenset(), colors=colors)


def factor_alone(folder: Path) -> Textured:
    color = (0.25, 0.5, 0.75, 1.0)
    gltf = _Gltf({part: random_uvs(part) for part in PARTS}, "_UNUSED")
    gltf.material(None, color)
    return Textured(gltf.parts().write_glb(folder / "a.glb"), None, base_colors=frozenset({color}))


def texture_transform(folder: Path) -> Textured:
    """Transform by the definition of Khronos: uv is scaled, rotated and moved, with v down."""
    uvs, data, angle = {part: random_uvs(part) for part in PARTS}, encoded("PNG"), 0.7
    gltf = _Gltf(uvs)
    gltf.embed(data)
    change = {"offset": [0.25, 0.5], "scale": [2.0, 0.5], "rotation": angle}
    gltf.material(extensions={"KHR_texture_transform": change})
    turn = Rotation.from_euler("z", -angle).as_matrix()[:2, :2]
    down = [1.0, -1.0]
    shown = {part: ((down * own + [0, 1]) * [2.0, 0.5] @ turn.T + [0.25, 0.5]) * down + [0, 1] for part, own in uvs.items()}
    return Textured(gltf.parts().write_glb(folder / "a.glb"), shown, frozenset({data}))


def second_coordinates(folder: Path) -> Textured:
    uvs, data = {part: random_uvs(part) for part in PARTS}, encoded("PNG")
    gltf = _Gltf(uvs, "TEXCOORD_1")
    gltf.embed(data)
    gltf.material(texCoord=1)
    return Textured(gltf.parts().write_glb(folder / "a.glb"), uvs, frozenset({data}))


def obj_with_mtl(folder: Path, groups: tuple[np.ndarray, ...] = (np.ones(12, bool),)) -> Textured:
    uvs, images = {part: random_uvs(part) for part in PARTS}, [encoded("PNG", seed) for seed in range(len(groups))]
    lines, count = ["mtllib a.mtl"], 0
    for part in PARTS:
        lines.append(f"o {part}")
        for corner, uv in zip(triangles(part).reshape(-1, 3), uvs[part].reshape(-1, 2), strict=True):
            lines += [f"v {corner[0]} {corner[1]} {corner[2]}", f"vt {uv[0]} {uv[1]}"]
        for number, faces in enumerate(groups):
            lines.append(f"usemtl wood {number}")
            for a in count + 3 * np.flatnonzero(faces):
                lines.append(f"f {a + 1}/{a + 1} {a + 2}/{a + 2} {a + 3}/{a + 3}")
        count += 36
    (folder / "a.obj").write_text("\n".join(lines) + "\n")
    materials = [f"newmtl wood {number}\nKd 1 1 1\nmap_Kd wood {number}.png\n" for number in range(len(groups))]
    (folder / "a.mtl").write_text("\n".join(materials))
    for number, data in enumerate(images):
        (folder / f"wood {number}.png").write_bytes(data)
    return Textured(folder / "a.obj", uvs, frozenset(images))


def obj_with_two_materials_in_a_group(folder: Path) -> Textured:
    return obj_with_mtl(folder, (SPLIT, ~SPLIT))


FIXTURES: tuple[Callable[[Path], Textured], ...] = (
    embedded_png, embedded_jpeg, repeated_texture, two_materials, image_beside_gltf, image_in_a_data_uri, vertex_colors,
    factor_alone, texture_transform, second_coordinates, obj_with_mtl, obj_with_two_materials_in_a_group,
)  # fmt: skip
"""Functions that write a textured file into a folder."""
