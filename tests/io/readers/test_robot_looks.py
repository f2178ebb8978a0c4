"""Looks of URDF and MJCF files: their materials reach the parts, and what is not read is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from textured_files import encoded

import kinmo
from kinmo.core.look import Material
from kinmo.io.discover import ShapeSource
from kinmo.io.source_files import fingerprint

BOX = '<geometry><box size="1 1 1"/></geometry>'
QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
OWN_MATERIAL = "mtllib own.mtl\nusemtl own\n"


def urdf(folder: Path, visuals: dict[str, str], materials: str = "") -> kinmo.Shape:
    """A URDF with a link for each visual, one above the other."""
    links = [f'<link name="{name}"><visual>{visual}</visual></link>' for name, visual in visuals.items()]
    first, *others = visuals
    joints = [
        f'<joint name="{name}_joint" type="fixed"><parent link="{first}"/><child link="{name}"/>'
        f'<origin xyz="0 0 {2 * place}"/></joint>'
        for place, name in enumerate(others, 1)
    ]
    (folder / "a.urdf").write_text(f'<robot name="a">{materials}{"".join(links + joints)}</robot>')
    return kinmo.load(folder / "a.urdf")


def mjcf(folder: Path, geoms: dict[str, str], assets: str = "") -> kinmo.Shape:
    """An MJCF with a body for each geom, one above the other."""
    bodies = [
        f'<body name="{name}" pos="0 0 {2 * place}"><geom {geom}/></body>' for place, (name, geom) in enumerate(geoms.items())
    ]
    (folder / "a.xml").write_text(
        f'<mujoco><compiler meshdir="meshes" texturedir="images"/><asset>{assets}</asset>'
        f"<worldbody>{''.join(bodies)}</worldbody></mujoco>"
    )
    return kinmo.load(folder / "a.xml")


def material_of(shape: kinmo.Shape, name: str) -> Material | None:
    """The material of all faces of a part. None if it has none."""
    part = next(part for part in shape.parts if part.name == name)
    assert part.mesh is not None
    if part.mesh.look is None:
        return None
    ((material, _),) = part.mesh.look.used()
    return material


def unread(shape: kinmo.Shape) -> list[str]:
    return [line for line in shape.repairs if "ignored" in line]


def test_colours_of_urdf_reach_their_parts_by_element_and_by_name(tmp_path: Path) -> None:
    shape = urdf(
        tmp_path,
        {
            "inside": BOX + '<material name="red"><color rgba="0.9 0.1 0.2 1"/></material>',
            "named": BOX + '<material name="grey"/>',
            "earlier": BOX + '<material name="red"/>',
            "glass": BOX + '<material name=""><color rgba="0 0 1 0.5"/></material>',
            "plain": BOX,
        },
        '<material name="grey"><color rgba="0.3 0.3 0.3 1"/></material>',
    )
    colors = {part.name: material_of(shape, part.name) for part in shape.parts if part.mesh is not None}
    assert {name: None if found is None else found.base_color for name, found in colors.items()} == {
        "inside": (0.9, 0.1, 0.2, 1.0),
        "named": (0.3, 0.3, 0.3, 1.0),
        "earlier": (0.9, 0.1, 0.2, 1.0),
        "glass": (0.0, 0.0, 1.0, 0.5),
        "plain": None,
    }
    assert colors["glass"] is not None and colors["glass"].alpha_mode == "BLEND"
    assert unread(shape) == []


def test_an_image_of_a_urdf_is_on_a_mesh_with_texture_coordinates(tmp_path: Path) -> None:
    (tmp_path / "quad.obj").write_text(QUAD)
    (tmp_path / "wood.png").write_bytes(encoded("PNG"))
    wood = '<material name="wood"><texture filename="wood.png"/></material>'
    shape = urdf(tmp_path, {"quad": f'<geometry><mesh filename="quad.obj"/></geometry>{wood}', "box": BOX + wood})
    found = material_of(shape, "quad")
    assert found is not None and found.image is not None and found.image.data == encoded("PNG")
    assert unread(shape) == ["images of meshes without texture coordinates ignored: 1"]


@pytest.mark.parametrize(
    ("color", "expected"),
    [("0.2 0.4 0.6 1", []), ("1 0 0 1", ["materials of meshes that have materials of their own ignored: 1"])],
)
def test_a_mesh_with_an_mtl_file_keeps_its_materials(tmp_path: Path, color: str, expected: list[str]) -> None:
    (tmp_path / "quad.obj").write_text(OWN_MATERIAL + QUAD)
    (tmp_path / "own.mtl").write_text("newmtl own\nKd 0.2 0.4 0.6\n")
    visual = f'<geometry><mesh filename="quad.obj"/></geometry><material name="x"><color rgba="{color}"/></material>'
    shape = urdf(tmp_path, {"quad": visual, "box": BOX})
    found = material_of(shape, "quad")
    assert found is not None and found.base_color == (0.2, 0.4, 0.6, 1.0)
    assert unread(shape) == expected


@pytest.mark.parametrize(
    ("material", "line"),
    [
        ('<material name="unknown"/>', "materials without a colour or image"),
        ('<material name="x"><color rgba="red"/></material>', "materials that are broken"),
        ('<material name="x"><color rgba="1 0 0 0"/></material>', "materials that are wholly transparent"),
        ('<material name="x"><texture filename="no.png"/></material>', "image no.png (missing)"),
    ],
)
def test_a_material_of_a_urdf_that_cannot_be_used_is_one_line(tmp_path: Path, material: str, line: str) -> None:
    assert unread(urdf(tmp_path, {"a": BOX + material, "b": BOX})) == [f"{line} ignored: 1"]


def test_materials_of_dae_meshes_in_a_urdf_are_said_to_be_unread(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    trimesh.creation.box().export(tmp_path / "box.dae")
    visual = '<geometry><mesh filename="box.dae"/></geometry>'
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    shape = urdf(tmp_path, {"a": visual, "b": visual + red})
    assert unread(shape) == ["materials ignored: 1"], "the file is read once"
    found = material_of(shape, "b")
    assert found is not None and found.base_color == (1.0, 0.0, 0.0, 1.0)


def test_colours_and_materials_of_mjcf_reach_their_parts(tmp_path: Path) -> None:
    box = 'type="box" size="0.5 0.5 0.5"'
    shape = mjcf(
        tmp_path,
        {
            "colored": f'{box} rgba="0.9 0.1 0.2 1"',
            "steel": f'{box} material="steel"',
            "both": f'{box} material="steel" rgba="0 1 0 0.5"',
            "plain": box,
        },
        '<material name="steel" rgba="0.7 0.7 0.8 1" shininess="0.75"/>',
    )
    colored, steel, both = (material_of(shape, name) for name in ("colored", "steel", "both"))
    assert colored is not None and colored.base_color == (0.9, 0.1, 0.2, 1.0)
    assert steel is not None and (steel.base_color, steel.roughness) == ((0.7, 0.7, 0.8, 1.0), 0.25)
    assert both is not None and (both.base_color, both.roughness, both.alpha_mode) == ((0.0, 1.0, 0.0, 0.5), 0.25, "BLEND")
    assert material_of(shape, "plain") is None
    assert unread(shape) == []


def test_an_image_of_mjcf_is_on_a_mesh_with_texture_coordinates(tmp_path: Path) -> None:
    for folder in ("meshes", "images"):
        (tmp_path / folder).mkdir()
    (tmp_path / "meshes" / "quad.obj").write_text(OWN_MATERIAL + QUAD)
    (tmp_path / "images" / "wood.png").write_bytes(encoded("PNG"))
    assets = (
        '<mesh name="quad" file="quad.obj"/><texture name="wood" type="2d" file="wood.png"/>'
        '<texture name="board" type="2d" builtin="checker" width="8" height="8"/>'
        '<material name="wood" texture="wood"/><material name="board" texture="board"/>'
    )
    box = 'type="box" size="0.5 0.5 0.5"'
    geoms = {"quad": 'type="mesh" mesh="quad" material="wood"', "box": f'{box} material="wood"', "b": f'{box} material="board"'}
    shape = mjcf(tmp_path, geoms, assets)
    found = material_of(shape, "quad")
    assert found is not None and found.image is not None and found.image.data == encoded("PNG")
    mesh = next(part.mesh for part in shape.parts if part.name == "quad")
    assert mesh is not None and mesh.look is not None and mesh.look.uvs is not None
    np.testing.assert_allclose(mesh.look.uvs, mesh.triangles[..., :2])
    assert unread(shape) == [
        "images of geoms without texture coordinates ignored: 1",
        "textures that MuJoCo computes ignored: 1",
    ]


@pytest.mark.parametrize(
    ("geom", "line"),
    [
        ('material="unknown"', "materials that are missing"),
        ('material="clear"', "materials that are wholly transparent"),
        ('material="sky"', "textures of cubes and skies"),
    ],
)
def test_a_material_of_mjcf_that_cannot_be_used_is_one_line(tmp_path: Path, geom: str, line: str) -> None:
    box = 'type="box" size="0.5 0.5 0.5"'
    assets = '<texture name="sky" file="sky.png"/><material name="sky" texture="sky"/><material name="clear" rgba="1 1 1 0"/>'
    assert unread(mjcf(tmp_path, {"a": f"{box} {geom}", "b": box}, assets)) == [f"{line} ignored: 1"]


def test_a_change_of_a_material_or_an_image_of_a_urdf_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "quad.obj").write_text(OWN_MATERIAL + QUAD)
    (tmp_path / "own.mtl").write_text("newmtl own\nmap_Kd own.png\n")
    for name in ("own", "wood"):
        (tmp_path / f"{name}.png").write_bytes(encoded("PNG"))
    wood = '<material name="wood"><texture filename="wood.png"/></material>'
    shape = urdf(tmp_path, {"quad": '<geometry><mesh filename="quad.obj"/></geometry>', "box": BOX + wood})
    found = ShapeSource(shape.source, "urdf", shape.id)
    assert [row[0] for row in fingerprint(found)] == ["a.urdf", "quad.obj", "own.mtl", "own.png", "wood.png"]
    for name in ("own.mtl", "own.png", "wood.png"):
        before = fingerprint(found)
        (tmp_path / name).write_bytes((tmp_path / name).read_bytes() + b"\n")
        assert fingerprint(found) != before


def test_a_change_of_an_image_of_mjcf_is_noticed(tmp_path: Path) -> None:
    for folder in ("meshes", "images"):
        (tmp_path / folder).mkdir()
    (tmp_path / "meshes" / "quad.obj").write_text(OWN_MATERIAL + QUAD)
    (tmp_path / "meshes" / "own.mtl").write_text("newmtl own\nKd 1 0 0\n")
    (tmp_path / "images" / "wood.png").write_bytes(encoded("PNG"))
    assets = '<mesh file="quad.obj"/><texture name="wood" type="2d" file="wood.png"/><material name="wood" texture="wood"/>'
    shape = mjcf(tmp_path, {"quad": 'type="mesh" mesh="quad" material="wood"'}, assets)
    found = ShapeSource(shape.source, "mjcf", shape.id)
    before = fingerprint(found)
    assert [row[0] for row in before] == ["a.xml", "meshes/quad.obj", "images/wood.png"], "MuJoCo reads no MTL files"
    (tmp_path / "images" / "wood.png").write_bytes(encoded("PNG", seed=1))
    assert fingerprint(found) != before
