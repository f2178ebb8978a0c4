"""Reading SDF files of Gazebo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import sdf_file
from kinmo.core.errors import InputError
from kinmo.io.readers.robot_bodies import robot_bodies


def box(name: str, size: str = "1 1 1") -> str:
    return f'<visual name="{name}"><pose>0 0 1 0 0 0</pose><geometry><box><size>{size}</size></box></geometry></visual>'


def read(tmp_path: Path, content: str, version: str = "1.6", root: str = "sdf"):
    path = tmp_path / "model.sdf"
    path.write_text(f'<{root} version="{version}"><model name="m">{content}</model></{root}>')
    problems: list[InputError] = []
    return sdf_file.read_sdf_robot(path, problems.append, tmp_path), problems


def joint(child: str, axis: str, kind: str = "revolute", parent: str = "base") -> str:
    return (
        f'<joint name="j_{child}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"<pose>0.5 0 0 0 0 0</pose><axis>{axis}</axis></joint>"
    )


BASE = f'<link name="base">{box("carcass")}</link>'
DOOR = f'<link name="door"><pose>2 0 0 0 0 1.5707963267948966</pose>{box("panel")}</link>'
AXIS = "<xyz>1 0 0</xyz><limit><lower>0</lower><upper>1.5</upper></limit>"


@pytest.mark.parametrize(
    ("version", "extra", "axis"),
    [
        ("1.4", "", (1, 0, 0)),
        ("1.6", "", (0, 1, 0)),
        ("1.6", "<use_parent_model_frame>1</use_parent_model_frame>", (1, 0, 0)),
    ],
)
def test_axes_are_in_the_frame_that_the_version_says(tmp_path, version, extra, axis):
    robot, _ = read(tmp_path, BASE + DOOR + joint("door", AXIS + extra), version)
    above = robot.joint_above["door"]
    np.testing.assert_allclose(above.axis, axis, atol=1e-12)
    np.testing.assert_allclose(above.pivot, (2, 0.5, 0), atol=1e-12)
    assert (above.type, above.limits, robot.links) == ("revolute", (0.0, 1.5), ("base", "door"))


def test_visual_elements_are_where_links_are(tmp_path):
    robot, _ = read(tmp_path, BASE + DOOR + joint("door", AXIS))
    (piece,) = robot.pieces["door"]
    assert piece.name == "panel"
    np.testing.assert_allclose(piece.mesh.vertices.mean(axis=0), (2, 0, 1), atol=1e-12)


def test_links_without_joints_rest_together(tmp_path):
    robot, _ = read(tmp_path, BASE + f'<link name="foot">{box("foot")}</link>' + DOOR + joint("door", AXIS))
    assert robot.links[0] == sdf_file.ROOT
    assert [body.links for body in robot_bodies(robot)] == [("base", "foot"), ("door",)]


def test_equal_limits_hold_a_joint_and_huge_ones_are_none(tmp_path):
    held = "<xyz>0 0 1</xyz><limit><lower>0</lower><upper>0</upper></limit>"
    free = "<xyz>0 0 1</xyz><limit><lower>-1.79769e+308</lower><upper>1e16</upper></limit>"
    door = DOOR.replace("door", "wheel")
    robot, _ = read(tmp_path, BASE + DOOR + door + joint("door", held) + joint("wheel", free), root="gazebo")
    assert robot.joint_above["door"].type == "fixed"
    assert (robot.joint_above["wheel"].type, robot.joint_above["wheel"].limits) == ("revolute", None)


def test_meshes_are_found_in_models_and_scaled(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "board.stl").write_bytes(trimesh.creation.box((1, 1, 1)).export(file_type="stl"))
    mesh = "<mesh><uri>model://cupboard/meshes/{}.stl</uri><scale>1 2 3</scale></mesh>"
    visuals = "".join(f"<visual><geometry>{mesh.format(name)}</geometry></visual>" for name in ("board", "lost"))
    robot, problems = read(tmp_path, f'<link name="base">{visuals}</link>')
    (piece,) = robot.pieces["base"]
    assert piece.mesh_name == "board" and [Path(problem.where).name for problem in problems] == ["lost.stl"]
    np.testing.assert_allclose(np.ptp(piece.mesh.vertices, axis=0), (1, 2, 3))


NODE = '<node name="{}"><matrix>1 0 0 {} 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node>'
DAE = f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="f" count="9">0 0 0 1 0 0 0 1 0</float_array>
<technique_common><accessor source="#f" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries>
<library_visual_scenes><visual_scene id="s">{NODE.format("left", -3)}{NODE.format("right", 5)}</visual_scene>
</library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_a_submesh_is_a_node_of_its_file(tmp_path):
    pytest.importorskip("collada", reason="needs kinmo[formats]")
    (tmp_path / "both.dae").write_text(DAE)
    mesh = "<mesh><uri>both.dae</uri><submesh><name>right</name><center>{}</center></submesh></mesh>"
    visuals = "".join(f"<visual><geometry>{mesh.format(centre)}</geometry></visual>" for centre in ("false", "true"))
    robot, problems = read(tmp_path, f'<link name="base">{visuals}</link>')
    assert not problems
    ends = [(piece.mesh.vertices[:, 0].min(), piece.mesh.vertices[:, 0].max()) for piece in robot.pieces["base"]]
    np.testing.assert_allclose(ends, ((5.0, 6.0), (-0.5, 0.5)), atol=1e-6)


@pytest.mark.parametrize(
    "content", ["<robot/>", "<sdf><world/></sdf>", '<sdf version="new"><model/></sdf>', '<sdf version="1.6"><model/></sdf>']
)
def test_other_files_are_refused(tmp_path, content):
    (tmp_path / "a.sdf").write_text(content)
    with pytest.raises(InputError):
        sdf_file.read_sdf_robot(tmp_path / "a.sdf", lambda problem: None, tmp_path)
