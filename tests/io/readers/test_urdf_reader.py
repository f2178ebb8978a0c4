"""The reader of URDF files: bodies, joints, and errors."""

import json

import numpy as np
import pytest
import trimesh
from articulated import box_mesh
from datasets import box_obj
from gltf_files import KNOB, GltfBuilder

import kinmo
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.io.discover import discover
from kinmo.io.readers.robot_bodies import robot_bodies
from kinmo.io.readers.robot_meshes import read_mesh
from kinmo.io.readers.urdf_reader import read_robot_file
from kinmo.io.source_files import fingerprint

LINK = '<link name="{0}"><visual><geometry><box size="1 1 {1}"/></geometry></visual></link>'
EMPTY = '<link name="{0}"/>'


def joint(kind, parent, child, inside=""):
    return f'<joint name="{child}_j" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def bodies_of(tmp_path, *elements):
    file = tmp_path / "robot.urdf"
    file.write_text(f"<robot name='r'>{''.join(elements)}</robot>")
    return robot_bodies(read_robot_file(file, tmp_path))


def test_links_with_a_fixed_joint_form_one_body(tmp_path):
    turn = '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>'
    first, second = bodies_of(
        tmp_path,
        LINK.format("a", 1),
        LINK.format("b", 2),
        LINK.format("c", 3),
        joint("fixed", "a", "b", turn),
        joint("revolute", "b", "c", turn + '<axis xyz="2 0 0"/><limit lower="-1" upper="2"/>'),
    )
    assert len(first.triangles) == 24
    assert second.parent == 0
    assert second.joint.pivot == pytest.approx([1, 1, 0])
    assert second.joint.direction == pytest.approx([-1, 0, 0])
    assert (second.joint.lower, second.joint.upper) == (-1, 2)


@pytest.mark.parametrize(
    ("kinds", "axis", "expected"),
    [
        (("prismatic", "continuous"), "1 0 0", JointKind.SCREW),
        (("revolute", "prismatic"), "1 0.05 0", JointKind.SCREW),
        (("revolute", "prismatic"), "1 0.2 0", None),
        (("revolute", "revolute"), "1 0 0", None),
        (("floating", "prismatic"), "1 0 0", None),
    ],
)
def test_two_joints_through_an_empty_link_form_one(tmp_path, kinds, axis, expected):
    limit = '<limit lower="0.1" upper="0.4"/>'
    body = bodies_of(
        tmp_path,
        LINK.format("a", 1),
        EMPTY.format("b"),
        LINK.format("c", 2),
        joint(kinds[0], "a", "b", '<axis xyz="1 0 0"/>' + limit),
        joint(kinds[1], "b", "c", f'<axis xyz="{axis}"/>' + limit),
    )[1]
    assert body.moves
    assert body.parent == 0
    assert (body.joint.kind if body.joint else None) is expected
    if expected is JointKind.SCREW:
        assert (body.joint.lower, body.joint.upper) == (0.1, 0.4)


def test_a_single_top_body_is_the_base_even_with_a_floating_joint(tmp_path):
    (body,) = bodies_of(tmp_path, EMPTY.format("world"), LINK.format("a", 1), joint("floating", "world", "a"))
    assert (body.moves, body.joint, body.parent) == (False, None, None)


def test_all_primitives_and_meshes_are_read(tmp_path):
    (tmp_path / "pkg" / "meshes").mkdir(parents=True)
    trimesh.Trimesh(*_box()).export(tmp_path / "pkg" / "meshes" / "box.stl")
    pieces = (
        '<mesh filename="package://pkg/meshes/box.stl" scale="2 2 2"/>',
        '<mesh filename="pkg/meshes/box.stl"/>',
        '<cylinder radius="1" length="2"/>',
        '<sphere radius="3"/>',
        '<capsule radius="1" length="2"/>',
    )
    visuals = "".join(f"<visual><geometry>{piece}</geometry></visual>" for piece in pieces)
    (body,) = bodies_of(tmp_path, f'<link name="a">{visuals}</link>')
    assert body.triangles.max() == pytest.approx(3)
    assert len(body.triangles) > 24


def test_a_sphere_of_radius_0_is_a_point(tmp_path):
    (body,) = bodies_of(tmp_path, '<link name="a"><visual><geometry><sphere radius="0"/></geometry></visual></link>')
    assert not body.triangles.any()


