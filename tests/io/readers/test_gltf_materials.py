"""Materials of glTF: what is not read is said, and what is broken costs the look alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from textured_files import Textured, embedded_png, encoded, image_beside_gltf

import kinmo
from kinmo.core.look import Material
from kinmo.core.shape import Shape


def changed(made: Textured, **fields: Any) -> Shape:
    """The shape of a .gltf file after a change of its first material, or of other top-level lists."""
    document = json.loads(made.path.read_text())
    document["materials"][0] |= fields.pop("material", {})
    made.path.write_text(json.dumps(document | fields))
    return kinmo.load(made.path)


def material_of(shape: Shape) -> Material:
    (material,) = {material for mesh in shape.meshes() if mesh.look is not None for material in mesh.look.materials}
    return material


def test_a_material_is_read_in_full(tmp_path: Path) -> None:
    surface = {"baseColorFactor": [0.5, 0.25, 1.0, 0.75], "metallicFactor": 0.25, "roughnessFactor": 0.5}
    fields = {"alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": True, "emissiveFactor": [0.0, 0.5, 0.0], "name": "oak"}
    shape = changed(image_beside_gltf(tmp_path), material={"pbrMetallicRoughness": surface, **fields})
    expected = Material("oak", (0.5, 0.25, 1.0, 0.75), None, 0.25, 0.5, (0.0, 0.5, 0.0), True, "MASK", 0.25)
    assert material_of(shape) == expected and shape.repairs == ()


@pytest.mark.parametrize(
    ("material", "line"),
    [
        ({"normalTexture": {"index": 0}}, "normal maps ignored: 1"),
        ({"extensions": {"KHR_materials_clearcoat": {}}}, "KHR_materials_clearcoat ignored: 1"),
        ({"extensions": {"ACME_glitter": {}}}, "other extensions of materials ignored: 1"),
        ({"pbrMetallicRoughness": {"baseColorTexture": {"index": 7}}}, "materials that are broken (first materials[0]"),
        ({"alphaCutoff": "half"}, "materials that are broken (first materials[0].alphaCutoff"),
    ],
)
def test_what_is_not_read_is_one_repair(tmp_path: Path, material: dict[str, Any], line: str) -> None:
    (repair,) = changed(image_beside_gltf(tmp_path), material=material).repairs
    assert repair.startswith(line)


def test_a_missing_image_is_one_repair_and_keeps_the_material(tmp_path: Path) -> None:
    made = image_beside_gltf(tmp_path)
    (tmp_path / "textures" / "dark wood.png").unlink()
    shape = kinmo.load(made.path)
    assert shape.repairs == ("image dark wood.png (missing) ignored: 1",)
    assert material_of(shape) == Material("wood", metallic=1.0, double_sided=False)


def test_an_image_of_an_unknown_format_is_one_repair(tmp_path: Path) -> None:
    made = image_beside_gltf(tmp_path)
    (tmp_path / "textures" / "dark wood.png").write_bytes(b"no image at all")
    (repair,) = kinmo.load(made.path).repairs
    assert repair.startswith("images of a format other than PNG")


def test_specular_materials_of_older_files_are_converted(tmp_path: Path) -> None:
    glossy = {"diffuseFactor": [0.5, 0.5, 0.5, 1.0], "diffuseTexture": {"index": 0}, "glossinessFactor": 0.75}
    material = {"pbrMetallicRoughness": None, "extensions": {"KHR_materials_pbrSpecularGlossiness": glossy}}
    found = material_of(changed(image_beside_gltf(tmp_path), material=material))
    assert (found.metallic, found.roughness, found.base_color[0]) == (0.0, 0.25, 0.5)
    assert found.image is not None and found.image.data == encoded("PNG")


def test_equal_parts_have_the_same_geometry_with_and_without_a_look(tmp_path: Path) -> None:
    shape = kinmo.load(embedded_png(tmp_path).path)
    for mesh in shape.meshes():
        assert mesh.look is not None and len(mesh.look.material) == len(mesh.faces)
        np.testing.assert_array_equal(mesh.bare.triangles, mesh.triangles)
