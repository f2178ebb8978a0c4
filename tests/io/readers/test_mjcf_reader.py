"""The reader of MJCF files. All expected numbers are worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from datasets import box_obj

import kinmo
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.io.discover import discover
from kinmo.io.readers.mjcf_reader import read_mjcf, read_mjcf_robot
from kinmo.io.readers.robot_meshes import refuse
from kinmo.io.source_files import fingerprint

CABINET = """<?xml version="1.0"?>
<!-- a cabinet -->
<mujoco model="cabinet">
  <compiler angle="degree" meshdir="parts"/>
  <default>
    <geom type="box"/>
    <default class="hidden"><geom group="3"/></default>
    <default class="door"><joint range="0 90"/><default class="lid"><joint axis="0 1 0"/></default></default>
  </default>
  <asset><mesh name="knob" file="knob.obj" scale="0.1 0.1 0.1"/></asset>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="plane" size="1 1 0.1"/>
    <body name="frame" pos="0 0 1">
      <geom size="0.5 0.4 1"/>
      <geom class="hidden" type="sphere" size="9"/>
      <body name="door" pos="0.5 -0.4 0" euler="0 0 90" childclass="door">
        <joint name="swing" pos="0 0.2 0"/>
        <geom size="0.1 0.2 0.3" pos="0 0 0.5"/>
        <body name="knob"><geom type="mesh" mesh="knob" pos="1 0 0"/></body>
      </body>
      <body name="drawer">
        <joint name="slide" type="slide" axis="0 -2 0" range="0 0.3" ref="0.1"/>
        <geom type="capsule" fromto="0 0 0 0 3 0" size="0.25"/>
      </body>
      <body name="lid"><joint class="lid" limited="false"/><geom type="cylinder" size="0.2 0.1"/></body>
    </body>
  </worldbody>