@pytest.mark.parametrize("name", ["far.obj", "far.ply"])
def test_meshes_with_huge_coordinates_are_an_error(tmp_path, name):
    vertices, faces = _box()
    trimesh.Trimesh(1e35 * vertices, faces, process=False).export(tmp_path / name)
    with pytest.raises(InputError, match=rf"{name}: vertices: expected finite coordinates of at most 1e\+12, got 1e\+35"):
        read_mesh(tmp_path / name)


def _box():
    mesh = box_mesh((0, 0, 0), (1, 1, 1))
    return mesh.vertices, mesh.faces


CYCLE = (EMPTY.format("r"), LINK.format("a", 1), LINK.format("b", 1), joint("fixed", "a", "b"), joint("fixed", "b", "a"))
TWO = (LINK.format("a", 1), LINK.format("b", 1))
TWICE = (*TWO, joint("fixed", "a", "b"), joint("fixed", "a", "b"))
MANY = tuple(map(EMPTY.format, "abcdefg"))
XACRO = '<macro xmlns="http://www.ros.org/wiki/xacro" name="m"/>'
AXES = "".join(f"property float {axis}\n" for axis in "xyz")
MESH = '<link name="a"><visual><geometry><mesh filename="{0}"/></geometry></visual></link>'
ORIGIN = '<origin xyz="1e308 0 0"/>'


@pytest.mark.parametrize(
    ("elements", "problem"),
    [
        ((), "at least one link"),
        ((EMPTY.format("a"), EMPTY.format("a")), "link 2: expected links of different names, found a twice"),
        ((LINK.format("a", 1), "<link/>"), "link 2: expected a name"),
        (TWO, r"expected one root link, found 2 \(a, b\): join them with fixed joints"),
        (MANY, r"found 7 \(a, b, c, d, e, \.\.\.\)"),
        ((LINK.format("a", 1), joint("fixed", "a", "c")), "joint c_j: expected a link of the name 'c'"),
        (TWICE, "joint b_j: expected one joint above link 'b'"),
        (CYCLE, "expected a tree, found a cycle of joints between the links a, b"),
        (CYCLE[1:], "expected a tree, found a cycle of joints between the links a, b"),
        ((LINK.format("a", "nan"),), "link a: size: expected 3 finite"),
        ((LINK.format("a", "1 2"),), "link a: size: expected 3 finite numbers"),
        ((LINK.format("a", "1e200"),), r"3 finite numbers, of at most 1e\+30"),
        ((*TWO, joint("fixed", "a", "b", ORIGIN)), r"joint b_j: xyz: expected 3 finite numbers, of at most 1e\+30"),
        ((*TWO, joint("revolute", "a", "b", '<axis xyz="0 0 1e-200"/>')), "joint b_j: expected an axis that is not zero"),
        ((LINK.format("${prefix}door", 1),), r"robot\.urdf: is a template, found \$\{prefix\}door: run `xacro"),
        ((LINK.format("a", 1), XACRO), r"robot\.urdf: is a template, found xacro:macro: run `xacro"),
        ((MESH.format("no.obj"),), "found none"),
        ((MESH.format("../no.obj"),), "leads out of the folder"),
        ((MESH.format("/etc/passwd"),), "leads out of the folder"),
        ((MESH.format("package://a/../../no.obj"),), "leads out of the folder"),
        ((MESH.format(300 * "x"),), "found none"),
        ((MESH.format("package://" + 300 * "x"),), "is missing"),
        (("<!DOCTYPE x>",), "document type"),
        (("<link",), "XML"),
    ],
)
def test_a_wrong_file_is_an_error_in_one_line(tmp_path, elements, problem):
    with pytest.raises(InputError, match=problem) as caught:
        bodies_of(tmp_path, *elements)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "limit", "expected"),
    [
        ("revolute", '<limit lower="2" upper="-1"/>', (-1, 2)),
        ("prismatic", '<limit lower="0" upper="0"/>', (None, None)),
        ("prismatic", "", (None, None)),
        ("revolute", '<limit lower="-1.7976931348623157e308" upper="1.7976931348623157e308"/>', (None, None)),
        ("continuous", '<limit lower="-1" upper="2"/>', (None, None)),
    ],
)
def test_limits_are_sorted_and_equal_or_infinite_ones_dropped(tmp_path, kind, limit, expected):
    body = bodies_of(tmp_path, LINK.format("a", 1), LINK.format("b", 1), joint(kind, "a", "b", limit))[1]
    assert (body.joint.lower, body.joint.upper) == expected


