"""The parts of OBJ files."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from datasets import box_obj
from hypothesis import given
from hypothesis import strategies as st
from obj_files import obj, places_of_parts

import kinmo
from kinmo.core.shape import Shape


def names(shape: Shape) -> list[tuple[str, str, int]]:
    """Name of the parent, name, and number of faces of each part below the root, sorted."""
    below = [(shape.parts[part.parent].name, part) for part in shape.parts if part.parent is not None]
    return sorted((above, part.name, 0 if part.mesh is None else len(part.mesh.faces)) for above, part in below)


@pytest.mark.parametrize("key", ["g", "usemtl"])
def test_a_repeated_group_or_material_continues_its_part(key: str, tmp_path: Path) -> None:
    path = obj(tmp_path / "a.obj", f"{key} door", f"{key} body", f"  {key}\tdoor", f"{key} knob  # small")
    assert names(kinmo.load(path)) == [("", "body", 1), ("", "door", 2), ("", "knob", 1)]


def test_objects_of_the_same_name_are_parts_of_their_own(tmp_path: Path) -> None:
    path = obj(tmp_path / "a.obj", "o door", "o body", "  o\tdoor", "o door  # third", "o knob")
    assert names(kinmo.load(path)) == [("", name, 1) for name in ("body", "door", "door", "door", "knob")]


def test_groups_of_objects_of_the_same_name_stay_apart(tmp_path: Path) -> None:
    shape = kinmo.load(obj(tmp_path / "a.obj", "o door\ng leaf", "g knob", "o door\ng leaf", "g knob", "g leaf"))
    assert names(shape) == [
        ("", "door", 0),
        ("", "door", 0),
        ("door", "knob", 1),
        ("door", "knob", 1),
        ("door", "leaf", 1),
        ("door", "leaf", 2),
    ]


def test_groups_are_below_the_objects_that_have_several(tmp_path: Path) -> None:
    shape = kinmo.load(obj(tmp_path / "a.obj", "o left\ng leaf", "g knob", "o right\ng leaf", "o body"))
    assert [row[:2] for row in names(shape)] == [
        ("", "body"),
        ("", "left"),
        ("", "right"),
        ("left", "knob"),
        ("left", "leaf"),
    ]


def test_materials_divide_nothing_where_groups_do(tmp_path: Path) -> None:
    shape = kinmo.load(obj(tmp_path / "a.obj", "g door\nusemtl wood", "usemtl steel", "g body\nusemtl wood"))
    assert names(shape) == [("", "body", 1), ("", "door", 2)]


@pytest.mark.parametrize("head", ["", "usemtl wood", "g", "g all", "o all", "g all\nusemtl wood", "o all\ng all\nusemtl wood"])
def test_one_group_of_one_material_is_one_mesh_of_loose_pieces(head: str, tmp_path: Path) -> None:
    assert len(kinmo.load(obj(tmp_path / "a.obj", head, "", "")).leaves) == 3


LINES = st.sampled_from(["", "o", "o door", "o body", "g", "g door", "g body knob", "usemtl wood", "usemtl steel", "usemtl"])


@given(st.lists(st.lists(LINES, max_size=3), min_size=2, max_size=6))
def test_every_face_is_in_one_part(heads: list[list[str]]) -> None:
    with TemporaryDirectory() as folder:
        shape = kinmo.load(obj(Path(folder) / "a.obj", *("\n".join(head) for head in heads)))
    corners = np.concatenate([mesh.vertices[mesh.faces].reshape(-1, 9) for mesh in shape.meshes()])
    assert len(np.unique(corners, axis=0)) == len(corners) == len(heads)


def test_faces_above_the_first_group_have_no_name(tmp_path: Path) -> None:
    shape = kinmo.load(obj(tmp_path / "a.obj", "# header", "g door", "g"))
    assert names(shape) == [("", "", 2), ("", "door", 1)]


def test_polygons_of_an_obj_file_stay_in_their_group(tmp_path: Path) -> None:
    text = "\n".join(["g all", box_obj((0, 0, 0), (1, 1, 1)).replace("o box\n", "")])
    second = "v 9 0 0\nv 9 1 0\nv 9 1 1\nv 9 0.5 2\nv 9 0 1\ng five\nf -5 -4 -3 -2 -1\nl 1 2\n"
    (tmp_path / "a.obj").write_text(text + second)
    shape = kinmo.load(tmp_path / "a.obj")
    assert {part.name: len(part.mesh.faces) for part in shape.parts if part.mesh} == {"all": 12, "five": 3}
    assert shape.repairs == ("materials box.mtl (missing) ignored: 1", "points and lines ignored: 1")


def test_faces_of_fewer_than_three_corners_are_said(tmp_path: Path) -> None:
    shape = kinmo.load(obj(tmp_path / "a.obj", "o door", "o body\nf 1 2\nf 1", "o knob"))
    assert shape.repairs == ("faces of fewer than three corners ignored: 2",)


HEADS = ["usemtl A", "usemtl B", "usemtl A", "usemtl B"]


@pytest.mark.parametrize(
    "heads",
    [HEADS, ["g A", "g B", "g A", "g B"], ["o C\ng A", "g B", "g A", "o D\ng A"]],
    ids=["materials", "groups", "groups of objects"],
)
def test_labels_are_in_the_order_of_the_file_where_groups_alternate(heads: list[str], tmp_path: Path) -> None:
    path = obj(tmp_path / "a.obj", *heads)
    np.save(tmp_path / "faces.npy", [0, 0, 1, 1])
    assert places_of_parts(kinmo.load(path, labels=tmp_path / "faces.npy")) == [{0, 1}, {2, 3}]


@given(st.lists(st.tuples(st.sampled_from(["", "o", "g A", "g B", "usemtl A", "usemtl B"]), st.integers(0, 2)), min_size=5))
def test_equal_labels_are_a_part_whatever_divides_the_faces(rows: list[tuple[str, int]]) -> None:
    labels = [3, *(label for _, label in rows[1:])]
    with TemporaryDirectory() as folder:
        path = obj(Path(folder) / "a.obj", *(head for head, _ in rows))
        np.save(Path(folder) / "faces.npy", labels)
        found = places_of_parts(kinmo.load(path, labels=Path(folder) / "faces.npy"))
    wanted = [{place for place, other in enumerate(labels) if other == label} for label in set(labels)]
    assert found == sorted(wanted, key=min)


def test_labelled_faces_keep_their_materials(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl A\nKd 1 0 0\nnewmtl B\nKd 0 0 1\n")
    path = obj(tmp_path / "a.obj", "mtllib a.mtl\nusemtl A", *HEADS[1:])
    np.save(tmp_path / "faces.npy", [0, 0, 0, 1])
    names = {}
    for mesh in kinmo.load(path, labels=tmp_path / "faces.npy").meshes():
        assert mesh.look is not None
        names |= {
            place: mesh.look.materials[number].name
            for place, number in zip(mesh.triangles[:, 0, 0].tolist(), mesh.look.material.tolist(), strict=True)
        }
    assert names == {0.0: "A", 1.0: "B", 2.0: "A", 3.0: "B"}
