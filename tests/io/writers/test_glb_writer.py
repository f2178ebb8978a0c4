"""The GLB writer: other readers find all geometry at its place, and animations move every link as kinmo does."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from articulated import articulated_shapes, shape_of_boxes
from glb_contents import GlbContents
from hypothesis import given, settings

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.shape import Shape
from kinmo.evaluation.simulation.expected_kinematics import expected_kinematics
from kinmo.io.readers.gltf_reader import read_glb
from kinmo.io.writers import ExportOptions, write_formats
from kinmo.io.writers.glb_writer import DURATION, glb_bytes, joint_values
from kinmo.robot.robot import Robot
from kinmo.robot.robot_builder import build_robot

UPS = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, 0.8))


def robot_of(shape: Shape, scale: float = 1.0) -> Robot:
    assert shape.mobility is not None
    return build_robot(shape, shape.mobility, scale)


def value_at(robot: Robot, name: str, time: float) -> float:
    """Value of a joint at a time of its animation: it moves with constant speed."""
    values = joint_values(next(joint for joint in robot.joints if joint.name == name))
    lengths = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(values)))])
    return float(np.interp(time / DURATION * lengths[-1], lengths, values))


@pytest.mark.parametrize(
    ("up", "front", "points", "expected"),
    [
        ((0, 1, 0), None, (1, 2, 3), (1, 2, 3)),
        ((0, 1, 0), (1, 0, 0), (1, 2, 3), (1, 2, 3)),
        ((0, 0, 1), None, (1, -3, 2), (1, 2, 3)),
        ((0, 0, 1), (1, 0, 0), (3, 1, 2), (1, 2, 3)),
    ],
    ids=["y up", "y up, front known", "z up", "z up, front known"],
)
def test_up_is_y_and_the_front_faces_z(up, front, points, expected) -> None:
    shape = replace(shape_of_boxes([((0, 0, 0), points)], [Body(0, "base", (1,))]), up=up, front=front)
    corners = trimesh.load_scene(io.BytesIO(glb_bytes(robot_of(shape))), file_type="glb").to_geometry().vertices
    assert corners[np.argmax(np.abs(corners).sum(axis=1))] == pytest.approx(np.array(expected))


@settings(max_examples=20)
@given(articulated_shapes(ups=UPS))
def test_animations_move_every_link_as_kinmo_does(shape: Shape) -> None:
    robot = robot_of(shape, 0.7)
    contents = GlbContents(glb_bytes(robot))
    assert shape.mobility is not None
    motions = expected_kinematics(shape.mobility, np.array(shape.up), 0.7)
    frame = np.eye(4)
    frame[:3, :3] = robot.gltf_rotation.T
    rng = np.random.default_rng(0)
    for _ in range(20):
        moments = {joint.name: float(rng.uniform(0.0, DURATION)) for joint in robot.joints}
        expected = motions({name: value_at(robot, name, time) for name, time in moments.items()})
        found, still = contents.poses(moments), contents.poses({})
        for name, motion in expected.items():
            moved = frame @ found[name] @ np.linalg.inv(still[name]) @ frame.T
            np.testing.assert_allclose(moved, motion, atol=2e-5)  # float32


@settings(max_examples=20)
@given(articulated_shapes(ups=UPS))
def test_other_readers_find_all_geometry_at_its_place(shape: Shape) -> None:
    robot = robot_of(shape)
    scene = trimesh.load_scene(io.BytesIO(glb_bytes(robot)), file_type="glb")
    expected = [visual.mesh.triangles @ robot.gltf_rotation.T for link in robot.links for visual in link.visuals]
    found = [mesh.triangles for mesh in scene.dump()]
    assert len(found) == len(expected)
    for triangles in expected:
        assert any(one.shape == triangles.shape and np.allclose(one, triangles, atol=1e-5) for one in found)


def door_and_drawer() -> Shape:
    door = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), -0.5, 2.5)
    drawer = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.4)
    knob = Joint(JointKind.REVOLUTE, np.array([0.0, 0.0, 1.0]), np.array([0.5, 0.5, 1.1]))
    base, leaf = Body(0, "base", (1,)), Body(1, "door", (2,), 0, door)
    bodies = base, leaf, Body(2, "drawer", (3,), 0, drawer), Body(3, "knob", (4,), 1, knob)
    boxes = [((0, 0, 0), (1, 1, 1)), ((0, 0, 1), (1, 1, 1.1)), ((1, 0, 0), (2, 1, 1)), ((0.4, 0.4, 1.1), (0.6, 0.6, 1.2))]
    return shape_of_boxes(boxes, bodies, names={1: "box", 2: "leaf", 3: "tray", 4: "grip"})


def test_kinmo_reads_its_own_parts_below_their_links(tmp_path: Path) -> None:
    shape = door_and_drawer()
    assert shape.mobility is not None
    options = ExportOptions("cabinet", collision="none")
    path = write_formats(shape, shape.mobility, tmp_path, ["glb"], options)["glb"]
    assert path == tmp_path / "cabinet.glb"
    found = read_glb(path)
    assert {part.name for part in found.parts} >= {"base", "door", "box", "leaf", "tray", "grip"}
    by_name = {part.name: part for part in found.parts}
    for leaf in shape.leaves:
        mesh = by_name[shape.parts[leaf].name].mesh
        assert mesh is not None
        np.testing.assert_allclose(mesh.triangles, shape.leaf_mesh(leaf).triangles, atol=1e-6)


def test_a_node_tells_its_joint_in_its_own_frame() -> None:
    document = GlbContents(glb_bytes(robot_of(door_and_drawer()))).document
    extras = {node["name"]: node.get("extras") for node in document["nodes"]}
    assert extras["door"] == {"joint": "door_joint", "type": "revolute", "axis": [0.0, 1.0, 0.0], "lower": -0.5, "upper": 2.5}
    assert extras["drawer"]["axis"] == [0.0, 0.0, 1.0] and extras["drawer"]["type"] == "prismatic"
    assert extras["knob"].keys() == {"joint", "type", "axis"}
    assert [animation["name"] for animation in document["animations"]] == ["door_joint", "drawer_joint", "knob_joint"]


@pytest.mark.parametrize(
    ("name", "corners"), [("door_joint", (0, -0.5, 2.5, 0)), ("drawer_joint", (0, 0.4, 0)), ("knob_joint", (0, 2 * np.pi))]
)
def test_a_joint_moves_to_both_limits_in_small_turns(name: str, corners: tuple[float, ...]) -> None:
    robot = robot_of(door_and_drawer())
    values = joint_values(next(joint for joint in robot.joints if joint.name == name))
    assert set(np.round(corners, 9)) <= set(np.round(values, 9))
    assert values[0] == 0.0 and values[-1] == pytest.approx(corners[-1])
    steps = np.abs(np.diff(values))
    assert (steps > 0.0).all() and steps.max() <= np.pi / 3 + 1e-9


def test_a_joint_without_a_range_stands_still() -> None:
    joint = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3), 0.0, 0.0)
    shape = shape_of_boxes([((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 2, 1))], (Body(0, "a", (1,)), Body(1, "b", (2,), 0, joint)))
    contents = GlbContents(glb_bytes(robot_of(shape)))
    np.testing.assert_allclose(contents.poses({"b_joint": 3.0})["b"], np.eye(4))
