"""The search for shapes in a folder, and the state of their files."""

from __future__ import annotations

import os
import shutil
import socket
from pathlib import Path

import pytest
from datasets import write_dsg_net, write_json, write_partnet, write_partnet_mobility
from predicted_cabinet import write_cabinet_glb

from kinmo.core.errors import InputError
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.readers import DSG_NET, PARTNET, PARTNET_MOBILITY
from kinmo.io.source_files import content_digest, fingerprint


def found_in(root, **options):
    return {(found.layout, found.id) for found in discover(root, **options)}


def test_formats_are_recognised_by_content_at_any_depth(tmp_path):
    write_partnet_mobility(tmp_path / "sapien" / "dataset" / "40147")
    write_partnet(tmp_path / "partnet" / "data_v0" / "822")
    write_partnet(tmp_path / "partnet" / "merged" / "9", file="result_after_merging.json")
    write_dsg_net(tmp_path / "generated" / "a", "15")
    write_json(tmp_path / "loose" / "chair.json", {"label": "chair", "id": 0, "box": [0.0] * 12, "geo": [0.0] * 12})
    write_json(tmp_path / "notes" / "other.json", {"label": "not a tree"})
    write_json(tmp_path / "notes" / "result.json", {"accuracy": 0.5})
    assert found_in(tmp_path) == {
        ("partnet_mobility", "40147"),
        ("partnet", "822"),
        ("partnet", "9"),
        ("dsg_net", "storagefurniture-15"),
        ("dsg_net", "chair"),
    }


def test_a_shape_has_the_same_id_when_found_and_when_read(tmp_path):
    write_partnet_mobility(tmp_path / "a b" / "40147")
    write_partnet(tmp_path / "c" / "odd name")
    write_dsg_net(tmp_path / "d", "15")
    for found in discover(tmp_path):
        shape = found.read()
        assert (shape.id, shape.layout) == (found.id, found.layout)


def test_the_folder_of_a_single_shape_can_be_given(tmp_path):
    folder = write_partnet_mobility(tmp_path / "40147")
    assert found_in(folder) == {("partnet_mobility", "40147")}
    assert found_in(write_dsg_net(tmp_path / "d", "x")) == {("dsg_net", "x")}


def test_an_incomplete_shape_is_found_and_reported_when_read(tmp_path):
    write_json(tmp_path / "1" / "mobility_v2.json", [])
    write_json(tmp_path / "2" / "result.json", [{"id": 0, "name": "chair", "children": []}])
    assert found_in(tmp_path) == {("partnet_mobility", "1"), ("partnet", "2")}
    for found in discover(tmp_path):
        with pytest.raises(InputError):
            found.read()


def test_shapes_come_in_the_order_of_their_paths(tmp_path):
    for name in ("b", "a", "c"):
        write_partnet(tmp_path / name)
    assert [found.id for found in discover(tmp_path)] == ["a", "b", "c"]


def test_hidden_and_excluded_folders_are_skipped(tmp_path):
    write_partnet(tmp_path / ".unfinished")
    write_partnet(tmp_path / "workspace" / "pseudo" / "1")
    write_partnet(tmp_path / "2")
    assert found_in(tmp_path, skip=(tmp_path / "workspace",)) == {("partnet", "2")}


def test_exports_beside_a_result_are_no_shapes(tmp_path):
    file = tmp_path / "cabinet" / "cabinet.glb"
    file.parent.mkdir()
    write_cabinet_glb(file)
    assert [found.path for found in discover(tmp_path)] == [file]
    write_json(file.with_name("joints.json"), {})
    assert list(discover(tmp_path)) == []
    assert [found.path for found in discover(file)] == [file]


def test_link_cycles_pipes_and_sockets_do_no_harm(tmp_path):
    write_partnet(tmp_path / "data" / "1")
    (tmp_path / "data" / "again").symlink_to(tmp_path)
    (tmp_path / "data" / "self").symlink_to("self")
    (tmp_path / "data" / "nowhere").symlink_to("missing")
    os.mkfifo(tmp_path / "data" / "pipe.json")
    (tmp_path / "x_hier").mkdir()
    os.mkfifo(tmp_path / "x_hier" / "1.json")
    server = socket.socket(socket.AF_UNIX)
    here = Path.cwd()
    os.chdir(tmp_path)
    try:
        server.bind("s.json")
    finally:
        os.chdir(here)
        server.close()
    found = list(discover(tmp_path))
    assert [(one.layout, one.id) for one in found] == [(PARTNET, "1"), (DSG_NET, "x-1")]
    with pytest.raises(InputError, match="not a regular file"):
        found[1].read()


