"""Looks of textured files survive in every format that has them: the same images, and the same place of each corner in them."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pybullet
import pytest
import trimesh
from glb_contents import GlbContents
from PIL import Image
from scipy.spatial import cKDTree
from textured_files import (
    FIXTURES,
    PARTS,
    Textured,
    embedded_png,
    encoded,
    obj_with_mtl,
    triangles,
    two_materials,
    vertex_colors,
)

import kinmo
from kinmo.core.frames import Y_UP_TO_Z_UP
from kinmo.core.joint import Joint, JointKind
from kinmo.core.look import Image as Picture
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.io.readers import read_partnet_mobility
from kinmo.io.result_folder import write_result
from kinmo.io.writers import WRITERS, ExportedObject, ExportOptions

Fixture = Callable[[Path], Textured]


def exported(shape: Shape, folder: Path, *formats: str) -> ExportedObject:
    """The shape with a door on a hinge, written in some formats."""
    leaf = {shape.parts[i].name: i for i in shape.leaves}
    hinge = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 1.0]), -1.5, 0.0)
    mobility = Mobility((Body(0, "base", (leaf["body"],)), Body(1, "door link", (leaf["door"],), 0, hinge)))
    found = ExportedObject(shape, mobility, ExportOptions("out", collision="none", formats=formats))
    folder.mkdir(parents=True, exist_ok=True)
    for name in formats:
        WRITERS[name](found, folder)
    return found


def corners_of(scene: trimesh.Scene) -> np.ndarray:
    """Places and texture coordinates [N, 5] of all corners, as trimesh reads them, with v up."""
    meshes: list[Any] = scene.dump()
    return np.concatenate([np.concatenate([m.triangles, m.visual.uv[m.faces]], axis=2).reshape(-1, 5) for m in meshes])


def expected_corners(made: Textured) -> np.ndarray:
    assert made.uvs is not None
    return np.concatenate([np.concatenate([triangles(part), made.uvs[part]], axis=2).reshape(-1, 5) for part in PARTS])


def assert_same_rows(found: np.ndarray, expected: np.ndarray) -> None:
    assert found.shape == expected.shape
    for one, other in ((found, expected), (expected, found)):
        assert cKDTree(one).query(other)[0].max() < 2e-6


def meshes_in(folder: Path) -> Iterator[trimesh.Scene]:
    """The OBJ files of a folder, in the frame of the shape's file."""
    frame = np.eye(4)
    frame[:3, :3] = Y_UP_TO_Z_UP.T
    for file in sorted(folder.glob("*.obj")):
        scene: Any = trimesh.load_scene(file, process=False)
        scene.apply_transform(frame)
        yield scene


@pytest.fixture(params=FIXTURES, ids=lambda make: make.__name__)
def made(request: pytest.FixtureRequest, tmp_path: Path) -> Textured:
    """A textured file."""
    result: Textured = request.param(tmp_path)
    return result


def test_glb_keeps_images_and_coordinates(made: Textured, tmp_path: Path) -> None:
    exported(kinmo.load(made.path), tmp_path / "out", "glb")
    data = (tmp_path / "out" / "out.glb").read_bytes()
    contents = GlbContents(data)
    assert {contents.image(i) for i in range(len(contents.document.get("images", [])))} == made.images
    assert len(contents.document.get("images", [])) == len(made.images)
    surfaces = [material["pbrMetallicRoughness"] for material in contents.document.get("materials", [])]
    factors = {tuple(surface.get("baseColorFactor", ())) for surface in surfaces}
    assert factors - {()} == made.base_colors
    if made.uvs is not None:
        assert_same_rows(corners_of(trimesh.load_scene(io.BytesIO(data), file_type="glb")), expected_corners(made))


def test_obj_files_of_a_urdf_keep_images_and_coordinates(made: Textured, tmp_path: Path) -> None:
    exported(kinmo.load(made.path), tmp_path / "out", "urdf")
    folder = tmp_path / "out" / "meshes"
    assert {path.read_bytes() for path in folder.iterdir() if path.suffix in (".png", ".jpg")} == made.images
    scenes = list(meshes_in(folder))
    if made.uvs is not None:
        assert_same_rows(np.concatenate([corners_of(scene) for scene in scenes]), expected_corners(made))
    shown = [mesh.visual.material for scene in scenes for mesh in scene.geometry.values() if hasattr(mesh.visual, "material")]
    if made.base_colors:
        assert {tuple(material.diffuse) for material in shown} == {
            tuple(np.round(255 * np.array(color)).astype(int)) for color in made.base_colors
        }