def write_cabinet(folder, name="mobility.urdf", **meshes):
    """A URDF of a body, a door with a handle, and a drawer, each with an OBJ in the folder `parts`."""
    boxes = {
        "body": ((0, 0, 0), (1, 2, 3)), "door": ((1, 0, 0), (1.1, 1, 3)), "handle": ((0, 0, 0), (0.1, 0.1, 0.1)),
        "drawer": ((1, 1, 0), (1.1, 2, 1)),
    }  # fmt: skip
    (folder / "parts").mkdir(parents=True)
    for part, box in boxes.items():
        (folder / "parts" / f"{part}.obj").write_text(box_obj(*box))
    files = {part: meshes.get(part, f"parts/{part}.obj") for part in boxes}
    geometry = '<visual><geometry><mesh filename="{0}"/></geometry></visual>'
    links = [f'<link name="{part}">{geometry.format(file)}</link>' for part, file in files.items()]
    joints = [
        joint("fixed", "base", "body"),
        joint("revolute", "body", "door", '<origin xyz="0 1 0"/><axis xyz="0 0 -1"/><limit lower="0.5" upper="2"/>'),
        joint("fixed", "door", "handle", '<origin xyz="1 0 1"/>'),
        joint("prismatic", "body", "drawer", '<axis xyz="2 0 0"/><limit lower="0" upper="0.5"/>'),
    ]
    (folder / name).write_text(f"<robot name='r'>{EMPTY.format('base')}{''.join(links)}{''.join(joints)}</robot>")
    return folder


def test_the_links_of_a_folder_with_a_urdf_are_the_parts(tmp_path):
    folder = write_cabinet(tmp_path / "4711")
    shape = kinmo.load(folder)
    assert (shape.id, shape.layout, shape.up, shape.front) == ("4711", "urdf", (0, 0, 1), (-1, 0, 0))
    assert [part.name for part in shape.parts] == ["r", "body", "door", "drawer", "handle"]
    np.testing.assert_allclose(shape.parts[4].mesh.vertices.min(axis=0), [1, 1, 1])
    bodies = shape.mobility.bodies
    assert [(body.name, body.parent) for body in bodies] == [("body", None), ("door", 0), ("drawer", 0)]
    assert [[shape.parts[leaf].name for leaf in body.leaves] for body in bodies] == [["body"], ["door", "handle"], ["drawer"]]
    assert (bodies[1].joint.kind, bodies[1].joint.lower, bodies[1].joint.upper) == (JointKind.REVOLUTE, 0.0, 2.0)
    assert shape.repairs == (
        "joint door_j: range widened to contain the rest value 0",
        "materials box.mtl (missing) ignored: 1",
    )


def test_the_order_of_links_does_not_matter(tmp_path):
    folder = write_cabinet(tmp_path / "a")
    before = kinmo.load(folder)
    robot = (folder / "mobility.urdf").read_text()
    start, end = robot.index('<link name="body"'), robot.index("<joint")
    links = robot[start:end].replace("</link>", "</link>\n").splitlines()
    (folder / "mobility.urdf").write_text(robot[:start] + "".join(reversed(links)) + robot[end:])
    assert [part.name for part in kinmo.load(folder).parts] == [part.name for part in before.parts]


def test_missing_meshes_of_a_shape_are_skipped_and_unlisted_ones_noted(tmp_path):
    folder = write_cabinet(tmp_path / "a", handle="parts/grip.obj")
    shape = kinmo.load(folder)
    assert [part.name for part in shape.parts] == ["r", "body", "door", "drawer"]
    assert shape.repairs[:2] == (
        "grip.obj skipped: expected a mesh file, found none",
        "mobility.urdf does not list handle.obj in parts: not read",
    )


def test_meta_json_beside_a_urdf_states_the_category(tmp_path):
    folder = write_cabinet(tmp_path / "a")
    assert kinmo.load(folder).category == ""
    (folder / "meta.json").write_text(json.dumps({"model_cat": "StorageFurniture", "anno_id": "12"}))
    shape = kinmo.load(folder)
    assert (shape.category, shape.partnet_id, "category" in shape.guesses) == ("StorageFurniture", "12", False)


def test_a_single_link_is_a_shape_with_a_note(tmp_path):
    shape_file = tmp_path / "thing.urdf"
    shape_file.write_text(f"<robot name='r'>{LINK.format('a', 1)}</robot>")
    shape = kinmo.load(tmp_path)
    assert (shape.id, len(shape.leaves), shape.mobility) == ("thing", 1, None)
    assert "one link has geometry" in shape.repairs[0]


