"""The reader of 3MF files."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

import kinmo

MODEL = """<?xml version="1.0"?>
<model unit="inch" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"><resources>{objects}</resources>
<build>{items}</build></model>"""
MESH = """<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex z="0" x="0" y="1"/></vertices>
<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>"""

FAR_MESH = MESH.replace('v3="2"', 'v3="8"')


def threemf(path: Path, objects: str, items: str, **others: str) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("3D/3dmodel.model", MODEL.format(objects=objects, items=items))
        for name, text in others.items():
            archive.writestr(f"3D/{name}.model", MODEL.format(objects=text, items=""))
    return path


def test_the_components_of_a_3mf_file_are_nodes(tmp_path: Path) -> None:
    objects = f"""<object id="1" name="leaf">{MESH}</object><object id="2" type="support">{MESH}</object>
        <object id="3" name="door"><components><component objectid="1"/>
        <component objectid="7" p:path="/3D/other.model" transform="1 0 0 0 1 0 0 0 1 0 0 4"/></components></object>"""
    items = '<item objectid="3"/><item objectid="1" transform="0 1 0 -1 0 0 0 0 1 5 0 0"/><item objectid="2"/>'
    shape = kinmo.load(threemf(tmp_path / "a.3mf", objects, items, other=f'<object id="7">{MESH}</object>'))
    below = [(shape.parts[part.parent].name, part.name) for part in shape.parts if part.parent is not None]
    assert sorted(below) == [("", "door"), ("", "leaf"), ("door", ""), ("door", "leaf")]
    assert (shape.up, shape.metres_per_unit, shape.repairs) == ((0.0, 0.0, 1.0), 0.0254, ("supports ignored: 1",))
    (turned,) = (part.mesh for part in shape.parts if part.name == "leaf" and part.parent == 0)
    assert turned is not None
    assert turned.vertices.tolist() == [[5.0, 0.0, 0.0], [5.0, 1.0, 0.0], [4.0, 0.0, 0.0]]


def test_materials_that_a_format_has_but_kinmo_does_not_read_are_said(tmp_path: Path) -> None:
    colors = "".join(f'<base name="{name}" displaycolor="#ff0000"/>' for name in ("oak", "steel"))
    colors = f'<basematerials id="9">{colors}</basematerials>'
    objects = f'{colors}<object id="1" name="leaf">{MESH}</object><object id="2" name="body">{MESH}</object>'
    shape = kinmo.load(threemf(tmp_path / "a.3mf", objects, '<item objectid="1"/><item objectid="2"/>'))
    assert shape.repairs == ("materials ignored: 2",)


@pytest.mark.parametrize(
    ("objects", "items", "problem"),
    [
        ("", '<item objectid="4"/>', "object 4 is used, but not in the file"),
        (
            f'<object id="1">{FAR_MESH}</object>',
            '<item objectid="1"/>',
            "a triangle names a vertex outside 0..2",
        ),
        (f'<object id="1">{MESH.replace("x=", "w=")}</object>', '<item objectid="1"/>', "has no attribute x"),
        (f'<object id="1">{MESH.replace("0", "zero")}</object>', '<item objectid="1"/>', "expected numbers"),
        ('<object id="1"><components><component objectid="1"/></components></object>', '<item objectid="1"/>', "nested deeper"),
        ("<object", "", "is no XML"),
    ],
)
def test_a_broken_3mf_file_is_an_error(objects: str, items: str, problem: str, tmp_path: Path) -> None:
    with pytest.raises(kinmo.InputError, match=problem):
        kinmo.load(threemf(tmp_path / "a.3mf", objects, items))
    (tmp_path / "b.3mf").write_bytes(b"PK\x03\x04")
    with pytest.raises(kinmo.InputError, match="expected a readable 3MF file"):
        kinmo.load(tmp_path / "b.3mf")


def test_an_unknown_unit_of_a_3mf_file_is_named_once(tmp_path: Path) -> None:
    path = tmp_path / "a.3mf"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("3D/3dmodel.model", MODEL.format(objects="", items="").replace("inch", "parsec"))
    with pytest.raises(kinmo.InputError) as caught:
        kinmo.load(path)
    units = "micron, millimeter, centimeter, meter, inch, foot"
    assert str(caught.value) == f"{path}: unit: expected one of {units}, got parsec"