def test_a_urdf_comes_back_with_its_look(made: Textured, tmp_path: Path) -> None:
    exported(kinmo.load(made.path), tmp_path / "out", "urdf")
    found = kinmo.load(tmp_path / "out" / "out.urdf")
    assert found.repairs == ()
    looks = [mesh.look for mesh in found.meshes()]
    assert {m.image.data for look in looks if look for m in look.materials if m.image is not None} == made.images
    if made.uvs is not None:
        rows = [(m.triangles @ Y_UP_TO_Z_UP, m.look.uvs) for m in found.meshes() if m.look is not None]
        assert_same_rows(np.concatenate([np.concatenate(row, axis=2).reshape(-1, 5) for row in rows]), expected_corners(made))


def test_an_mjcf_comes_back_with_its_look(made: Textured, tmp_path: Path) -> None:
    exported(kinmo.load(made.path), tmp_path / "out", "mjcf")
    found = kinmo.load(tmp_path / "out" / "out.xml")
    assert found.repairs == ()
    materials = [material for mesh in found.meshes() if mesh.look for material in mesh.look.materials]
    shown = {pixels_of(material.image.data) for material in materials if material.image is not None}
    assert shown == {pixels_of(data) for data in made.images}
    if made.uvs is not None:
        rows = [(m.triangles @ Y_UP_TO_Z_UP, m.look.uvs) for m in found.meshes() if m.look is not None]
        assert_same_rows(np.concatenate([np.concatenate(row, axis=2).reshape(-1, 5) for row in rows]), expected_corners(made))
    if made.colors is None:
        assert {material.base_color for material in materials} == made.base_colors


def pixels_of(data: bytes) -> bytes:
    return Image.open(io.BytesIO(data)).convert("RGB").tobytes()


def test_partnet_mobility_comes_back_with_its_look(made: Textured, tmp_path: Path) -> None:
    shape = kinmo.load(made.path)
    exported(shape, tmp_path / "7", "partnet_mobility")
    found = read_partnet_mobility(tmp_path / "7")
    looks = [mesh.look for mesh in found.meshes()]
    assert {m.image.data for look in looks if look for m in look.materials if m.image is not None} == made.images
    assert {m.base_color for look in looks if look for m in look.materials} == made.base_colors
    if made.uvs is not None:
        rows = [np.concatenate([m.triangles, m.look.uvs], axis=2).reshape(-1, 5) for m in found.meshes() if m.look is not None]
        assert_same_rows(np.concatenate(rows), expected_corners(made))


def test_mujoco_loads_pictures_with_the_same_pixels(made: Textured, tmp_path: Path) -> None:
    exported(kinmo.load(made.path), tmp_path / "out", "mjcf")
    model: Any = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "out.xml"))
    expected = {np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).tobytes() for data in made.images}
    assert model.ntex == len(expected)
    sizes = zip(model.tex_adr, model.tex_height, model.tex_width, model.tex_nchannel, strict=True)
    found = [model.tex_data[a : a + h * w * c].reshape(h, w, c) for a, h, w, c in sizes]
    assert {pixels[..., :3].tobytes() for pixels in found} <= expected | {
        np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))[::-1].tobytes() for data in made.images
    }
    assert (model.mesh_texcoordnum > 0).all() or made.uvs is None


def test_pybullet_shows_the_texture_the_right_way_up(tmp_path: Path) -> None:
    made = embedded_png(tmp_path)
    shape = kinmo.load(made.path)
    # the front of the door has a picture with a red upper half and a blue lower half
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:32, :, 0], picture[32:, :, 2] = 255, 255
    file = io.BytesIO()
    Image.fromarray(picture).save(file, "PNG")
    shape = with_picture(shape, file.getvalue())
    exported(shape, tmp_path / "out", "urdf")
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.loadURDF(str(tmp_path / "out" / "out.urdf"), useFixedBase=True, physicsClientId=client)
        eye, target = (-4.0, -0.5, 1.0), (0.0, -0.5, 1.0)  # z is up, and the front at -x
        view = pybullet.computeViewMatrix(eye, target, (0, 0, 1))
        lens = pybullet.computeProjectionMatrixFOV(30, 1, 0.1, 10)
        seen = pybullet.getCameraImage(64, 64, view, lens, renderer=pybullet.ER_TINY_RENDERER, physicsClientId=client)[2]
    finally:
        pybullet.disconnect(client)
    pixels = np.reshape(seen, (64, 64, 4)).astype(int)
    above, below = pixels[22, 32], pixels[42, 32]
    assert above[0] > 80 > above[2] and below[2] > 80 > below[0]


def with_picture(shape: Shape, data: bytes) -> Shape:
    """The shape with another picture, spread over x and y of each part."""
    parts = list(shape.parts)
    for leaf in shape.leaves:
        mesh = shape.leaf_mesh(leaf)
        assert mesh.look is not None
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        uvs = ((mesh.triangles - low) / (high - low))[..., :2]
        material = replace(mesh.look.materials[0], image=Picture(data, "image/png", "halves"))
        parts[leaf] = replace(parts[leaf], mesh=replace(mesh, look=replace(mesh.look, materials=(material,), uvs=uvs)))
    return replace(shape, parts=tuple(parts))


