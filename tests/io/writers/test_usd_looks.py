"""Looks in USD files: materials, images, texture coordinates, colours and normals."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from articulated import box_mesh, shape_of_boxes
from PIL import Image as Pillow
from pxr import Usd, UsdGeom, UsdShade, UsdUtils, UsdValidation

from kinmo.core.look import Image, Look, Material
from kinmo.core.mobility import Body
from kinmo.core.shape import Mesh
from kinmo.io.writers import ExportedObject, ExportOptions
from kinmo.io.writers.usd_writer import write_usd

FACES = 12


def png() -> bytes:
    file = io.BytesIO()
    Pillow.new("RGB", (2, 2), (200, 100, 50)).save(file, "PNG")
    return file.getvalue()


WOOD = Material("wood", (1.0, 0.5, 1.0, 1.0), Image(png(), "image/png", "planks.png"), metallic=0.0, roughness=0.4)
GLASS = Material("glass", (0.1, 0.2, 0.9, 0.3), metallic=0.2, roughness=0.1, alpha_mode="BLEND")


@pytest.fixture
def written(tmp_path: Path) -> Callable[[Look | None], tuple[Usd.Stage, UsdGeom.Mesh, list[str]]]:
    """Writes a box with a look. Returns the stage, the mesh of the box and the notes."""
    kept: list[Usd.Stage] = []  # prims live as long as their stage

    def write(look: Look | None) -> tuple[Usd.Stage, UsdGeom.Mesh, list[str]]:
        shape = shape_of_boxes([((0, 0, 0), (1, 1, 1))], (Body(0, "body", (1,)),), up=(0.0, 0.0, 1.0))
        mesh = box_mesh((0, 0, 0), (1, 1, 1))
        part = replace(shape.parts[1], mesh=Mesh(mesh.vertices, mesh.faces, look))
        shape = replace(shape, parts=(shape.parts[0], part))
        exported = ExportedObject(shape, shape.mobility, ExportOptions(collision="none"))
        folder = tmp_path / str(len(kept))
        folder.mkdir()
        stage = Usd.Stage.Open(str(write_usd(exported, folder)))
        kept.append(stage)
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        assert [error.GetMessage() for error in UsdValidation.ValidationContext(validators).Validate(stage)] == []
        (found,) = (UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
        return stage, found, exported.notes

    return write


def surface_of(prim: Usd.Prim) -> UsdShade.Shader:
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    return material.ComputeSurfaceSource()[0]


def test_texture_coordinates_and_images_are_kept(written, tmp_path):
    uvs = np.random.default_rng(0).random((FACES, 3, 2))
    stage, mesh, notes = written(Look((WOOD,), np.zeros(FACES, np.int32), uvs=uvs))
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    assert st.GetInterpolation() == UsdGeom.Tokens.faceVarying
    assert np.array(st.ComputeFlattened()).reshape(FACES, 3, 2) == pytest.approx(uvs, abs=1e-6)
    image = UsdShade.Shader(surface_of(mesh.GetPrim()).GetInput("diffuseColor").GetConnectedSource()[0].GetPrim())
    assert Path(image.GetInput("file").Get().resolvedPath).read_bytes() == WOOD.image.data
    assert tuple(image.GetInput("scale").Get()) == WOOD.base_color
    assert notes == [] and not UsdUtils.ComputeAllDependencies(stage.GetRootLayer().identifier)[2]
    assert [path.name for path in (tmp_path / "0" / "meshes").iterdir()] == ["planks.png"]


def test_every_face_has_its_material(written):
    material = np.array([0] * 4 + [1] * 6 + [-1] * 2, np.int32)
    _, mesh, _ = written(Look((WOOD, GLASS), material))
    found = np.full(FACES, -1)
    for subset in UsdGeom.Subset.GetGeomSubsets(mesh, UsdGeom.Tokens.face, "materialBind"):
        name = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0].GetPrim().GetName()
        found[list(subset.GetIndicesAttr().Get())] = ["wood", "glass"].index(name)
    assert np.array_equal(found, material)
    colors = np.array(mesh.GetDisplayColorAttr().Get())
    assert colors[4:10] == pytest.approx(np.tile(GLASS.base_color[:3], (6, 1)))


def test_a_material_without_an_image_has_its_colour_and_opacity(written):
    _, mesh, _ = written(Look((GLASS,), np.zeros(FACES, np.int32)))
    surface = surface_of(mesh.GetPrim())
    values = {name: surface.GetInput(name).Get() for name in ("diffuseColor", "opacity", "metallic", "roughness")}
    assert tuple(values.pop("diffuseColor")) == pytest.approx(GLASS.base_color[:3])
    assert values == pytest.approx({"opacity": 0.3, "metallic": 0.2, "roughness": 0.1})
    assert np.array(mesh.GetDisplayOpacityAttr().Get()) == pytest.approx([0.3])


def test_colours_of_vertices_are_kept_and_multiply_the_material(written):
    colors = np.random.default_rng(0).random((FACES, 3, 4)).astype(np.float32)
    _, mesh, _ = written(Look((GLASS,), np.zeros(FACES, np.int32), colors=colors))
    shown = mesh.GetDisplayColorPrimvar()
    assert shown.GetInterpolation() == UsdGeom.Tokens.faceVarying
    assert np.array(shown.Get()).reshape(FACES, 3, 3) == pytest.approx(colors[..., :3] * GLASS.base_color[:3], abs=1e-6)
    reader = UsdShade.Shader(surface_of(mesh.GetPrim()).GetInput("diffuseColor").GetConnectedSource()[0].GetPrim())
    assert reader.GetInput("varname").Get() == "displayColor"
    _, _, notes = written(Look((WOOD,), np.zeros(FACES, np.int32), np.zeros((FACES, 3, 2)), colors))
    assert notes == ["usd: the colours of vertices are left out where a material has an image"]


def test_normals_are_kept_or_are_those_of_the_faces(written):
    normals = np.tile(np.array([0.0, 0.6, 0.8], np.float32), (FACES, 3, 1))
    _, mesh, _ = written(Look((), np.full(FACES, -1, np.int32), normals=normals))
    assert mesh.GetNormalsInterpolation() == UsdGeom.Tokens.faceVarying
    assert np.array(mesh.GetNormalsAttr().Get()).reshape(FACES, 3, 3) == pytest.approx(normals)
    _, mesh, _ = written(None)
    assert mesh.GetNormalsInterpolation() == UsdGeom.Tokens.uniform
    points = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)]
    outwards = points.mean(axis=1) - 0.5
    assert (np.einsum("fx,fx->f", np.array(mesh.GetNormalsAttr().Get()), outwards) > 0.4).all()
