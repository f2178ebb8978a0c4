"""Folders of mesh files: which folders are one shape, and which files are no parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gltf_files import PARTS, box
from obj_files import TRIANGLE, obj, places_of_parts
from textured_files import encoded

import kinmo
from kinmo.core.shape import Shape
from kinmo.io.discover import discover
from kinmo.io.source_files import fingerprint

HEADER = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
POINTS = f"{HEADER}end_header\n0 0 0\n"
NO_FACES = f"{HEADER}element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"
VERTICES = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def meshes(folder: Path, ending: str = "obj") -> Path:
    """A folder with a body, a door and a knob."""
    folder.mkdir(exist_ok=True)
    for name, mesh in PARTS.items():
        mesh.export(folder / f"{name}.{ending}")
    return folder


def parts_of(shape: Shape) -> list[str]:
    return sorted(shape.parts[leaf].name for leaf in shape.leaves)


def layouts(root: Path) -> set[str]:
    return {found.layout for found in discover(root)}


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("cloud.ply", POINTS, "has no faces"),
        ("none.ply", NO_FACES, "has no faces"),
        ("empty.ply", "", "expected a PLY file with a header"),
        ("empty.stl", "", "expected an STL file with triangles: export it again"),
        ("solid.stl", "solid a\nfacet\n", "has no faces"),
        ("empty.obj", "", "no part has geometry: expected faces of three or more corners"),
        ("vertices.obj", VERTICES, "no part has geometry: expected faces of three or more corners"),
        ("garbage.obj", "f a b c\n", "expected numbers (found a)"),
    ],
)
def test_a_file_without_a_mesh_is_dropped_with_a_note(name: str, content: str, problem: str, tmp_path: Path) -> None:
    (meshes(tmp_path) / name).write_text(content)
    shape = kinmo.load(tmp_path)
    assert (shape.layout, parts_of(shape)) == ("mesh_folder", ["body", "door", "knob"])
    assert shape.repairs == (f"mesh file {name} ({problem}) ignored: 1",)
    assert shape.guesses["up"].endswith("(3 mesh files)")


def test_the_second_file_of_a_name_is_dropped_with_a_note(tmp_path: Path) -> None:
    box((1, 1, 1)).export(meshes(tmp_path) / "door.stl")
    shape = kinmo.load(tmp_path)
    assert parts_of(shape) == ["body", "door", "knob"]
    assert shape.repairs == ("mesh file door.stl (door.obj has the same name) ignored: 1",)


def test_a_broken_file_leaves_its_name_to_another(tmp_path: Path) -> None:
    meshes(tmp_path, "stl")
    (tmp_path / "door.obj").write_text(VERTICES)
    shape = kinmo.load(tmp_path)
    assert parts_of(shape) == ["body", "door", "knob"]
    assert [line for line in shape.repairs if "door" in line] == [
        "mesh file door.obj (no part has geometry: expected faces of three or more corners) ignored: 1"
    ]


def test_many_broken_files_are_counted(tmp_path: Path) -> None:
    meshes(tmp_path)
    for number in range(8):
        (tmp_path / f"{number}.obj").touch()
    repairs = kinmo.load(tmp_path).repairs
    assert len(repairs) == 6
    assert "further mesh files that cannot be read ignored: 3" in repairs


def test_a_folder_of_broken_meshes_is_an_error_that_names_one(tmp_path: Path) -> None:
    for name in ("a.obj", "b.obj"):
        (tmp_path / name).touch()
    with pytest.raises(kinmo.InputError, match=r"no mesh file can be read: mesh file a\.obj \(no part has geometry"):
        kinmo.load(tmp_path)


def test_as_many_scans_as_meshes_are_no_parts_of_one_shape(tmp_path: Path) -> None:
    meshes(tmp_path)
    for number in range(3):
        assert layouts(tmp_path) == {"mesh_folder"}
        (tmp_path / f"{number}.ply").write_text(POINTS)
    assert layouts(tmp_path) == {"obj"}


def test_objects_in_several_formats_are_no_parts_of_one_shape(tmp_path: Path) -> None:
    meshes(meshes(tmp_path), "stl")
    assert layouts(tmp_path) == {"obj", "stl"}


def test_an_obj_file_with_several_objects_of_one_name_is_no_part(tmp_path: Path) -> None:
    obj(meshes(tmp_path) / "more.obj", "o door", "o door")
    assert layouts(tmp_path) == {"obj"}


def test_an_obj_file_that_repeats_its_group_is_a_part(tmp_path: Path) -> None:
    obj(meshes(tmp_path) / "more.obj", "g drawer", "g drawer")
    assert parts_of(kinmo.load(tmp_path)) == ["body", "door", "knob", "more"]


def test_labels_follow_the_names_of_the_files_and_the_faces_in_each(tmp_path: Path) -> None:
    obj(tmp_path / "a.obj", "usemtl A", "usemtl B", "usemtl A", "usemtl B")
    (tmp_path / "b.obj").write_text(TRIANGLE.format(4))
    np.save(tmp_path / "faces.npy", [0, 0, 1, 1, 1])
    assert places_of_parts(kinmo.load(tmp_path, labels=tmp_path / "faces.npy")) == [{0, 1}, {2, 3, 4}]


def test_a_change_of_a_material_or_an_image_is_noticed(tmp_path: Path) -> None:
    for name, library in (("a", "mtllib own.mtl\nusemtl own\n"), ("b", "")):
        (tmp_path / f"{name}.obj").write_text(library + TRIANGLE.format(1))
    (tmp_path / "own.mtl").write_text("newmtl own\nKd 1 0 0\nmap_Kd own.png\n")
    (tmp_path / "own.png").write_bytes(encoded("PNG"))
    (found,) = discover(tmp_path)
    names = ("a.obj", "b.obj", "own.mtl", "own.png")
    assert [row[0] for row in fingerprint(found)] == [f"{tmp_path.name}/{name}" for name in names]
    for name in ("own.mtl", "own.png"):
        before = fingerprint(found)
        (tmp_path / name).write_bytes((tmp_path / name).read_bytes() + b"\n")
        assert fingerprint(found) != before