def test_vertex_colors_survive_in_glb_and_obj(tmp_path: Path) -> None:
    made = vertex_colors(tmp_path)
    assert made.colors is not None
    found = exported(kinmo.load(made.path), tmp_path / "out", "urdf", "mjcf", "glb")
    rows = [np.concatenate([triangles(part), made.colors[part][..., :3] / 255], axis=2).reshape(-1, 6) for part in PARTS]
    for scenes in (
        [trimesh.load_scene(tmp_path / "out" / "out.glb")],
        list(meshes_in(tmp_path / "out" / "meshes")),
    ):
        meshes: list[Any] = [mesh for scene in scenes for mesh in scene.dump()]
        seen = [np.concatenate([m.triangles, m.visual.vertex_colors[m.faces][..., :3] / 255], axis=2) for m in meshes]
        assert_same_rows(np.concatenate(seen).reshape(-1, 6), np.concatenate(rows))
    assert [note.split(":")[0] for note in found.notes] == ["urdf", "mjcf"]
    model: Any = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "out.xml"))
    means = []
    for part in PARTS:
        areas = np.linalg.norm(np.cross(*np.moveaxis(np.diff(triangles(part), axis=1), 1, 0)), axis=1)
        means.append(np.average(made.colors[part][..., 0].mean(axis=1) / 255, weights=areas))
    np.testing.assert_allclose(sorted(model.mat_rgba[:, 0]), sorted(means), atol=1e-6)


def test_one_vertex_color_for_each_part_loses_nothing(tmp_path: Path) -> None:
    shape = kinmo.load(vertex_colors(tmp_path).path)
    parts = list(shape.parts)
    for place, leaf in enumerate(shape.leaves, 1):
        mesh = shape.leaf_mesh(leaf)
        assert mesh.look is not None and mesh.look.colors is not None
        colors = np.full_like(mesh.look.colors, place / 4)
        parts[leaf] = replace(parts[leaf], mesh=replace(mesh, look=replace(mesh.look, colors=colors)))
    assert exported(replace(shape, parts=tuple(parts)), tmp_path / "out", "urdf", "mjcf").notes == []


def test_notes_are_in_joints_json(tmp_path: Path) -> None:
    shape = kinmo.load(vertex_colors(tmp_path).path)
    mobility = exported(shape, tmp_path / "first").mobility
    estimates = tuple((JointEstimate(body.joint, MotionType.FIXED, 0.5),) for body in mobility.bodies)
    estimate = ShapeEstimate(shape.id, shape.category, mobility, estimates, (), "kinmo")
    options = ExportOptions("out", collision="none")
    written = write_result(shape, estimate, tmp_path / "out", ("joints_json", "mjcf"), options)
    document = json.loads((tmp_path / "out" / "joints.json").read_text())
    assert document["export"]["notes"] == list(written.notes) and len(written.notes) == 1
    assert list(written.main) == ["joints_json", "mjcf"]


def test_a_part_with_two_materials_becomes_two_visuals_with_its_name(tmp_path: Path) -> None:
    exported(kinmo.load(two_materials(tmp_path).path), tmp_path / "out", "urdf")
    names = sorted(path.stem for path in (tmp_path / "out" / "meshes").glob("*.obj"))
    assert names == ["body_wood", "body_wood_2", "door_wood", "door_wood_2"]


def test_a_broken_picture_is_one_note_and_fails_nothing(tmp_path: Path) -> None:
    made = obj_with_mtl(tmp_path)
    (tmp_path / "wood 0.png").write_bytes(b"RIFF\0\0\0\0WEBPVP8 broken")
    shape = kinmo.load(made.path)
    found = exported(shape, tmp_path / "out", "urdf", "mjcf", "glb")
    assert len(found.notes) == 3 and all("cannot be converted to PNG" in note for note in found.notes)
    assert not list((tmp_path / "out" / "meshes").glob("*.png"))


def test_a_missing_picture_is_one_repair(tmp_path: Path) -> None:
    made = obj_with_mtl(tmp_path)
    (tmp_path / "wood 0.png").unlink()
    shape = kinmo.load(made.path)
    assert shape.repairs == ("image wood 0.png (missing) ignored: 1",)
    exported(shape, tmp_path / "out", "urdf", "glb")


def test_a_picture_outside_of_the_folder_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    (tmp_path / "secret.png").write_bytes(encoded("PNG"))
    made = obj_with_mtl(tmp_path / "inner")
    (tmp_path / "inner" / "a.mtl").write_text("newmtl wood 0\nmap_Kd ../secret.png\n")
    shape = kinmo.load(made.path)
    assert any("leads out of the folder" in repair for repair in shape.repairs)
    assert all(mesh.look is None or all(m.image is None for m in mesh.look.materials) for mesh in shape.meshes())