def test_links_to_folders_outside_are_followed_once(tmp_path):
    write_partnet(tmp_path / "elsewhere" / "1")
    (tmp_path / "elsewhere" / "back").symlink_to(tmp_path)
    (tmp_path / "root").mkdir()
    write_partnet(tmp_path / "root" / "2")
    for name in ("link", "same"):
        (tmp_path / "root" / name).symlink_to(tmp_path / "elsewhere")
    found = [one.path.relative_to(tmp_path).as_posix() for one in discover(tmp_path / "root")]
    assert found == ["root/2", "root/link/1"]
    assert found_in(tmp_path / "root" / "link" / "1") == {("partnet", "1")}


def test_links_to_files_outside_are_followed(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "root" / "chair_hier").mkdir(parents=True)
    for name in ("chair.glb", "7.json", "notes.json", "readme.txt"):
        (tmp_path / "elsewhere" / name).write_text("{}")
    for name in ("chair.glb", "chair_hier/7.json", "notes.json", "readme.txt", "missing.glb"):
        (tmp_path / "root" / name).symlink_to(tmp_path / "elsewhere" / Path(name).name)
    assert found_in(tmp_path / "root") == {("glb", "chair"), ("dsg_net", "chair-7")}


def test_links_to_what_is_found_anyway_are_skipped(tmp_path):
    (tmp_path / ".blobs").mkdir()
    (tmp_path / ".blobs" / "4d7a").write_text("{}")
    (tmp_path / "store").mkdir()
    for name in ("store/chair.glb", "store/9f2c"):
        (tmp_path / name).write_text("{}")
    for link, target in (("one.glb", ".blobs/4d7a"), ("two.glb", "store/9f2c"), ("three.glb", "store/chair.glb")):
        (tmp_path / link).symlink_to(target)
    assert found_in(tmp_path) == {("glb", "one"), ("glb", "two"), ("glb", "chair")}


def test_a_folder_that_must_not_be_read_is_reported_by_its_own_path(tmp_path, monkeypatch):
    write_partnet(tmp_path / "a" / "door")
    (tmp_path / "locked").mkdir()
    allowed = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "locked" and allowed(path, mode))
    notes = []
    assert [found.id for found in discover(tmp_path, report=notes.append)] == ["door"]
    assert list(map(str, notes)) == [f"{tmp_path / 'locked'}: cannot be listed: allow reading it (chmod u+rx)"]


@pytest.mark.parametrize(
    "name", ["a.glb", "a.gltf", "a.obj", "a.ply", "a.stl", "a.dae", "a.3mf", "a.usdc", "a.json", "x_hier/a.json"]
)
def test_a_git_lfs_pointer_is_named_with_its_remedy(tmp_path, name):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n")
    with pytest.raises(InputError, match="a Git LFS pointer, not the file itself: run `git lfs pull`"):
        next(discover(path)).read()


def test_deeply_nested_folders_are_reported(tmp_path):
    folder = tmp_path
    for _ in range(80):
        folder = folder / "d"
    folder.mkdir(parents=True)
    reported = []
    assert not list(discover(tmp_path, report=reported.append))
    assert "deeper" in str(reported[0])


@pytest.mark.parametrize("name", ["missing", "file"])
def test_a_missing_root_or_a_plain_file_is_an_error(tmp_path, name):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=name):
        list(discover(tmp_path / name))


def test_a_change_of_any_file_changes_fingerprint_and_digest(tmp_path):
    one = ShapeSource(write_partnet_mobility(tmp_path / "a" / "1"), PARTNET_MOBILITY, "1")
    other = ShapeSource(tmp_path / "b" / "1", PARTNET_MOBILITY, "1")
    shutil.copytree(one.path, other.path)
    assert content_digest(one) == content_digest(other)
    before = fingerprint(other)
    for name in ("mobility_v2.json", "result.json", "meta.json", "textured_objs/original-3.obj"):
        path = other.path / name
        text = path.read_text()
        path.write_text(text + " ")
        assert content_digest(one) != content_digest(other)
        assert fingerprint(other) != before
        path.write_text(text)
    (other.path / "textured_objs" / "original-3.obj").unlink()
    assert content_digest(one) != content_digest(other)


def test_a_change_of_geometry_changes_fingerprint_and_digest(tmp_path):
    for geometry, file in (("obj", "storagefurniture_obj/4711/7.obj"), ("geo", "storagefurniture_geo/4711.npz")):
        root = tmp_path / geometry
        found = ShapeSource(write_dsg_net(root, geometry=geometry), DSG_NET, "x")
        before = fingerprint(found), content_digest(found)
        (root / file).write_bytes((root / file).read_bytes() + b"\n")
        assert fingerprint(found) != before[0]
        assert content_digest(found) != before[1]
