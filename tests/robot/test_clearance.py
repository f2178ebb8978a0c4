"""Gaps between the links of a robot."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.oriented_box import Box
from kinmo.robot.clearance import GAP, MARGINS, MAX_GAP, _Piece
from kinmo.robot.robot import Collision, Robot
from kinmo.robot.robot_builder import build_robot

Y = np.array([0.0, 1.0, 0.0])
Z = np.array([0.0, 0.0, 1.0])
CARCASS = ((0.0, 0.0, 0.0), (1.0, 1.0, 0.5))


def robot_with(
    *parts: tuple[tuple[float, float, float], tuple[float, float, float]], joint: Joint, scale: float = 1.0
) -> Robot:
    """A carcass whose other parts move by one joint each, as a robot with convex collision geometry."""
    bodies = [Body(0, "carcass", (1,)), *(Body(i, f"part {i}", (i + 1,), 0, joint) for i in range(1, len(parts) + 1))]
    shape = shape_of_boxes([CARCASS, *parts], bodies)
    return build_robot(shape, shape.mobility, scale, collision="convex")


def boxes(robot: Robot, link: int) -> list[Box]:
    return [shape for each in robot.links[link].collisions if isinstance(shape := each.shape, Box)]


def gap(robot: Robot, one: int, other: int) -> float:
    """Largest gap along a coordinate axis between the boxes of two links."""
    spans = [np.concatenate([box.corners() for box in boxes(robot, link)]) for link in (one, other)]
    (low, high), (least, most) = ((points.min(axis=0), points.max(axis=0)) for points in spans)
    return float(np.max(np.maximum(least - high, low - most)))


def test_a_door_that_touches_the_carcass_gets_a_gap() -> None:
    robot = robot_with(
        ((0.0, 0.0, 0.5), (1.0, 1.0, 0.52)), joint=Joint(JointKind.REVOLUTE, Y, np.array([0, 0, 0.52]), -1.5, 0.0)
    )
    assert GAP <= gap(robot, 0, 1) / robot.diagonal <= 3.0 * GAP


@pytest.mark.parametrize(("scale", "least"), [(0.2, MARGINS), (0.02, MAX_GAP * 0.02 * 1.5)])
def test_small_objects_have_room_for_the_margins_of_a_simulator(scale: float, least: float) -> None:
    joint = Joint(JointKind.PRISMATIC, Z, np.zeros(3), 0.0, 0.4)
    robot = robot_with(((0.0, 0.0, 0.5), (1.0, 1.0, 0.6)), joint=joint, scale=scale)
    assert least <= gap(robot, 0, 1) <= 3.0 * least


def test_parts_that_are_apart_stay_as_they_are() -> None:
    robot = robot_with(((0.0, 0.0, 0.6), (1.0, 1.0, 0.62)), joint=Joint(JointKind.PRISMATIC, Z, np.zeros(3), 0.0, 0.4))
    (door,) = boxes(robot, 1)
    assert np.sort(2.0 * door.half_extents) == pytest.approx([0.02, 1.0, 1.0])


def test_a_part_that_brushes_past_another_on_its_way_is_cut() -> None:
    drawer = ((0.0, 0.0, 0.6), (0.5, 1.0, 0.9))
    stop = ((0.495, 0.0, 1.0), (0.6, 1.0, 1.1))
    slides = Joint(JointKind.PRISMATIC, Z, np.zeros(3), 0.0, 0.4)
    bodies = [Body(0, "carcass", (1, 3)), Body(1, "drawer", (2,), 0, slides)]
    shape = shape_of_boxes([CARCASS, drawer, stop], bodies)
    robot = build_robot(shape, shape.mobility, collision="convex")
    (moved,) = boxes(robot, 1)
    stops = boxes(robot, 0)[-1]
    assert gap_along(moved, stops, 1) >= 0.99 * GAP * robot.diagonal


def gap_along(one: Box, other: Box, axis: int) -> float:
    """Gap between two boxes along an axis of the robot."""
    a, b = one.corners()[:, axis], other.corners()[:, axis]
    return float(max(b.min() - a.max(), a.min() - b.max()))


def test_a_part_inside_another_is_dropped() -> None:
    robot = robot_with(((0.4, 0.4, 0.2), (0.6, 0.6, 0.3)), joint=Joint(JointKind.REVOLUTE, Y, np.zeros(3), 0.0, 1.0))
    assert not robot.links[1].collisions
    assert len(robot.links[0].collisions) == 1


def test_parts_of_one_link_may_overlap() -> None:
    bodies = [
        Body(0, "carcass", (1,)),
        Body(1, "door", (2, 3), 0, Joint(JointKind.REVOLUTE, Y, np.array([0, 0, 0.6]), -1.5, 0.0)),
    ]
    door, knob = ((0.0, 0.0, 0.6), (1.0, 1.0, 0.62)), ((0.9, 0.5, 0.61), (0.95, 0.55, 0.66))
    shape = shape_of_boxes([CARCASS, door, knob], bodies)
    robot = build_robot(shape, shape.mobility, collision="convex")
    assert [np.prod(box.half_extents) for box in boxes(robot, 1)] == pytest.approx([0.5 * 0.5 * 0.01, 0.025**3])


@pytest.mark.parametrize("depth", [1e-6, 1e-4, 0.01])
def test_cut_shapes_have_a_thickness(depth: float) -> None:
    piece = _Piece.of(0, Collision("box", 0, Box(np.zeros(3), np.eye(3), np.array([0.5, 0.3, 0.1]))))
    piece.cut(np.array([0.0, 0.0, 1.0]), 0.1 - depth)
    shape = piece.shape
    assert shape is not None
    thickness = 2.0 * shape.half_extents.min() if isinstance(shape, Box) else np.ptp(shape.mesh.vertices, axis=0).min()
    assert depth <= thickness <= depth + 0.0011


def test_many_small_cuts_leave_most_of_a_shape() -> None:
    """A button with a range of metres instead of millimetres must not plane its panel away."""
    panel, button = ((0.0, 0.0, 0.0), (1.0, 1.0, 0.5)), ((0.4, 0.4, 0.5), (0.6, 0.6, 0.52))
    bodies = [Body(0, "panel", (1,)), Body(1, "button", (2,), 0, Joint(JointKind.PRISMATIC, -Z, np.zeros(3), 0.0, 3.0))]
    shape = shape_of_boxes([panel, button], bodies)
    robot = build_robot(shape, shape.mobility, collision="convex")
    (left,) = boxes(robot, 0)
    assert left.volume > 0.7 * 0.5
