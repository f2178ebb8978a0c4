"""Mesh files of robots: every part has its own material and image in every format."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import pytest
from articulated import box_mesh
from glb_contents import GlbContents
from gltf_files import GltfBuilder, box
from pxr import Usd, UsdGeom, UsdShade
from textured_files import encoded

import kinmo
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Shape
from kinmo.io.writers import ExportOptions, write_formats

RED, GREEN, BLUE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
IMAGES = {name: encoded("PNG", seed) for seed, name in enumerate(("red", "green", "blue"))}
"""Images of three materials by name."""


def obj_of(path: Path, parts: dict[str, tuple[str, ...]], materials: dict[str, str]) -> Path:
    """Write an OBJ file with a box for each material of each part, and the lines of its MTL file by material."""
    lines, count = [f"mtllib {path.stem}.mtl", "vt 0 0"], 0
    for part, names in parts.items():
        lines.append(f"o {part}")
        for name in names:
            mesh = box_mesh((count, 0, 0), (count + 8, 1, 1))
            lines += [f"v {x} {y} {z}" for x, y, z in mesh.vertices.tolist()]
            lines.append(f"usemtl {name}")
            lines += [f"f {a}/1 {b}/1 {c}/1" for a, b, c in (mesh.faces + count + 1).tolist()]
            count += 8
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    text = "".join(f"newmtl {name}\n{own}\n" for name, own in materials.items())
    path.with_suffix(".mtl").write_text(text, encoding="utf-8")
    return path


def obj_with_two_colors(folder: Path) -> Path:
    return obj_of(folder / "a.obj", {"body": ("wood",), "handle": ("steel",)}, {"wood": "Kd 1 0 0", "steel": "Kd 0 0 1"})


def glb_with_two_colors_in_one_mesh(folder: Path) -> Path:
    builder = GltfBuilder()
    boxes = box((1.0, 2.0, 0.5)), box((0.5, 0.5, 0.5), (3.0, 0.0, 0.0))
    primitives = []
    for number, solid in enumerate(boxes):
        (primitive,) = builder.document["meshes"][builder.mesh(solid)]["primitives"]
        primitives.append({**primitive, "material": number})
    builder.document["meshes"] = [{"primitives": primitives}]
    builder.document["materials"] = [
        {"name": name, "pbrMetallicRoughness": {"baseColorFactor": [*color, 1.0]}}
        for name, color in (("wood", RED), ("steel", BLUE))
    ]
    return builder.scene(builder.node("object", mesh=0)).write_glb(folder / "a.glb")


def obj_with_images_of_one_name(folder: Path) -> Path:
    """A body in red and blue, and a door in green. All images have the same name, in three folders."""
    for name, data in IMAGES.items():
        (folder / name).mkdir()
        (folder / name / "diffuse.png").write_bytes(data)
    materials = {name: f"Kd 1 1 1\nmap_Kd {name}/diffuse.png" for name in IMAGES}
    return obj_of(folder / "a.obj", {"body": ("red", "blue"), "door": ("green",)}, materials)


def written(path: Path, *formats: str) -> tuple[Shape, Path]:
    """A file as a robot without joints, written in some formats. Returns the shape and the folder."""
    shape, folder = kinmo.load(path), path.parent / "out"
    folder.mkdir()
    write_formats(shape, Mobility((Body(0, "base", shape.leaves),)), folder, formats, ExportOptions("out", collision="none"))
    return shape, folder


def urdf_colors(folder: Path) -> list[tuple[float, ...]]:
    colors = [color.get("rgba", "") for color in ET.parse(folder / "out.urdf").iter("color")]
    return [tuple(map(float, color.split()))[:3] for color in colors]


def mjcf_colors(folder: Path) -> list[tuple[float, ...]]:
    root = ET.parse(folder / "out.xml")
    colors = {each.get("name"): each.get("rgba", "") for each in root.iter("material")}
    shown = [colors[geom.get("material")] for geom in root.iter("geom") if geom.get("mesh")]
    return [tuple(map(float, color.split()))[:3] for color in shown]


def usd_colors(folder: Path) -> list[tuple[float, ...]]:
    stage = Usd.Stage.Open(str(folder / "out.usd"))
    meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    shown = [UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].ComputeSurfaceSource()[0] for prim in meshes]
    return [tuple(surface.GetInput("diffuseColor").Get()) for surface in shown]


def glb_colors(folder: Path) -> list[tuple[float, ...]]:
    document = GlbContents((folder / "out.glb").read_bytes()).document
    shown = [[primitive["material"] for primitive in mesh["primitives"]] for mesh in document["meshes"]]
    assert len(document["materials"]) == len(shown)
    return [tuple(document["materials"][number]["pbrMetallicRoughness"]["baseColorFactor"][:3]) for (number,) in shown]


FORMATS = {"urdf": urdf_colors, "mjcf": mjcf_colors, "usd": usd_colors, "glb": glb_colors}
"""Reader of the colours of all parts from a file, by format."""


@pytest.mark.parametrize("make", [obj_with_two_colors, glb_with_two_colors_in_one_mesh])
@pytest.mark.parametrize("name", FORMATS)
def test_every_part_has_the_colour_of_its_own_material(make: Callable[[Path], Path], name: str, tmp_path: Path) -> None:
    shape, folder = written(make(tmp_path), name)
    assert len(shape.leaves) == 2
    assert FORMATS[name](folder) == [RED, BLUE]


@pytest.mark.parametrize("formats", [("urdf", "usd"), ("usd", "urdf"), ("mjcf", "usd"), ("usd", "mjcf")], ids=" then ".join)
def test_formats_in_one_folder_share_the_names_of_images(formats: tuple[str, ...], tmp_path: Path) -> None:
    _, folder = written(obj_with_images_of_one_name(tmp_path), *formats)
    files = {material: (folder / "meshes" / file).read_bytes() for material, file in mtl_images(folder / "meshes")}
    assert files == IMAGES
    shown = usd_images(folder / "out.usd")
    assert {name: (folder / file).read_bytes() for name, file in shown} == IMAGES
    assert len(list((folder / "meshes").glob("*.png"))) == len(IMAGES)
    if "mjcf" in formats:
        root = ET.parse(folder / "out.xml")
        textures = {each.get("name"): each.get("file", "") for each in root.iter("texture")}
        named = {each.get("name"): textures[each.get("texture")] for each in root.iter("material")}
        assert {name: (folder / "meshes" / file).read_bytes() for name, file in named.items()} == IMAGES


def mtl_images(folder: Path) -> list[tuple[str, str]]:
    """Each material in the MTL files of a folder, and the file of its image."""
    texts = [path.read_text() for path in sorted(folder.glob("*.mtl"))]
    return [found for text in texts for found in re.findall(r"newmtl (\S+).*?map_Kd (\S+)", text, re.DOTALL)]


def usd_images(path: Path) -> list[tuple[str, str]]:
    """Each material of a stage, and the file of its image."""
    stage = Usd.Stage.Open(str(path))
    images = [prim for prim in stage.Traverse() if prim.GetName() == "image"]
    return [(prim.GetParent().GetName(), UsdShade.Shader(prim).GetInput("file").Get().path) for prim in images]
