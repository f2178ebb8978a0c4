"""Looks of MJCF: colours of geoms, materials, and images on meshes."""

from __future__ import annotations

from kinmo.core.look import Image
from kinmo.core.shape import Mesh
from kinmo.core.wording import clean_text
from kinmo.io.readers.mjcf_document import Attributes, MjcfDocument
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.robot_looks import INVISIBLE, has_coordinates, plain_material, with_material
from kinmo.io.readers.robot_numbers import read_numbers

GEOM_COLOR = (0.5, 0.5, 0.5, 1.0)
"""Colour of geoms without any, which does not replace that of a material."""


class MjcfMaterials:
    """The materials of one document.

    Args:
        document: the document.
        files: reads the images, and receives what is not read.
    """

    def __init__(self, document: MjcfDocument, files: MtlMaterials) -> None:
        self._document = document
        self._files = files
        self._materials = dict(document.assets("material"))
        self._textures = dict(document.assets("texture"))

    def on(self, mesh: Mesh, geom: Attributes) -> Mesh:
        """The mesh of a geom with its material or colour. The mesh keeps its own look if the geom has neither."""
        color = self._color(geom, GEOM_COLOR)
        if "material" not in geom:
            return mesh if color == GEOM_COLOR else self._with_color(mesh, "", color)
        name = geom["material"]
        if name not in self._materials:
            self._files.ignore("materials that are missing")
            return mesh
        asset = self._materials[name]
        if color == GEOM_COLOR:
            color = self._color(asset, (1.0, 1.0, 1.0, 1.0))
        image = self._image(asset)
        if image is not None and not has_coordinates(mesh):
            self._files.ignore("images of geoms without texture coordinates")
            image = None
        shine = float(read_numbers(self._document.path, asset, "shininess", (0.5,)).clip(0.0, 1.0)[0])
        return self._with_color(mesh, clean_text(name), color, image, 1.0 - shine)

    def _with_color(
        self,
        mesh: Mesh,
        name: str,
        color: tuple[float, float, float, float],
        image: Image | None = None,
        roughness: float = 1.0,
    ) -> Mesh:
        if color[3] == 0.0:
            self._files.ignore(INVISIBLE)
            return mesh
        return with_material(mesh, plain_material(name, color, image, roughness))

    def _color(self, attributes: Attributes, default: tuple[float, ...]) -> tuple[float, float, float, float]:
        found = read_numbers(self._document.path, attributes, "rgba", default)
        red, green, blue, opacity = found.clip(0.0, 1.0).tolist()
        return red, green, blue, opacity

    def _image(self, asset: Attributes) -> Image | None:
        """The image of a material. None if it has none, or it cannot be used, which is reported."""
        if "texture" not in asset:
            return None
        texture = self._textures.get(asset["texture"])
        if texture is None or "file" not in texture:
            self._files.ignore("textures that MuJoCo computes" if texture is not None else "textures that are missing")
        elif texture.get("type", "cube") != "2d":
            self._files.ignore("textures of cubes and skies")
        else:
            return self._files.image(self._document.texture_path(texture["file"]))
        return None
