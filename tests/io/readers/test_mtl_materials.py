"""Materials of OBJ files in the forms that tools write."""

from __future__ import annotations

from pathlib import Path

import pytest
from textured_files import encoded, obj_with_mtl

import kinmo
from kinmo.core.look import Material
from kinmo.core.shape import Shape


def shape_with(folder: Path, mtl: str) -> Shape:
    made = obj_with_mtl(folder)
    (folder / "a.mtl").write_text(mtl)
    return kinmo.load(made.path)


def material_of(shape: Shape) -> Material:
    (material,) = {material for mesh in shape.meshes() if mesh.look is not None for material in mesh.look.materials}
    return material


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("Kd .5 .25 1\nd 0.5", {"base_color": (0.5, 0.25, 1.0, 0.5), "alpha_mode": "BLEND"}),
        ("kd 0.5\nTr 0.25", {"base_color": (0.5, 0.5, 0.5, 0.75), "alpha_mode": "BLEND"}),
        ("Kd 1 1 1\nPm 0.75\nPr 0.5\nNs 90", {"metallic": 0.75, "roughness": 0.5}),
        ("\tKd 1 1 1\nNs 250", {"roughness": 0.5}),
        ("Ke 0 0.5 0\nKd broken numbers here", {"emissive": (0.0, 0.5, 0.0)}),
    ],
)
def test_values_of_a_material(tmp_path: Path, lines: str, expected: dict[str, object]) -> None:
    found = material_of(shape_with(tmp_path, f"newmtl other\nKd 0 0 0\nnewmtl wood 0\n{lines}\n"))
    assert {name: getattr(found, name) for name in expected} == expected


@pytest.mark.parametrize(
    "name", ["wood 0.png", "./wood 0.png", "C:\\textures\\wood 0.png", "missing/wood 0.png", "-s 1 1 1 wood 0.png"]
)
def test_images_are_found_by_path_or_beside_the_mtl_file(tmp_path: Path, name: str) -> None:
    found = material_of(shape_with(tmp_path, f"newmtl wood 0\nKd 0 0 0\nmap_Kd {name}\n"))
    assert found.image is not None and found.image.data == encoded("PNG")
    assert found.base_color == (1.0, 1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("line", "repair"),
    [
        ("map_Bump wood 0.png", "normal maps ignored: 1"),
        ("map_Kd -clamp on wood 0.png", "options of textures ignored: 1"),
        ("map_Kd lost.png", "image lost.png (missing) ignored: 1"),
    ],
)
def test_what_is_not_read_is_one_repair(tmp_path: Path, line: str, repair: str) -> None:
    assert shape_with(tmp_path, f"newmtl wood 0\n{line}\n").repairs == (repair,)


def test_a_missing_mtl_file_is_one_repair(tmp_path: Path) -> None:
    made = obj_with_mtl(tmp_path)
    (tmp_path / "a.mtl").unlink()
    shape = kinmo.load(made.path)
    assert shape.repairs == ("materials a.mtl (missing) ignored: 1",)
    assert all(mesh.look is not None and mesh.look.uvs is not None for mesh in shape.meshes())