@pytest.mark.parametrize(
    ("geometry", "note"),
    [
        ("", "visual without geometry: skipped"),
        ("<geometry/>", "visual without geometry: skipped"),
        ('<geometry><box size="-0.7 0.4 0.02"/></geometry>', "box with the size -0.7 0.4 0.02, below 0: skipped"),
        ('<geometry><cylinder radius="1" length="-2"/></geometry>', "cylinder with the length -2, below 0: skipped"),
        ("<geometry><mesh/></geometry>", "mesh without filename: skipped"),
        ('<geometry><sphere radius="0"/></geometry>', "1 piece without a surface: skipped"),
    ],
)
def test_a_visual_that_shows_nothing_is_noted(tmp_path, geometry, note):
    path = tmp_path / "a.urdf"
    good = LINK.format("b", 1)
    path.write_text(f"<robot name='r'>{good.replace('</link>', f'<visual>{geometry}</visual></link>')}</robot>")
    assert f"link b: {note}" in kinmo.load(path).repairs


@pytest.mark.parametrize(("before", "after"), [("\n \n", ""), ("", "\n\0")])
def test_empty_lines_and_zeros_around_the_text_are_skipped(tmp_path, before, after):
    path = tmp_path / "a.urdf"
    path.write_text(f"{before}<?xml version='1.0'?>\n<robot name='r'>{LINK.format('b', 1)}</robot>{after}")
    assert len(kinmo.load(path).leaves) == 1


def test_meshes_of_a_package_of_ros_are_found(tmp_path):
    package = write_cabinet(
        tmp_path / "checkout",
        door="package://pkg/parts/door.obj",
        body="../parts/body.obj",
        **{part: f"../parts/{part}.obj" for part in ("handle", "drawer")},
    )
    (package / "urdf").mkdir()
    (package / "mobility.urdf").rename(package / "urdf" / "cabinet.urdf")
    with pytest.raises(
        InputError, match=r"leads out of the folder urdf: .*: put an empty package\.xml into .*/checkout to allow it"
    ):
        kinmo.load(package / "urdf" / "cabinet.urdf")
    (package / "package.xml").write_text("<package/>")
    assert len(kinmo.load(package / "urdf" / "cabinet.urdf").leaves) == 4


def test_a_package_is_the_nearest_folder_of_its_name(tmp_path, monkeypatch):
    package = write_cabinet(
        tmp_path / "pkg" / "ws" / "pkg",
        **{part: f"package://pkg/parts/{part}.obj" for part in ("body", "door", "handle", "drawer")},
    )
    (package / "urdf").mkdir()
    file = (package / "mobility.urdf").rename(package / "urdf" / "cabinet.urdf")
    (package / "urdf" / "parts").mkdir()
    (package / "urdf" / "parts" / "door.obj").write_text("not this one")
    shape = kinmo.load(file)
    assert len(shape.leaves) == 4 and not any("skipped" in line for line in shape.repairs)
    assert len(fingerprint(next(discover(file)))) == 5
    monkeypatch.chdir(package / "urdf")
    assert len(kinmo.load("cabinet.urdf").leaves) == 4
    (package / "urdf" / "parts" / "door.obj").unlink()
    (package / "parts" / "door.obj").rename(tmp_path / "pkg" / "door.obj")
    line = kinmo.load(file).repairs[0]
    looked = f"looked in {package / 'urdf'} and above it up to {package}"
    assert line == f"door.obj skipped: package://pkg/parts/door.obj is missing, {looked}"
    file.write_text(file.read_text().replace("pkg/parts/door.obj", "pkg/../../door.obj"))
    with pytest.raises(InputError, match="leads out of the folder pkg"):
        kinmo.load(file)


def test_a_package_that_is_not_found_is_named(tmp_path):
    folder = write_cabinet(tmp_path / "a", door="package://pkg/parts/other.obj")
    problem = f"package://pkg/parts/other.obj is missing, looked in {folder}"
    remedy = "the folder of mobility.urdf, or one above it, must have the name pkg"
    assert kinmo.load(folder).repairs[0] == f"other.obj skipped: {problem}: {remedy}"


def test_the_home_folder_is_no_package(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "user"))
    folder = write_cabinet(tmp_path / "user" / "a", door="package://user/secret.obj")
    (folder / "parts" / "door.obj").rename(tmp_path / "user" / "secret.obj")
    assert "package://user/secret.obj is missing" in kinmo.load(folder).repairs[0]


