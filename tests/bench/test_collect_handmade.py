"""Collecting hand-made objects of public repositories."""

from __future__ import annotations

import re
import sys
from dataclasses import replace

import numpy as np
import pytest

import collect_handmade
from collect_handmade import Entry, Source
from kinmo.core.errors import InputError
from kinmo.core.frames import AXIS_VECTORS
from kinmo.core.joint import JointKind
from kinmo.io.readers import read_partnet_mobility

SOURCES = collect_handmade.read_sources()
BOX = '<geom type="box" size="1 1 1"/>'
ASSETS = '<mujocoinclude><default><default class="board"><geom type="box"/></default></default></mujocoinclude>'
BODY = f"""<mujocoinclude><body childclass="board">
    <geom size="1 1 1"/><geom name="back_wall" size="1 1 1"/><geom size="5 5 5" group="4"/>
    <body name="door" pos="1 0 0">
        <joint name="hinge" range="0 1.5" axis="0 0 1" pos="0 0.5 0"/><geom size="1 1 1"/>
        <body name="bolt"><joint name="slide" type="slide" axis="0 0 2" range="0 0.1"/>{BOX}</body>
        <body name="sign"><joint name="hidden" type="slide"/><geom size="1 1 1"/></body>
    </body></body></mujocoinclude>"""
ENTRY = Entry("body.xml", "Safe", "-y", assets="assets.xml", held={"hidden": "It cannot be seen."})
SOURCE = Source("maker/safe", "0" * 40, "CC0", ["models"], {"safe": ENTRY}, "models", "radian")


@pytest.fixture
def clones(tmp_path):
    """A folder with an unpacked archive of `SOURCE`."""
    folder = tmp_path / "clones" / "safe" / "models"
    folder.mkdir(parents=True)
    (folder / "assets.xml").write_text(ASSETS)
    (folder / "body.xml").write_text(BODY)
    return tmp_path / "clones"


def run(clones, out, source=SOURCE):
    return collect_handmade.collect("some", source, clones, out)


@pytest.mark.parametrize("name", SOURCES)
def test_the_list_of_objects_is_complete(name):
    source = SOURCES[name]
    assert re.fullmatch(r"[\w-]+/[\w-]+", source.repository) and re.fullmatch("[0-9a-f]{40}", source.commit)
    assert source.licence and source.objects and source.paths
    for entry in source.objects.values():
        assert entry.front in AXIS_VECTORS and entry.up in AXIS_VECTORS and entry.category
        assert all(why.endswith(".") for why in entry.held.values())
        place = f"{source.folder}/{entry.file}".lstrip("/")
        assert any(place == path or place.startswith(f"{path}/") for path in source.paths)


def test_an_object_is_written_with_its_licence(clones, tmp_path):
    rows = run(clones, tmp_path / "out")
    assert rows == [("maker/safe", "unknown", "CC0", 1, 2)]
    shape = read_partnet_mobility(tmp_path / "out" / "some-safe")
    door, bolt = (body.joint for _, body in shape.mobility.movable())
    assert (door.kind, bolt.kind) == (JointKind.REVOLUTE, JointKind.PRISMATIC)
    assert (door.lower, door.upper) == pytest.approx((0.0, 1.5)), "angles are radians"
    np.testing.assert_allclose(door.direction, (0, 1, 0), atol=1e-12)
    np.testing.assert_allclose(door.pivot, (1, 0, -0.5), atol=1e-12)
    assert '"licence": "CC0"' in (tmp_path / "out" / "some-safe" / "meta.json").read_text()


def test_bodies_and_pieces_have_the_names_of_the_maker(clones, tmp_path):
    run(clones, tmp_path / "out")
    shape = read_partnet_mobility(tmp_path / "out" / "some-safe")
    names = [[shape.parts[leaf].name for leaf in body.leaves] for body in shape.mobility.bodies]
    assert names == [["body", "back_wall"], ["door", "sign"], ["bolt"]]


def test_a_part_of_a_file_is_taken(clones, tmp_path):
    entry = replace(ENTRY, link="door", without=("bolt",), held={})
    assert run(clones, tmp_path / "out", replace(SOURCE, objects={"door": entry}))[0][3:] == (1, 1)
    shape = read_partnet_mobility(tmp_path / "out" / "some-door")
    assert [body.name for body in shape.mobility.bodies] == ["door", "sign"]


@pytest.mark.parametrize("change", [{"link": "lid"}, {"without": ("lid",)}, {"held": {"lid": "It is not there."}}])
def test_a_name_that_a_file_lacks_is_an_error(clones, change):
    entry = replace(ENTRY, **change)
    with pytest.raises(InputError, match="has no lid"):
        collect_handmade.make_object(clones / "safe", SOURCE, entry, "", lambda problem: None)


def test_the_clones_are_not_changed(clones, tmp_path):
    before = sorted(clones.rglob("*"))
    run(clones, tmp_path / "out")
    assert sorted(clones.rglob("*")) == before


def test_what_is_missing_is_reported_and_the_rest_is_done(clones, tmp_path, capsys, monkeypatch):
    broken = replace(SOURCE, objects={"lost": replace(ENTRY, file="lost.xml"), "safe": ENTRY})
    absent = replace(SOURCE, repository="maker/absent")
    monkeypatch.setattr(collect_handmade, "read_sources", lambda: {"a": absent, "b": broken})
    monkeypatch.setattr(sys, "argv", ["collect_handmade.py", str(clones), str(tmp_path / "out")])
    assert collect_handmade.main() == 1
    told = capsys.readouterr()
    lines = told.err.splitlines()
    assert lines[0].startswith("maker/absent: not in") and lines[0].endswith("1 object left out")
    assert "b-lost: kinmo_wrapper.xml: lost.xml is missing: put it there, or correct the path" in lines
    assert told.out.splitlines()[-1].startswith("1 of 3 objects")
    assert [folder.name for folder in (tmp_path / "out").iterdir()] == ["b-safe"]
