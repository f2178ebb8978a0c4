"""The URDF writer: a simulator moves the robot as kinmo does, and all geometry is kept."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pybullet
import pytest
import trimesh
from articulated import articulated_shapes, shape_of_boxes
from exports import write_urdf
from hypothesis import given, settings
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import forward
from kinmo.core.links import links_of
from kinmo.core.mobility import Body, Mobility
from kinmo.core.names import unique_names
from kinmo.io.writers import ExportOptions, export, write_formats
from kinmo.robot.collision_geometry import MESH_NOTE
from kinmo.robot.robot_builder import build_robot

UPS = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8))
STATES = 100


@pytest.fixture(scope="module")
def bullet():
    """A connection to the simulator PyBullet."""
    client = pybullet.connect(pybullet.DIRECT)
    yield client
    pybullet.disconnect(client)


def joint_values(mobility, rng):
    """Random joint values and screw angles by index of the body."""
    values = {i: body.joint.rest + rng.uniform(-1, 1) for i, body in mobility.movable()}
    screw_angles = {i: rng.uniform(-3, 3) for i, body in mobility.movable() if body.joint.kind is JointKind.SCREW}
    return values, screw_angles


def load_robot(path, client):
    """The robot in the simulator, and the numbers of its joints and links by name."""
    robot = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
    info = [
        pybullet.getJointInfo(robot, i, physicsClientId=client)
        for i in range(pybullet.getNumJoints(robot, physicsClientId=client))
    ]
    return robot, {row[1].decode(): row[0] for row in info}, {row[12].decode(): row[0] for row in info}


@settings(max_examples=8)
@given(articulated_shapes(ups=UPS))
def test_a_simulator_moves_every_link_as_kinmo_does(tmp_path_factory, bullet, shape):
    scale = 0.7
    mobility = with_other_rest_values(shape.mobility)
    path = write_urdf(
        shape, mobility, tmp_path_factory.mktemp("robot") / "out", ExportOptions(metres_per_unit=scale, collision="none")
    )
    origins = {link.name: link.origin for link in build_robot(shape, mobility, scale).links}
    robot, joints, names = load_robot(path, bullet)
    rotation, links = z_up_rotation(np.array(shape.up)), links_of(mobility)
    rng = np.random.default_rng(0)
    for _ in range(STATES):
        values, screw_angles = joint_values(mobility, rng)
        for link in links[1:]:
            offset = values[link.body] - link.joint.rest
            slides = link.joint.kind is not JointKind.REVOLUTE
            first = f"{link.name}_slide_joint" if link.joint.kind is JointKind.SCREW else f"{link.name}_joint"
            pybullet.resetJointState(robot, joints[first], offset * (scale if slides else 1.0), physicsClientId=bullet)
            if link.body in screw_angles:
                pybullet.resetJointState(robot, joints[f"{link.name}_joint"], screw_angles[link.body], physicsClientId=bullet)
        poses = forward(mobility, values, screw_angles)
        for link in links[1:]:
            state = pybullet.getLinkState(robot, names[link.name], computeForwardKinematics=1, physicsClientId=bullet)
            start = rotation.T @ origins[link.name] / scale
            pose = poses[link.body]
            expected = scale * rotation @ (pose[:3, :3] @ start + pose[:3, 3])
            expected_rotation = rotation @ pose[:3, :3] @ rotation.T
            assert np.abs(np.array(state[4]) - expected).max() < 1e-6 * max(1.0, scale * shape.diagonal)
            assert np.abs(Rotation.from_quat(state[5]).as_matrix() - expected_rotation).max() < 1e-6
    pybullet.removeBody(robot, physicsClientId=bullet)


def with_other_rest_values(mobility):
    """The same tree with joints that do not rest at 0."""
    bodies = (b if b.joint is None else replace(b, joint=replace(b.joint, rest=0.1 * b.id)) for b in mobility.bodies)
    return Mobility(tuple(bodies))


def test_files_of_a_ros_package_are_named_by_it(tmp_path):
    shape = shape_of_boxes([((0, 0, 0), (1, 1, 1))], [Body(0, "base", (1,))])
    path = write_urdf(shape, shape.mobility, tmp_path / "out", ExportOptions(collision="mesh", package="box_description"))
    files = [mesh.get("filename") for mesh in ET.parse(path).iter("mesh")]
    assert len(files) == 2
    for file in files:
        assert (tmp_path / "out" / file.removeprefix("package://box_description/")).is_file()


def test_surfaces_as_collision_geometry_are_noted(tmp_path):
    shape = shape_of_boxes([((0, 0, 0), (1, 1, 1))], [Body(0, "base", (1,))])
    for mode, expected in (("mesh", [MESH_NOTE]), ("none", [])):
        notes = []
        write_formats(shape, shape.mobility, tmp_path, ["urdf"], ExportOptions(collision=mode), notes)
        assert notes == expected


def test_every_link_is_a_body_of_mujoco(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    shape = cabinet(Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3), 0.0, 1.0))
    path = write_urdf(shape, shape.mobility, tmp_path / "out")
    model = mujoco.MjModel.from_xml_path(str(path))
    links = [link.get("name") for link in ET.parse(path).iter("link")]
    assert [model.body(number).name for number in range(1, model.nbody)] == links


@settings(max_examples=15)
@given(articulated_shapes(ups=UPS))
def test_all_leaves_are_at_their_place(tmp_path_factory, shape):
    path = write_urdf(shape, shape.mobility, tmp_path_factory.mktemp("robot") / "out")
    tree, rotation = ET.parse(path), z_up_rotation(np.array(shape.up))
    parent_of = {j.find("child").get("link"): j for j in tree.iter("joint")}

    def position(link):
        if link not in parent_of:
            return np.zeros(3)
        joint = parent_of[link]
        return position(joint.find("parent").get("link")) + np.array(joint.find("origin").get("xyz").split(), float)

    seen = {}
    for link in tree.iter("link"):
        for visual in link.iter("visual"):
            mesh = trimesh.load(path.parent / visual.find("geometry/mesh").get("filename"), process=False)
            assert visual.find("origin").get("rpy") == "0 0 0"
            shift = np.array(visual.find("origin").get("xyz").split(), float)
            seen[visual.get("name")] = (mesh.vertices + shift + position(link.get("name")), mesh.faces)
    for leaf, name in zip(shape.leaves, unique_names(shape.parts[leaf].name for leaf in shape.leaves), strict=True):
        mesh, (vertices, faces) = shape.parts[leaf].mesh, seen.pop(name)
        assert vertices == pytest.approx(mesh.vertices @ rotation.T, abs=1e-9)
        assert np.array_equal(faces, mesh.faces)
    assert not seen


def cabinet(joint, **body):
    """A cabinet with a door on `joint` and a handle that is fixed to the door."""
    boxes = [((0, 0, 0), (1, 2, 1)), ((0, 0, 1), (1, 2, 1.1)), ((0.8, 1, 1.1), (0.9, 1.1, 1.2))]
    bodies = (Body(0, "body", (1,)), Body(1, "door", (2,), 0, joint), Body(2, "handle", (3,), 1))
    return shape_of_boxes(boxes, bodies, **body)


def test_bodies_that_are_fixed_to_each_other_are_one_link(tmp_path):
    shape = cabinet(Joint(JointKind.REVOLUTE, np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), 0.0, 1.5))
    tree = ET.parse(write_urdf(shape, shape.mobility, tmp_path / "out"))
    assert [link.get("name") for link in tree.iter("link")] == ["base", "door"]
    assert [len(link.findall("visual")) for link in tree.iter("link")] == [1, 2]


@pytest.mark.parametrize(
    ("kind", "limits", "expected"),
    [
        (JointKind.REVOLUTE, (0.0, 1.5), ["revolute"]),
        (JointKind.REVOLUTE, (None, None), ["continuous"]),
        (JointKind.PRISMATIC, (0.0, 0.5), ["prismatic"]),
        (JointKind.SCREW, (0.0, 0.5), ["prismatic", "continuous"]),
    ],
)
def test_each_kind_of_joint_has_its_urdf_type(tmp_path, kind, limits, expected):
    shape = cabinet(Joint(kind, np.array([0.0, 1, 0]), np.zeros(3), *limits))
    tree = ET.parse(write_urdf(shape, shape.mobility, tmp_path / "out"))
    assert [joint.get("type") for joint in tree.iter("joint")] == expected
    limited = next(tree.iter("joint")).find("limit")
    assert (limited.get("upper") is None) == (limits[1] is None)


def test_inertia_is_physically_possible(tmp_path):
    shape = cabinet(Joint(JointKind.SCREW, np.array([0.0, 1, 0]), np.zeros(3)))
    tree = ET.parse(write_urdf(shape, shape.mobility, tmp_path / "out"))
    for inertial in tree.iter("inertial"):
        moments = np.sort([float(inertial.find("inertia").get(key)) for key in ("ixx", "iyy", "izz")])
        assert float(inertial.find("mass").get("value")) > 0
        assert moments[0] > 0
        assert moments[2] <= moments[0] + moments[1]


def test_names_of_joints_do_not_collide_with_names_of_bodies(tmp_path):
    screw = Joint(JointKind.SCREW, np.array([0.0, 1, 0]), np.zeros(3))
    names = ("base", "knob", "Knob_Slide", "knob_joint")
    bodies = [Body(i, name, (i + 1,), 0 if i else None, screw if i else None) for i, name in enumerate(names)]
    shape = shape_of_boxes([((i, 0, 0), (i + 1, 1, 1)) for i in range(4)], bodies)
    tree = ET.parse(write_urdf(shape, shape.mobility, tmp_path / "out"))
    links, joints = ([element.get("name") for element in tree.iter(kind) if element.get("name")] for kind in ("link", "joint"))
    assert {*names} <= {*links}
    assert len({name.lower() for name in links + joints}) == len(links + joints) == 2 * 3 + 1 + 2 * 3
    assert {end.get("link") for kind in ("parent", "child") for end in tree.iter(kind)} == {*links}
    assert sorted(end.get("link") for end in tree.iter("child")) == sorted(set(links) - {"base"}), "a tree"


def test_the_joints_of_a_screw_have_the_name_of_its_body(tmp_path):
    shape = cabinet(Joint(JointKind.SCREW, np.array([0.0, 1, 0]), np.zeros(3)))
    tree = ET.parse(write_urdf(shape, shape.mobility, tmp_path / "out"))
    assert [link.get("name") for link in tree.iter("link")] == ["base", "door_slide", "door"]
    assert [joint.get("name") for joint in tree.iter("joint")] == ["door_slide_joint", "door_joint"]


def test_a_failed_export_leaves_the_old_folder(tmp_path, monkeypatch):
    shape = cabinet(Joint(JointKind.PRISMATIC, np.array([0.0, 1, 0]), np.zeros(3)))
    path = export(shape, shape.mobility, tmp_path / "out", ["urdf"])["urdf"]
    before = path.read_bytes()

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr("kinmo.io.writers.robot_meshes.write_obj", fail)
    with pytest.raises(OSError, match="disk full"):
        export(shape, shape.mobility, tmp_path / "out", ["urdf"], ExportOptions(metres_per_unit=2.0))
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_all_formats_can_be_written_into_one_folder(tmp_path):
    shape = cabinet(Joint(JointKind.REVOLUTE, np.array([0.0, 1, 0]), np.zeros(3), 0.0, 1.0))
    paths = export(shape, shape.mobility, tmp_path / "out", ["urdf", "partnet_mobility"], ExportOptions(name="cabinet"))
    assert paths == {"urdf": tmp_path / "out" / "cabinet.urdf", "partnet_mobility": tmp_path / "out"}
    assert all(path.exists() for path in paths.values())


def test_an_unknown_format_is_an_error_with_a_suggestion(tmp_path):
    shape = cabinet(Joint(JointKind.PRISMATIC, np.array([0.0, 1, 0]), np.zeros(3)))
    with pytest.raises(InputError, match=r"unknown format urfd \(did you mean urdf\?\); expected one of glb, joints_json"):
        export(shape, shape.mobility, tmp_path / "out", ["urfd"])
    assert not list(tmp_path.iterdir())
