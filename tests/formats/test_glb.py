"""Shapes in binary glTF files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from articulated import rotations
from kinmo.cli.app import app
from kinmo.errors import InputError
from kinmo.formats import Found, Layout, discover, read_found
from kinmo.formats.sources import content_digest, fingerprint
from kinmo.shape import Shape

Node = tuple[str, np.ndarray, tuple[float, float, float] | None, tuple["Node", ...]]
"""Name, where it is in its parent, the size of its box if it has one, and children."""


def node(name: str, *children: Node, at: np.ndarray | None = None, box: tuple[float, float, float] | None = None) -> Node:
    return name, np.eye(4) if at is None else at, box, children


def shifted(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def write(path: Path, *roots: Node) -> Path:
    scene = trimesh.Scene()

    def add(one: Node, parent: str) -> None:
        name, pose, box, children = one
        if box is None:
            scene.graph.update(frame_from=parent, frame_to=name, matrix=pose)
        else:
            mesh = trimesh.creation.box(box)
            scene.add_geometry(mesh, node_name=name, geom_name=f"{name} mesh", parent_node_name=parent, transform=pose)
        for child in children:
            add(child, name)

    for root in roots:
        add(root, "world")
    path.write_bytes(scene.export(file_type="glb"))
    return path


CABINET = node(
    "StorageFurniture",
    node("body", box=(1.0, 2.0, 0.5)),
    node(
        "door",
        node("panel", box=(1.0, 2.0, 0.05)),
        node("handle", box=(0.05, 0.3, 0.05), at=shifted(x=0.4, z=0.05)),
        at=shifted(z=0.3),
    ),
)


def read(path: Path) -> Shape:
    (found,) = discover(path)
    assert found.layout is Layout.GLB
    return read_found(found)


def test_the_nodes_of_a_scene_are_the_parts_of_a_shape(tmp_path: Path) -> None:
    shape = read(write(tmp_path / "cabinet 7.glb", node("Scene", CABINET)))
    assert (shape.id, shape.category, shape.mobility) == ("cabinet 7", "StorageFurniture", None)
    by_name = {part.name: part for part in shape.parts}
    assert by_name.keys() == {"StorageFurniture", "body", "door", "panel", "handle"}
    assert [shape.parts[place].name for place in (by_name["panel"].parent or 0, by_name["body"].parent or 0)] == [
        "door",
        "StorageFurniture",
    ]
    handle = by_name["handle"].mesh
    assert handle is not None
    np.testing.assert_allclose(handle.vertices.mean(axis=0), (0.4, 0.0, 0.35), atol=1e-6)
    np.testing.assert_allclose(np.ptp(handle.vertices, axis=0), (0.05, 0.3, 0.05), atol=1e-6)


def test_roots_side_by_side_are_siblings_of_an_unknown_category(tmp_path: Path) -> None:
    shape = read(write(tmp_path / "two.glb", node("lid", box=(1, 1, 1)), node("pot", box=(2, 2, 2), at=shifted(y=-2))))
    assert shape.category == "unknown"
    assert sorted(part.name for part in shape.parts if part.is_leaf) == ["lid", "pot"]


def test_a_node_with_a_mesh_and_children_has_the_mesh_as_a_child(tmp_path: Path) -> None:
    door = node("door", node("handle", box=(0.1, 0.1, 0.1), at=shifted(z=0.1)), box=(1.0, 2.0, 0.05))
    shape = read(write(tmp_path / "door.glb", node("frame", node("post", box=(0.1, 2.0, 0.1)), door)))
    (inner,) = (part for part in shape.parts if part.name == "door" and not part.is_leaf)
    leaves = {shape.parts[child].name: shape.parts[child].mesh for child in inner.children}
    assert leaves.keys() == {"door", "handle"}
    assert leaves["door"] is not None
    np.testing.assert_allclose(np.ptp(leaves["door"].vertices, axis=0), (1.0, 2.0, 0.05), atol=1e-6)


@settings(max_examples=25)
@given(rotations, st.tuples(*[st.floats(-2.0, 2.0)] * 3), st.floats(0.2, 3.0), st.booleans())
def test_surfaces_lie_where_transforms_have_them_and_face_outwards(
    tmp_path_factory: pytest.TempPathFactory, rotation: np.ndarray, shift: tuple[float, ...], scale: float, mirrors: bool
) -> None:
    inner = shifted(x=0.5)
    outer = np.eye(4)
    outer[:3, :3] = scale * rotation @ np.diag([-1.0 if mirrors else 1.0, 1.0, 1.0])
    outer[:3, 3] = shift
    piece = node("piece", box=(1.0, 2.0, 3.0), at=inner)
    path = tmp_path_factory.mktemp("glb") / "a.glb"
    shape = read(write(path, node("root", piece, node("other", box=(1.0, 1.0, 1.0)), at=outer)))
    (mesh,) = (part.mesh for part in shape.parts if part.name == "piece")
    assert mesh is not None
    whole = outer @ inner
    expected = trimesh.creation.box((1.0, 2.0, 3.0)).vertices @ whole[:3, :3].T + whole[:3, 3]
    apart = np.linalg.norm(mesh.vertices[:, None] - expected[None], axis=2)
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-4
    volume = trimesh.Trimesh(mesh.vertices, mesh.faces).volume
    assert volume == pytest.approx(6.0 * scale**3, rel=1e-3)


def test_files_are_found_beside_other_shapes_and_known_by_their_contents(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    first, copy = write(tmp_path / "deep" / "a.GLB", CABINET), write(tmp_path / "b.glb", CABINET)
    found = list(discover(tmp_path))
    assert [(each.path, each.id) for each in found] == [(copy, "b"), (first, "a")]
    assert [row[0] for row in fingerprint(found[0])] == ["b.glb"]
    renamed = Found(write(tmp_path / "deep" / "b.glb", CABINET), Layout.GLB, "b")
    assert content_digest(renamed) == content_digest(found[0])


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "expected a binary glTF file"),
        (b"solid", "expected a binary glTF file"),
        (b"glTF\x02\0\0\0", "expected a binary glTF file with meshes"),
    ],
)
def test_what_is_no_scene_is_told_in_one_line(tmp_path: Path, data: bytes, problem: str) -> None:
    path = tmp_path / "broken.glb"
    path.write_bytes(data)
    with pytest.raises(InputError, match=f"^{path}: {problem}"):
        read(path)


def test_a_file_that_is_cut_is_refused_wherever_it_ends(tmp_path: Path) -> None:
    whole = write(tmp_path / "whole.glb", CABINET).read_bytes()
    for length in range(12, len(whole) - 4, max(1, len(whole) // 40)):
        (tmp_path / "cut.glb").write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"cut\.glb"):
            read(tmp_path / "cut.glb")


def test_too_many_or_too_deep_nodes_are_refused(tmp_path: Path) -> None:
    many = node("root", *(node(f"piece {i}", box=(1.0, 1.0, 1.0), at=shifted(x=2.0 * i)) for i in range(1001)))
    with pytest.raises(InputError, match="more than 1000 parts"):
        read(write(tmp_path / "many.glb", many))
    deep = node("leaf", box=(1.0, 1.0, 1.0))
    for level in range(70):
        deep = node(f"level {level}", node(f"piece {level}", box=(1.0, 1.0, 1.0)), deep)
    with pytest.raises(InputError, match="nested deeper"):
        read(write(tmp_path / "deep.glb", deep))


def test_a_scan_still_needs_a_category_and_a_shape_in_a_file_none(tmp_path: Path) -> None:
    write(tmp_path / "cabinet.glb", CABINET)
    where = ["--workspace", str(tmp_path / "workspace"), "-o", str(tmp_path / "out")]
    planned = CliRunner().invoke(app, ["predict", str(tmp_path / "cabinet.glb"), *where, "--dry-run", "--json"])
    assert planned.exit_code == 0, planned.output
    assert "predict 1 shape" in json.dumps(json.loads(planned.stdout))
    (tmp_path / "scan.npz").write_bytes(b"")
    refused = CliRunner().invoke(app, ["predict", str(tmp_path / "scan.npz"), *where])
    assert refused.exit_code != 0
    assert "--category" in refused.output
