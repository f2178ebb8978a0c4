"""The reader of glTF files: hierarchies, primitives, and wrong values. `test_gltf_forms.py` has the other legal forms."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from articulated import rotations
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from kinmo.cli.app import app
from kinmo.core.errors import InputError
from kinmo.core.shape import Shape
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.readers import GLB
from kinmo.io.readers import scene as limits
from kinmo.io.source_files import content_digest, fingerprint

Node = tuple[str, np.ndarray, tuple[float, float, float] | None, tuple["Node", ...]]
"""Name, transform to the parent, size of the box if it has one, and children."""


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
    assert found.layout == GLB
    return found.read()


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


def test_several_roots_become_siblings_of_unknown_category(tmp_path: Path) -> None:
    shape = read(write(tmp_path / "two.glb", node("lid", box=(1, 1, 1)), node("pot", box=(2, 2, 2), at=shifted(y=-2))))
    assert shape.category == ""
    assert sorted(part.name for part in shape.parts if part.is_leaf) == ["lid", "pot"]


def test_the_mesh_of_a_node_with_children_becomes_a_child(tmp_path: Path) -> None:
    door = node("door", node("handle", box=(0.1, 0.1, 0.1), at=shifted(z=0.1)), box=(1.0, 2.0, 0.05))
    shape = read(write(tmp_path / "door.glb", node("frame", node("post", box=(0.1, 2.0, 0.1)), door)))
    (inner,) = (part for part in shape.parts if part.name == "door" and not part.is_leaf)
    leaves = {shape.parts[child].name: shape.parts[child].mesh for child in inner.children}
    assert leaves.keys() == {"door", "handle"}
    assert leaves["door"] is not None
    np.testing.assert_allclose(np.ptp(leaves["door"].vertices, axis=0), (1.0, 2.0, 0.05), atol=1e-6)


@settings(max_examples=25)
@given(rotations, st.tuples(*[st.floats(-2.0, 2.0)] * 3), st.floats(0.2, 3.0), st.booleans())
def test_transforms_place_surfaces_that_face_outwards(
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


def test_files_are_found_and_compared_by_their_contents(tmp_path: Path) -> None:
    (tmp_path / "deep" / "c").mkdir(parents=True)
    first, copy = write(tmp_path / "deep" / "a.GLB", CABINET), write(tmp_path / "b.glb", CABINET)
    found = list(discover(tmp_path))
    assert [(each.path, each.id) for each in found] == [(copy, "b"), (first, "a")]
    assert [row[0] for row in fingerprint(found[0])] == ["b.glb"]
    renamed = ShapeSource(write(tmp_path / "deep" / "b.glb", CABINET), GLB, "b")
    assert content_digest(renamed) == content_digest(found[0])
    other = ShapeSource(write(tmp_path / "deep" / "c" / "b.glb", node("lid", box=(1.0, 1.0, 1.0))), GLB, "b")
    assert content_digest(other) != content_digest(found[0])


@pytest.mark.parametrize("data", [b"solid", b"glTF\x02\0\0\0"])
def test_a_file_that_is_not_binary_gltf_is_an_error(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "broken.glb"
    path.write_bytes(data)
    with pytest.raises(InputError, match=f"^{path}: expected a binary glTF file: export it again$"):
        read(path)


QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
DROPPED = "(dropped)"


def raw(path: Path, *, order: np.ndarray | None = None, mode: int | None = None, **changes: object) -> Path:
    """Write a file of one square with some fields changed or dropped: `nodes__0__name="a"` changes nodes[0].name."""
    order = np.array([0, 1, 2, 0, 2, 3], "<u2") if order is None else order
    primitive = {"attributes": {"POSITION": 0}, "indices": 1} | ({} if mode is None else {"mode": mode})
    codes = {"uint8": 5121, "uint16": 5123, "uint32": 5125}
    value: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "sheet", "mesh": 0}, {"name": "other", "mesh": 0, "translation": [0.0, 0.0, 1.0]}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": codes[order.dtype.name], "count": len(order), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": order.nbytes},
        ],
        "buffers": [{"byteLength": 48 + order.nbytes}],
    }
    if "nodes" in changes and "scenes" not in changes:
        value["scenes"] = [{"nodes": [0]}]
    for field, changed in changes.items():
        *above, last = (int(key) if key.isdecimal() else key for key in field.split("__"))
        place: Any = value
        for key in above:
            place = place[key]
        if changed is DROPPED:
            del place[last]
        else:
            place[last] = changed
    text = json.dumps(value).encode()
    text += b" " * (-len(text) % 4)
    binary = QUAD.tobytes() + order.tobytes()
    binary += b"\0" * (-len(binary) % 4)
    chunks = [(b"JSON", text), (b"BIN\0", binary)]
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    return path


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"accessors__1__count": 7}, "accessors[1].count: expected as many numbers as the buffer holds"),
        ({"accessors__0__count": 10**9}, "accessors[0].count: expected 1 to "),
        ({"accessors__0__count": 3}, "meshes[0].primitives[0].indices: expected indices below 3, got 3"),
        ({"accessors__0__componentType": 5124}, "accessors[0].componentType: expected int8"),
        ({"accessors__1__componentType": 5126}, "accessors[1].componentType: expected uint8"),
        ({"accessors__0__bufferView": DROPPED}, "accessors[0]: has no data"),
        ({"accessors__0__sparse": {"count": 9}}, "accessors[0].sparse.indices: expected an object"),
        ({"accessors__0__bufferView": 2}, "accessors[0].bufferView: expected one of the 2 bufferViews, got 2"),
        ({"buffers__0__uri": "other.bin"}, "a.glb: buffers[0].uri: other.bin is missing: put it there"),
        ({"buffers__0__uri": "data:,abc"}, "buffers[0].uri: expected data as base64"),
        ({"buffers__0__uri": "https://example.org/a.bin"}, "download it, or export one GLB"),
        ({"bufferViews__0__byteOffset": -4}, "bufferViews[0].byteOffset: expected 0 or more"),
        ({"nodes__0__mesh": 1}, "nodes[0].mesh: expected one of the 1 meshes, got 1"),
        ({"nodes__0__children": [0]}, "nodes[0]: expected a tree of nodes, found a cycle"),
        ({"nodes__0__children": [1]}, "scenes[0].nodes[1]: node 1 is in two places"),
        ({"nodes__0__matrix": [1.0] * 15}, "nodes[0].matrix: expected 16 numbers"),
        ({"nodes__0__scale": [1.0, float("nan"), 1.0]}, "nodes[0].scale[1]: expected a finite number"),
        ({"nodes__0__rotation": [0.0] * 4}, "nodes[0].rotation: expected a quaternion"),
        ({"meshes__0__primitives__0__mode": 7}, "meshes[0].primitives[0].mode: expected 0 to 6"),
        ({"extensionsRequired": ["EXT_odd_geometry"]}, "EXT_odd_geometry is not supported: export the file without it"),
        ({"scene": 3}, "scene: expected one of the 1 scenes"),
        ({"nodes": {"node_0": {}}}, "a.glb: expected version 2 of glTF, got 1: export it as glTF 2.0"),
        ({"meshes__0__primitives__0__mode": 1}, "no part has geometry (points and lines ignored: 1)"),
        ({"nodes": [{"name": "empty"}], "scenes__0__nodes": [0]}, "no part has geometry"),
    ],
    ids=str,
)
def test_a_wrong_value_is_an_error_with_its_field(tmp_path: Path, changes: dict[str, object], field: str) -> None:
    with pytest.raises(InputError, match=re.escape(field)):
        read(raw(tmp_path / "a.glb", **changes))


@pytest.mark.parametrize("number", ["<u1", "<u2", "<u4"])
@pytest.mark.parametrize(("mode", "order"), [(4, [0, 1, 2, 0, 2, 3]), (5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])])
def test_lists_strips_and_fans_give_the_same_surface(tmp_path: Path, mode: int, order: list[int], number: str) -> None:
    shape = read(raw(tmp_path / "a.glb", order=np.array(order, number), mode=mode))
    mesh, _ = shape.meshes()
    normals = np.cross(*(mesh.vertices[mesh.faces[:, i]] - mesh.vertices[mesh.faces[:, 0]] for i in (1, 2)))
    np.testing.assert_allclose(normals, [[0.0, 0.0, 1.0]] * 2)


def test_unused_vertices_are_dropped(tmp_path: Path) -> None:
    mesh, _ = read(raw(tmp_path / "a.glb", order=np.array([0, 2, 3], "<u2"), mode=4)).meshes()
    assert len(mesh.vertices) == 3
    whole, _ = read(raw(tmp_path / "b.glb", order=np.array([0, 1, 2, 0, 2, 3], "<u2"), mode=4)).meshes()
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], whole.vertices[whole.faces[1:]])


def test_extensions_for_materials_are_ignored(tmp_path: Path) -> None:
    shape = read(raw(tmp_path / "a.glb", extensionsRequired=["KHR_materials_unlit", "KHR_texture_transform"]))
    assert [part.name for part in shape.parts] == ["", "sheet", "other"]


def test_a_mesh_with_several_materials_is_one_part(tmp_path: Path) -> None:
    piece = {"attributes": {"POSITION": 0}, "indices": 1}
    path = raw(tmp_path / "a.glb", meshes=[{"primitives": [{**piece, "material": 0}, {**piece, "material": 1}]}])
    _, part, _ = read(path).parts
    assert part.name == "sheet"
    assert part.mesh is not None
    assert len(part.mesh.faces) == 4


def test_cameras_lights_and_empty_nodes_are_not_parts(tmp_path: Path) -> None:
    nodes = [{"name": "Cabinet", "children": [1, 2]}, {"name": "door", "mesh": 0}, {"name": "body", "mesh": 0}]
    nodes += [{"name": "Camera", "camera": 0}, {"name": "Light"}]
    shape = read(raw(tmp_path / "a.glb", nodes=nodes, scenes=[{"nodes": [3, 0, 4]}]))
    assert shape.category == "", "no category has this name"
    assert [part.name for part in shape.parts] == ["Cabinet", "door", "body"], "equal parts are in the order of the file"
    assert shape.repairs == ()
    assert shape.partnet_id is None


def test_bones_are_not_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = [{"name": "Cabinet", "children": [1, 2, *range(3, 1203)]}, {"name": "door", "mesh": 0}, {"name": "body", "mesh": 0}]
    path = raw(tmp_path / "a.glb", nodes=[*nodes, *({"name": f"bone {i}"} for i in range(1200))], scenes=[{"nodes": [0]}])
    assert [part.name for part in read(path).parts] == ["Cabinet", "door", "body"]
    monkeypatch.setattr(limits, "MAX_NODES", 1000)
    with pytest.raises(InputError, match="more than 1000 nodes"):
        read(path)


@pytest.mark.parametrize(("root", "category"), [("refrigerator", "Refrigerator"), ("door_set", "Door"), ("../../Safe", "Safe")])
def test_the_name_of_the_root_gives_the_category(root: str, category: str, tmp_path: Path) -> None:
    nodes = [{"name": root, "children": [1, 2]}, {"name": "door", "mesh": 0}, {"name": "body", "mesh": 0}]
    assert read(raw(tmp_path / "a.glb", nodes=nodes)).category == category


def test_nodes_without_a_name_stay_without_one(tmp_path: Path) -> None:
    nodes = [{"children": [1, 2]}, {"mesh": 0, "name": "a"}, {"mesh": 0, "name": "a"}]
    shape = read(raw(tmp_path / "a.glb", nodes=nodes))
    assert (shape.category, [part.name for part in shape.parts]) == ("", ["", "a", "a"])
    bare = read(raw(tmp_path / "b.glb", nodes=nodes, scenes=DROPPED, scene=DROPPED))
    assert [part.name for part in bare.parts] == ["", "a", "a"], "without scenes all nodes count"


def test_a_small_file_cannot_expand_to_a_huge_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "MAX_CORNERS", 200)
    nodes = [{"children": list(range(1, 41))}, *({"mesh": 0} for _ in range(40))]
    with pytest.raises(InputError, match="more than 200 corners"):
        read(raw(tmp_path / "a.glb", nodes=nodes))
    piece = {"attributes": {"POSITION": 0}, "indices": 1}
    with pytest.raises(InputError, match="more than 200 corners"):
        read(raw(tmp_path / "b.glb", meshes=[{"primitives": [piece] * 30}]))


@pytest.mark.parametrize("name", ["   .glb", "...glb"])
def test_a_file_without_a_name_is_not_a_shape(tmp_path: Path, name: str) -> None:
    raw(tmp_path / name)
    assert list(discover(tmp_path)) == []
    with pytest.raises(InputError, match=r"expected a folder of shapes, or a shape as \.glb, \.gltf, "):
        list(discover(tmp_path / name))


def test_a_cut_file_is_an_error(tmp_path: Path) -> None:
    whole = write(tmp_path / "whole.glb", CABINET).read_bytes()
    for length in range(12, len(whole) - 4, max(1, len(whole) // 40)):
        (tmp_path / "cut.glb").write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"cut\.glb"):
            read(tmp_path / "cut.glb")


def test_too_deep_nodes_are_an_error(tmp_path: Path) -> None:
    deep = node("leaf", box=(1.0, 1.0, 1.0))
    for level in range(70):
        deep = node(f"level {level}", node(f"piece {level}", box=(1.0, 1.0, 1.0)), deep)
    with pytest.raises(InputError, match="nested deeper"):
        read(write(tmp_path / "deep.glb", deep))


def test_predicting_a_file_needs_no_category_but_a_scan_does(tmp_path: Path) -> None:
    write(tmp_path / "cabinet.glb", CABINET)
    where = ["--workspace", str(tmp_path / "workspace"), "-o", str(tmp_path / "out")]
    planned = CliRunner().invoke(app, ["predict", str(tmp_path / "cabinet.glb"), *where, "--dry-run"])
    assert planned.exit_code == 0, planned.output
    (tmp_path / "scan.npz").write_bytes(b"")
    failed = CliRunner().invoke(app, ["predict", str(tmp_path / "scan.npz"), *where])
    assert failed.exit_code != 0
    assert "--category" in failed.output
