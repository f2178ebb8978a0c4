"""Hostile and broken files: the readers read them or raise InputError, without crashing or hanging."""

from __future__ import annotations

import copy
import json
import math
import os
import random
from pathlib import Path

import numpy as np
import pytest
from datasets import BOXES, LEAVES, META, RESULT, box_obj, mobility, tree, write_dsg_net, write_partnet_mobility

from kinmo.core.errors import InputError
from kinmo.io.readers import read_dsg_net, read_partnet_mobility

VALUES = [
    None, True, False, 0, -1, 1, 2, 7, 99, 10**6, 10**30, 10**400, 0.5, -0.0, 1e-320, 1e308, math.nan, math.inf, -math.inf,
    "", "7", "hinge", "slider", "screw", "junk", "original-1", "../original-1", "/etc/passwd", "a\0b", "\ud800", "é" * 500,
    "a\nb", [], {}, [[]], [1], [0, 0, 0], [0, 1, 0], [math.nan, 0, 0], {"id": 1}, [{"id": 0}], [{"id": 5}], [[[[[]]]]],
]  # fmt: skip


def paths_in(value, path=()):
    """Paths to all values in nested lists and objects."""
    yield path
    if isinstance(value, dict):
        for key, item in value.items():
            yield from paths_in(item, (*path, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from paths_in(item, (*path, index))


def mutate(value, rng):
    """A copy with one value replaced, removed, doubled, or swapped."""
    root = {"root": copy.deepcopy(value)}
    path = rng.choice([path for path in paths_in(root) if path])
    holder = root
    for step in path[:-1]:
        holder = holder[step]
    action = rng.choice(["replace", "replace", "remove", "double", "swap"])
    if action == "remove":
        del holder[path[-1]]
    elif action == "double" and isinstance(holder, list):
        holder.append(copy.deepcopy(holder[path[-1]]))
    elif action == "swap":
        other = root
        for step in rng.choice(list(paths_in(root["root"]))):
            other = (other if other is not root else root["root"])[step]
        holder[path[-1]] = copy.deepcopy(other if other is not root else root["root"])
    else:
        holder[path[-1]] = copy.deepcopy(rng.choice(VALUES))
    return root.get("root")


def check(shape):
    """Check what holds for every shape."""
    assert sorted(shape.leaves) == [index for index, part in enumerate(shape.parts) if part.mesh is not None]
    assert all(part.parent is None or part.parent < index for index, part in enumerate(shape.parts))
    assert math.isfinite(shape.diagonal) and shape.diagonal > 0
    assert len({part.id for part in shape.parts}) == len(shape.parts)
    "".join([shape.id, shape.category, *shape.repairs, *(part.name for part in shape.parts)]).encode("utf-8")
    if shape.mobility is not None:
        assert sorted(leaf for body in shape.mobility.bodies for leaf in body.leaves) == list(shape.leaves)
        for _, body in shape.mobility.movable():
            assert body.parent is not None
            assert math.isclose(sum(body.joint.direction**2), 1.0)
            assert not body.joint.is_limited or body.joint.lower <= 0.0 <= body.joint.upper


def try_to_read(reader, path):
    """True if a reader reads the file. It may raise InputError, with a message of one line."""
    try:
        check(reader(path))
    except InputError as error:
        assert "\n" not in str(error)
        str(error).encode("utf-8")
        return False
    return True


@pytest.mark.parametrize("name", ["mobility_v2.json", "result.json", "meta.json"])
@pytest.mark.parametrize("seed", range(4))
def test_mutated_annotations_are_read_or_an_error(tmp_path, name, seed):
    rng = random.Random(f"{name} {seed}")
    folder = write_partnet_mobility(tmp_path / "4711")
    original = {"mobility_v2.json": mobility(), "result.json": RESULT, "meta.json": META}[name]
    readable = 0
    for _ in range(100):
        value = original
        for _ in range(rng.choice([1, 1, 1, 2, 5])):
            value = mutate(value, rng)
        (folder / name).write_text(json.dumps(value), encoding="utf-8")
        readable += try_to_read(read_partnet_mobility, folder)
    assert 0 < readable < 100, "some mutations are harmless, some are not"


@pytest.mark.parametrize("seed", range(2))
def test_mutated_trees_are_read_or_an_error(tmp_path, seed):
    rng = random.Random(seed)
    path = write_dsg_net(tmp_path)
    original = tree(RESULT[0])
    original["children"][2]["geo"] = [0.1 * i for i in range(12)]
    for _ in range(150):
        path.write_text(json.dumps(mutate(original, rng)), encoding="utf-8")
        try_to_read(read_dsg_net, path)


@pytest.mark.parametrize("name", ["mobility_v2.json", "result.json", "meta.json", "textured_objs/original-6.obj"])
def test_cut_and_garbled_files_are_read_or_an_error(tmp_path, name):
    rng = random.Random(name)
    folder = write_partnet_mobility(tmp_path / "4711")
    whole = (folder / name).read_bytes()
    for _ in range(60):
        data = bytearray(whole[: rng.randrange(len(whole) + 1)])
        for _ in range(rng.choice([0, 1, 5])):
            if data:
                data[rng.randrange(len(data))] = rng.randrange(256)
        (folder / name).write_bytes(data)
        is_read = try_to_read(read_partnet_mobility, folder)
        assert is_read or not name.endswith(".obj"), "a broken mesh is no reason to refuse the object"


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "empty"),
        (b"[" * 100_000, "nested too deeply"),
        (b'[{"id":0,"children":' * 5000, "json"),
        (b"\xff\xfe", "UTF-8"),
        (b"\0\0\0\0", "JSON"),
        (b"[" + b"9" * 10_000 + b"]", "json"),
        (b'"text"', "list"),
        (b"7", "list"),
        (b"[7]", "object"),
        (b"{}", "list"),
    ],
)
@pytest.mark.parametrize("name", ["mobility_v2.json", "result.json"])
def test_files_of_the_wrong_kind_are_an_error_with_their_name(tmp_path, name, content, expected):
    folder = write_partnet_mobility(tmp_path / "4711")
    (folder / name).write_bytes(content)
    with pytest.raises(InputError, match=expected) as caught:
        read_partnet_mobility(folder)
    assert name in str(caught.value)


