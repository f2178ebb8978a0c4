"""Elements `<material>` of URDF: a colour, or an image."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.look import Material
from kinmo.core.shape import Mesh
from kinmo.core.wording import clean_text
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.robot_looks import INVISIBLE, has_coordinates, has_own_look, looks_like, plain_material, with_material
from kinmo.io.readers.robot_meshes import mesh_path
from kinmo.io.readers.robot_numbers import read_numbers

BROKEN = "materials that are broken"


class UrdfMaterials:
    """The materials of one URDF file.

    Args:
        path: the file.
        root: its element `<robot>`.
        home: a folder at or above that of the file, which no path of an image may lead out of.
        files: reads the images, and receives what is not read.
    """

    def __init__(self, path: Path, root: ET.Element, home: Path, files: MtlMaterials) -> None:
        self._path = path
        self._home = home
        self._files = files
        self._made: dict[ET.Element, Material | None] = {}
        self._named: dict[str, ET.Element] = {}
        for element in (*root.findall("material"), *root.findall("link/visual/material")):
            if len(element):
                self._named.setdefault(element.get("name") or "", element)

    def on(self, mesh: Mesh, visual: ET.Element) -> Mesh:
        """The mesh of a visual with the material of the visual. A mesh that has a look of its own keeps it."""
        element = visual.find("material")
        if element is None:
            return mesh
        if not len(element):
            name = element.get("name") or ""
            if name not in self._named:
                if not has_own_look(mesh):
                    self._files.ignore("materials without a colour or image")
                return mesh
            element = self._named[name]
        if element not in self._made:
            self._made[element] = self._material(element)
        material = self._made[element]
        if material is None:
            return mesh
        if has_own_look(mesh):
            if not looks_like(mesh, material):
                self._files.ignore("materials of meshes that have materials of their own")
            return mesh
        if material.image is not None and not has_coordinates(mesh):
            self._files.ignore("images of meshes without texture coordinates")
        return with_material(mesh, material)

    def _material(self, element: ET.Element) -> Material | None:
        """The material of an element. None if it is broken or invisible."""
        color, texture = element.find("color"), element.find("texture")
        try:
            rgba = read_numbers(self._path, {} if color is None else color.attrib, "rgba", (1.0, 1.0, 1.0, 1.0))
        except InputError:
            self._files.ignore(BROKEN)
            return None
        red, green, blue, opacity = rgba.clip(0.0, 1.0).tolist()
        if opacity == 0.0:
            self._files.ignore(INVISIBLE)
            return None
        name = (texture.get("filename") or "") if texture is not None else ""
        image = self._files.image(mesh_path(name, self._path, self._home)) if name else None
        return plain_material(clean_text(element.get("name") or ""), (red, green, blue, opacity), image)