</mujoco>
"""


def write(folder: Path, text: str = CABINET) -> Path:
    """An MJCF file with the mesh that it names: a unit cube."""
    (folder / "parts").mkdir(parents=True, exist_ok=True)
    (folder / "parts" / "knob.obj").write_text(box_obj((0, 0, 0), (1, 1, 1)))
    (folder / "model.xml").write_text(text)
    return folder / "model.xml"


def bounds(shape: kinmo.Shape, name: str) -> list[list[float]]:
    (mesh,) = (part.mesh for part in shape.parts if part.name == name and part.mesh is not None)
    return [np.round(corner(mesh.vertices, axis=0), 6).tolist() for corner in (np.min, np.max)]


def body(shape: kinmo.Shape, name: str):
    return next(body for body in shape.mobility.bodies if body.name == name)


def test_bodies_become_parts_at_their_places(tmp_path: Path) -> None:
    shape = kinmo.load(write(tmp_path / "cupboard"))
    assert (shape.id, shape.layout, shape.up, shape.metres_per_unit) == ("cupboard", "mjcf", (0.0, 0.0, 1.0), 1.0)
    assert sorted(part.name for part in shape.parts) == ["cabinet", "door", "drawer", "frame", "knob", "lid"]
    assert bounds(shape, "frame") == [[-0.5, -0.4, 0.0], [0.5, 0.4, 2.0]]
    # the door is turned by 90 degrees about z: its x is the world's y, its y is the world's -x
    assert bounds(shape, "door") == [[0.3, -0.5, 1.2], [0.7, -0.3, 1.8]]
    # a cube of side 0.1 at x = 1 of the door
    assert bounds(shape, "knob") == [[0.4, 0.6, 1.0], [0.5, 0.7, 1.1]]
    low, high = np.array(bounds(shape, "drawer"))
    np.testing.assert_allclose([low[1], high[1], high[2] - low[2]], [-0.25, 3.25, 0.5], atol=1e-3)
    assert shape.repairs == ("geoms of type plane ignored: 1",)


def test_joints_are_the_annotation(tmp_path: Path) -> None:
    shape = read_mjcf(write(tmp_path))
    assert [body.name for body in shape.mobility.bodies] == ["frame", "door", "drawer", "lid"]
    door, drawer, lid = (body(shape, name).joint for name in ("door", "drawer", "lid"))
    assert [shape.parts[leaf].name for leaf in sorted(body(shape, "door").leaves)] == ["door", "knob"]
    assert (door.kind, drawer.kind, lid.kind) == (JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.REVOLUTE)
    np.testing.assert_allclose(door.direction, [0, 0, 1])
    np.testing.assert_allclose(door.pivot[:2], [0.3, -0.4], atol=1e-12)
    assert (door.lower, door.upper) == (0.0, math.pi / 2)
    np.testing.assert_allclose(drawer.direction, [0, -1, 0])
    np.testing.assert_allclose([drawer.lower, drawer.upper], [-0.1, 0.2])
    np.testing.assert_allclose(lid.direction, [0, 1, 0], err_msg="from the default class")
    assert not lid.is_limited


def pose_of(tmp_path: Path, attributes: str, compiler: str = "") -> np.ndarray:
    """Place where a body with an orientation puts the point (1, 2, 3)."""
    text = f"""<mujoco>{compiler}<worldbody><body pos="10 0 0" {attributes}><geom type="mesh" mesh="m"/></body></worldbody>
        <asset><mesh name="m" vertex="1 2 3 2 2 3 1 3 3 1 2 4" face="0 1 2 0 1 3"/></asset></mujoco>"""
    (tmp_path / "a.xml").write_text(text)
    return np.round(read_mjcf(tmp_path / "a.xml").parts[1].mesh.vertices[0] - [10.0, 0.0, 0.0], 9)


@pytest.mark.parametrize(
    ("attributes", "compiler", "expected"),
    [
        ("", "", (1, 2, 3)),
        ('quat="1 1 0 0"', "", (1, -3, 2)),
        ('axisangle="0 0 2 90"', "", (-2, 1, 3)),
        ('axisangle="0 0 2 1.5707963267948966"', '<compiler angle="radian"/>', (-2, 1, 3)),
        ('euler="90 0 0"', "", (1, -3, 2)),
        ('euler="90 90 0"', "", (3, 1, 2)),
        ('euler="90 90 0"', '<compiler eulerseq="XYZ"/>', (2, -3, -1)),
        ('xyaxes="0 1 0 -1 0 0"', "", (-2, 1, 3)),
        ('zaxis="0 0 -5"', "", (1, -2, -3)),
        ('zaxis="1 0 0"', "", (3, 2, -1)),
    ],
)
def test_all_orientations_are_read(tmp_path: Path, attributes: str, compiler: str, expected: tuple[float, ...]) -> None:
    np.testing.assert_allclose(pose_of(tmp_path, attributes, compiler), expected, atol=1e-9)


def read(tmp_path: Path, bodies: str, before: str = "") -> kinmo.Shape:
    (tmp_path / "a.xml").write_text(f"<mujoco>{before}<worldbody>{bodies}</worldbody></mujoco>")
    return read_mjcf(tmp_path / "a.xml")


BASE = '<geom type="box" size="1 1 1"/>'


def test_a_hinge_and_a_slide_about_one_axis_are_a_screw(tmp_path: Path) -> None:
    joints = '<joint type="slide" axis="0 0 1" range="-1 2"/><joint axis="0 0 1"/>'
    shape = read(tmp_path, f'{BASE}<body name="cap" pos="0 0 2">{joints}<geom size="0.5"/></body>')
    joint = body(shape, "cap").joint
    assert (joint.kind, joint.lower, joint.upper) == (JointKind.SCREW, -1.0, 2.0)


@pytest.mark.parametrize("joint", ['<joint name="j" type="ball"/>', '<freejoint name="j"/>', '<joint name="j" type="free"/>'])
def test_ball_and_free_joints_are_ignored_with_a_note(tmp_path: Path, joint: str) -> None:
    door = '<body name="door"><joint/><geom size="0.1"/></body>'
    shape = read(tmp_path, f'{BASE}<body name="arm">{joint}<geom size="0.5"/></body>{door}')
    assert body(shape, "arm").joint is None and body(shape, "door").joint is not None
    kind = "ball" if "ball" in joint else "free"
    assert shape.repairs == (f"joint j: no hinge, slider or screw ({kind}): taken as fixed",)


def test_a_free_object_is_the_base(tmp_path: Path) -> None:
    door = '<body name="door"><joint/><geom size="0.1"/></body>'
    shape = read(tmp_path, f'<body name="base"><freejoint/>{BASE}{door}</body>')
    assert shape.repairs == ()
    assert [body.is_movable for body in shape.mobility.bodies] == [False, True]


def test_frames_move_what_is_in_them(tmp_path: Path) -> None:
    inner = '<frame pos="1 0 0"><frame euler="0 0 90"><geom type="box" size="1 2 3"/></frame></frame>'
    shape = read(tmp_path, f'<body name="a">{inner}</body>')
    assert bounds(shape, "a") == [[-1, -1, -3], [3, 1, 3]]


def test_hidden_geoms_count_if_there_are_no_others(tmp_path: Path) -> None:
    shape = read(tmp_path, '<body name="a"><geom group="3" type="box" size="1 2 3"/></body>')
    assert bounds(shape, "a") == [[-1, -2, -3], [1, 2, 3]]


def test_transparent_geoms_are_hidden(tmp_path: Path) -> None:
    shape = read(tmp_path, f'<body name="a">{BASE}<geom type="box" size="9 9 9" rgba="1 0 0 0"/></body>')
    assert bounds(shape, "a") == [[-1, -1, -1], [1, 1, 1]]


def test_groups_of_shown_geoms_can_be_chosen(tmp_path: Path) -> None:
    geoms = '<geom type="box" size="1 1 1"/><geom type="box" name="look" group="1" size="2 2 2"/>'
    (tmp_path / "a.xml").write_text(f'<mujoco><worldbody><body name="a">{geoms}</body></worldbody></mujoco>')
    robot = read_mjcf_robot(tmp_path / "a.xml", refuse, groups=(1,))
    assert [piece.name for piece in robot.pieces["a"]] == ["look"]


def test_a_folder_above_the_file_may_have_what_it_names(tmp_path: Path) -> None:
    write(tmp_path)
    inner = '<mujocoinclude><body name="a"><geom type="mesh" mesh="knob"/></body></mujocoinclude>'
    (tmp_path / "inner.xml").write_text(inner)
    (tmp_path / "scenes").mkdir()
    path = tmp_path / "scenes" / "a.xml"
    asset = '<asset><mesh file="../parts/knob.obj"/></asset><worldbody><include file="../inner.xml"/></worldbody>'
    path.write_text(f"<mujoco>{asset}</mujoco>")
    (piece,) = read_mjcf_robot(path, refuse, home=tmp_path).pieces["a"]
    assert piece.mesh_name == "knob" and np.ptp(piece.mesh.vertices) == 1.0
    with pytest.raises(InputError, match="leads out of the folder"):
        read_mjcf_robot(path, refuse)


def test_files_that_include_each_other_are_named(tmp_path: Path) -> None:
    (tmp_path / "b.xml").write_text('<mujocoinclude><body><include file="a.xml"/></body></mujocoinclude>')
    with pytest.raises(InputError, match=r"b\.xml: include: a\.xml includes itself"):
        read(tmp_path, '<include file="b.xml"/>')


def test_included_files_are_read(tmp_path: Path) -> None:
    inner = '<mujocoinclude><body name="inner"><geom type="box" size="1 1 1"/></body></mujocoinclude>'
    (tmp_path / "inner.xml").write_text(inner)
    shape = read(tmp_path, '<include file="inner.xml"/><body name="b" pos="5 0 0"><geom size="1"/></body>')
    assert sorted(part.name for part in shape.parts) == ["", "b", "inner"]
    assert {found.id for found in discover(tmp_path)} == {"a"}, "the included file is no model"


def test_mesh_assets_are_moved_turned_and_scaled(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_bytes(trimesh.creation.box(bounds=[[1, 2, 3], [2, 4, 6]]).export(file_type="stl"))
    asset = '<asset><mesh file="m.stl" refpos="1 2 3" refquat="1 0 0 1" scale="-1 1 2"/></asset>'
    shape = read(tmp_path, '<body name="a"><geom type="mesh" mesh="m"/></body>', asset)
    # moved to the origin, turned by -90 degrees about z, mirrored in x and stretched along z
    assert bounds(shape, "a") == [[-2, -1, 0], [0, 0, 6]]
    mesh = shape.parts[1].mesh
    assert trimesh.Trimesh(mesh.vertices, mesh.faces).volume == pytest.approx(12.0), "faces still point outwards"


def test_a_missing_mesh_is_skipped_with_a_note(tmp_path: Path) -> None:
    path = write(tmp_path)
    (tmp_path / "parts" / "knob.obj").unlink()
    shape = read_mjcf(path)
    assert "knob" not in {part.name for part in shape.parts}
    assert shape.repairs[0] == "knob.obj skipped: expected a mesh file, found none"


def test_a_change_of_a_mesh_is_noticed(tmp_path: Path) -> None:
    (found,) = discover(write(tmp_path))
    before = fingerprint(found)
    assert [row[0] for row in before] == ["model.xml", "parts/knob.obj"]
    (tmp_path / "parts" / "knob.obj").write_text("")
    assert fingerprint(found) != before


def test_a_change_of_an_included_file_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    (tmp_path / "outer.xml").write_text('<mujocoinclude><include file="more/inner.xml"/></mujocoinclude>')
    inner = tmp_path / "more" / "inner.xml"
    inner.write_text(f'<mujocoinclude><body name="inner">{BASE}</body></mujocoinclude>')
    (tmp_path / "a.xml").write_text('<mujoco><worldbody><include file="outer.xml"/></worldbody></mujoco>')
    (found,) = discover(tmp_path)
    before = fingerprint(found)
    assert [row[0] for row in before] == ["a.xml", "outer.xml", "more/inner.xml"]
    inner.write_text(inner.read_text().replace("inner", "changed"))
    assert fingerprint(found) != before


def test_an_object_without_joints_has_no_annotation(tmp_path: Path) -> None:
    assert read(tmp_path, f'<body name="a">{BASE}</body><body name="b" pos="3 0 0">{BASE}</body>').mobility is None


DEEP = "<body>" * 100 + BASE + "</body>" * 100
MESH = '<body><geom type="mesh" mesh="m"/></body>'
OUTSIDE = '<asset><mesh name="m" file="../m.obj"/></asset>'


@pytest.mark.parametrize(
    ("bodies", "before", "problem"),
    [
        ("", "", "no link has geometry"),
        (DEEP, "", "nested deeper than 64 levels"),
        (MESH, "", r"a\.xml: body 1: geom: mesh: there is no mesh asset m"),
        (MESH, OUTSIDE, r"leads out of the folder"),
        (MESH, '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0" face="0 1 3"/></asset>', r"triangles of vertices 0\.\.2"),
        (MESH, '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 2 2 0"/></asset>', "vertices around a volume"),
        ('<include file="a.xml"/>', "", r"a\.xml: include: a\.xml includes itself"),
        ('<include file="none.xml"/>', "", r"a\.xml: include: none\.xml is missing"),
        ('<include file="../b.xml"/>', "", r"a\.xml: include: \.\./b\.xml: leads out of the folder"),
        ('<geom class="none" size="1"/>', "", r"a\.xml: body world: geom: there is no default class none"),
        ('<geom type="box" name="top" size="1 1"/>', "", "body world: geom top: size: expected 3 finite numbers"),
        ('<geom type="box" size="1 -1 1"/>', "", "body world: geom: size: expected sizes above 0"),
        ('<geom size="1 x"/>', "", "body world: geom: size: expected 1 to 3 finite numbers"),
        ('<geom size="1" rgba="1 1"/>', "", "body world: geom: rgba: expected 4 finite numbers"),
        ('<geom size="1e13"/>', "", "finite coordinates"),
        (f'<body quat="0 0 0 0">{BASE}</body>', "", r"a\.xml: body 1: quat: expected a quaternion that is not zero"),
        (f'<body name="a">{BASE}<frame pos="x"/></body>', "", "body a: frame: pos: expected 3 finite numbers"),
        (f'<body name="a"><joint axis="0 0 0"/>{BASE}</body>', "", "body a: joint: axis: expected a direction"),
        (f'<body name="a"><joint name="j" range="0"/>{BASE}</body>', "", "body a: joint j: range: expected 2 finite"),
        (BASE, '<compiler eulerseq="xyw"/>', "order of axes"),
        (BASE, '<compiler coordinate="global"/>', "local coordinates"),
        (BASE, '<!DOCTYPE a [<!ENTITY b "c">]>', "document type"),
        ("<body>", "", "expected XML"),
    ],
)
def test_a_wrong_file_is_an_error(tmp_path: Path, bodies: str, before: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem) as caught:
        read(tmp_path, bodies, before)
    assert str(caught.value).isprintable()


def test_xml_of_other_kinds_is_no_shape(tmp_path: Path) -> None:
    for name, text in (("a", "<robot/>"), ("b", "<!-- <mujoco> --><data/>"), ("c", ""), ("d", "<mujocoinclude/>")):
        (tmp_path / f"{name}.xml").write_text(text)
    assert not list(discover(tmp_path))