def nested(depth):
    node = {"id": 10_000, "name": "end", "objs": ["original-1"]}
    for level in range(depth):
        node = {"id": level + 100, "name": "level", "children": [node]}
    return node


def test_hierarchies_are_read_up_to_a_depth_of_64(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    for depth, fits in ((60, True), (65, False), (300, False)):
        (folder / "result.json").write_text(json.dumps([nested(depth)]))
        (folder / "mobility_v2.json").write_text(json.dumps([mobility()[0] | {"parts": [{"id": 10_000}]}]))
        assert try_to_read(read_partnet_mobility, folder) == fits


def test_a_hundred_thousand_parts_are_an_error(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    children = ",".join(f'{{"id":{i},"name":"p","objs":["original-1"]}}' for i in range(1, 100_000))
    (folder / "result.json").write_text('[{"id":0,"name":"root","children":[' + children + "]}]")
    with pytest.raises(InputError, match="more than"):
        read_partnet_mobility(folder)


POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"


def spoil(path, kind):
    """Replace a file by something that cannot be read."""
    content = path.read_bytes()
    path.unlink()
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "pointer":
        path.write_bytes(POINTER)
    elif kind == "loop":
        path.symlink_to(path.name)
    elif kind == "dangling":
        path.symlink_to("nothing")
    elif kind == "unreadable":
        path.write_bytes(content)
        path.chmod(0)
        if os.access(path, os.R_OK):
            pytest.skip("this user may read everything")
    elif kind == "huge":
        with path.open("wb") as file:
            file.truncate(1 << 40)


KINDS = ["pipe", "folder", "pointer", "loop", "dangling", "missing", "unreadable", "huge"]


@pytest.mark.parametrize("name", ["mobility_v2.json", "result.json", "meta.json"])
@pytest.mark.parametrize("kind", KINDS)
def test_annotations_that_cannot_be_read_are_an_error_without_waiting(tmp_path, name, kind):
    folder = write_partnet_mobility(tmp_path / "4711")
    if name == "meta.json" and kind == "missing":
        pytest.skip("the root part names the category")
    spoil(folder / name, kind)
    with pytest.raises(InputError, match="git lfs pull" if kind == "pointer" else name):
        read_partnet_mobility(folder)


@pytest.mark.parametrize("kind", KINDS)
def test_a_mesh_that_cannot_be_read_is_skipped_with_a_note(tmp_path, kind):
    folder = write_partnet_mobility(tmp_path / "4711")
    spoil(folder / "textured_objs" / "original-5.obj", kind)
    shape = read_partnet_mobility(folder)
    check(shape)
    assert [part.id for part in shape.parts] == [0, 1, 2, 3, 4, 5, 7]
    (note,) = shape.repairs
    assert note.startswith("part 6 (handle): textured_objs/original-5.obj skipped: ")
    assert ("git lfs pull" in note) == (kind == "pointer")


def test_links_to_files_are_followed_wherever_they_lead(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    (tmp_path / "store").mkdir()
    for name in ("mobility_v2.json", "result.json", "meta.json", "textured_objs/original-6.obj"):
        kept = tmp_path / "store" / Path(name).name
        (folder / name).rename(kept)
        (folder / name).symlink_to(kept)
    shape = read_partnet_mobility(folder)
    assert (len(shape.leaves), shape.repairs) == (5, ())


@pytest.mark.parametrize("name", ["textured_objs", "obj folder"])
def test_links_to_mesh_folders_are_followed(tmp_path, name):
    if name == "textured_objs":
        folder = write_partnet_mobility(tmp_path / "data" / "4711")
        (folder / name).rename(tmp_path / "moved")
        (folder / name).symlink_to(tmp_path / "moved")
        reader = read_partnet_mobility
    else:
        folder = write_dsg_net(tmp_path / "data")
        (tmp_path / "data" / "storagefurniture_obj").rename(tmp_path / "moved")
        (tmp_path / "data" / "storagefurniture_obj").symlink_to(tmp_path / "moved")
        reader = read_dsg_net
    assert try_to_read(reader, folder)


@pytest.mark.parametrize("scale", [1e-30, 1e-3, 1e11])
def test_tiny_and_huge_objects_are_read(tmp_path, scale):
    bodies = mobility()
    for body in bodies[1:]:
        body["jointData"]["axis"]["origin"] = [x * scale for x in body["jointData"]["axis"]["origin"]]
    folder = write_partnet_mobility(tmp_path / "4711", bodies)
    for name, (low, high) in BOXES.items():
        text = box_obj([x * scale for x in low], [x * scale for x in high])
        (folder / "textured_objs" / f"{name}.obj").write_text(text)
    assert try_to_read(read_partnet_mobility, folder)


def test_equal_points_take_no_time(tmp_path):
    """Half a million points at two places: a search for neighbours among them would take minutes."""
    path = write_dsg_net(tmp_path, geometry="geo")
    file = tmp_path / "storagefurniture_geo" / "4711.npz"
    parts = np.zeros((8, 60_000, 3))
    parts[:, 0] = 1.0
    np.savez_compressed(file, parts=parts)
    assert file.stat().st_size < 20_000
    with pytest.raises(InputError, match="no part has geometry"):
        read_dsg_net(path)


def test_points_far_away_are_an_error(tmp_path):
    node = {"id": 0, "label": "table", "geo": [0.0, 0.0, 0.0, 1e13, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]}
    (tmp_path / "a.json").write_text(json.dumps(node))
    with pytest.raises(InputError, match=r"finite coordinates of at most 1e\+12, got 1e\+13"):
        read_dsg_net(tmp_path / "a.json")


def test_an_object_without_extent_is_an_error(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    for names in LEAVES.values():
        for name in names:
            (folder / "textured_objs" / f"{name}.obj").write_text("v 1 1 1\nf 1 1 1\n")
    with pytest.raises(InputError, match="no part has geometry"):
        read_partnet_mobility(folder)