def test_a_missing_file_elsewhere_is_named_with_the_robot_file(tmp_path):
    folder = write_cabinet(tmp_path / "a", door="/no/such/door.obj")
    problem = "the mesh /no/such/door.obj is missing, and leads out of the folder a: write its path relative to mobility.urdf"
    with pytest.raises(InputError, match=f"mobility.urdf: link door: {problem}"):
        kinmo.load(folder)


def test_meshes_of_a_model_of_gazebo_are_found(tmp_path):
    model = write_cabinet(tmp_path / "cupboard", door="model://cupboard/parts/door.obj")
    assert len(kinmo.load(model / "mobility.urdf").leaves) == 4


def test_pieces_have_the_names_of_elements_and_of_mesh_files(tmp_path):
    (tmp_path / "panel.obj").write_text(box_obj((0, 0, 0), (1, 1, 1)))
    visuals = '<visual name="door"><geometry><mesh filename="panel.obj"/></geometry></visual>' + (
        '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    )
    (tmp_path / "robot.urdf").write_text(f'<robot name="r"><link name="a">{visuals}</link></robot>')
    pieces = read_robot_file(tmp_path / "robot.urdf", tmp_path).pieces["a"]
    assert [(piece.name, piece.mesh_name) for piece in pieces] == [("door", "panel"), ("", "")]


def test_commas_between_numbers_are_spaces(tmp_path):
    turn = '<origin xyz="1, 2,3"/><axis xyz="0,0 1"/>'
    _, door = bodies_of(tmp_path, LINK.format("a", 1), LINK.format("b", 1), joint("continuous", "a", "b", turn))
    assert door.joint.pivot == pytest.approx([1, 2, 3]) and door.joint.direction == pytest.approx([0, 0, 1])


def test_a_fixed_joint_needs_no_axis(tmp_path):
    (only,) = bodies_of(tmp_path, LINK.format("a", 1), LINK.format("b", 1), joint("fixed", "a", "b", '<axis xyz="0 0 0"/>'))
    assert only.links == ("a", "b")


def test_a_change_of_a_mesh_of_a_urdf_is_noticed(tmp_path):
    folder = write_cabinet(tmp_path / "a")
    (found,) = discover(folder)
    before = fingerprint(found)
    assert [row[0] for row in before] == [
        "mobility.urdf",
        *(f"parts/{part}.obj" for part in ("body", "door", "handle", "drawer")),
    ]
    (folder / "parts" / "door.obj").write_text("")
    assert fingerprint(found) != before


def test_a_change_of_a_file_that_a_mesh_of_a_urdf_names_is_noticed(tmp_path):
    builder = GltfBuilder()
    builder.scene(builder.node(mesh=builder.mesh(KNOB))).write_gltf(tmp_path / "knob.gltf", "knob.bin")
    (tmp_path / "robot.urdf").write_text(
        "<robot name='r'><link name='a'><visual><geometry><mesh filename='knob.gltf'/></geometry></visual></link></robot>"
    )
    (found,) = discover(tmp_path / "robot.urdf")
    assert [row[0] for row in fingerprint(found)] == ["robot.urdf", "knob.gltf", "knob.bin"]


def test_files_outside_of_the_folder_do_not_count(tmp_path):
    folder = write_cabinet(tmp_path / "a")
    (tmp_path / "secret.obj").write_text("mtllib secret.mtl\n")
    file = folder / "mobility.urdf"
    file.write_text(file.read_text().replace("parts/door.obj", "../secret.obj"))
    (found,) = discover(folder)
    assert not [row[0] for row in fingerprint(found) if "secret" in row[0] or "door" in row[0]]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"),
        ("a.obj", "v 0 0 0\n"),
        ("a.stl", "solid\nendsolid\n"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + AXES + "end_header\n0 0 0\n"),
        ("a.step", "ISO-10303-21;"),
    ],
)
def test_meshes_without_faces_are_an_error(tmp_path, name, content):
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=rf"{name}: (has no faces|expected an? (STL file with triangles|mesh as \.obj))"):
        read_mesh(tmp_path / name)


def test_a_capsule_is_centred(tmp_path):
    (body,) = bodies_of(
        tmp_path, '<link name="a"><visual><geometry><capsule radius="1" length="2"/></geometry></visual></link>'
    )
    np.testing.assert_allclose([body.triangles[..., 2].min(), body.triangles[..., 2].max()], [-2, 2])
