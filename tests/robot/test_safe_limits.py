"""Limits that stop before another part."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.robot.robot import Robot
from kinmo.robot.robot_builder import build_robot
from kinmo.robot.safe_limits import stop_notes, with_safe_limits

BASE, FRONT = ((0.0, 0.0, 0.0), (1.0, 1.0, 0.5)), ((0.0, 0.0, 0.5), (1.0, 1.0, 0.52))
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.6)


def robot_with(joint: Joint, *walls: tuple[tuple[float, float, float], tuple[float, float, float]]) -> Robot:
    """A box, a front before it that moves, and walls that belong to the box."""
    bodies = [Body(0, "base", (1, *range(3, 3 + len(walls)))), Body(1, "front", (2,), 0, joint)]
    shape = shape_of_boxes([BASE, FRONT, *walls], bodies)
    return build_robot(shape, shape.mobility)


def test_a_drawer_stops_before_a_wall() -> None:
    robot = robot_with(SLIDE, ((0.0, 0.0, 0.9), (1.0, 1.0, 1.0)))
    safe = with_safe_limits(robot)
    assert safe.joints[0].lower == 0.0
    assert safe.joints[0].upper == pytest.approx(0.38, abs=0.03)
    stop = f"front_joint stops at 0 and {1000 * safe.joints[0].upper:.0f} mm instead of 0 and 600"
    assert stop_notes(robot.joints, safe.joints) == (f"{stop}: it hits a part or leaves its place beyond",)


def test_a_door_stops_before_a_wall() -> None:
    hinge = Joint(JointKind.REVOLUTE, np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 0.52]), 0.0, 3.0)
    safe = with_safe_limits(robot_with(hinge, ((-0.7, 0.0, 0.6), (-0.65, 1.0, 1.5))))
    assert np.pi / 2 < safe.joints[0].upper < 3.0


def test_a_free_way_keeps_its_limits() -> None:
    robot = robot_with(SLIDE, ((0.0, 0.0, 1.5), (1.0, 1.0, 1.6)))
    safe = with_safe_limits(robot)
    assert (safe.joints[0].lower, safe.joints[0].upper) == (robot.joints[0].lower, robot.joints[0].upper)
    assert stop_notes(robot.joints, safe.joints) == ()


def test_parts_that_touch_at_rest_do_not_stop_it() -> None:
    inwards = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), -0.3, 0.1)
    safe = with_safe_limits(robot_with(inwards))
    assert safe.joints[0].lower == pytest.approx(-0.3)


def test_a_way_that_is_blocked_from_the_start_keeps_its_limit() -> None:
    safe = with_safe_limits(robot_with(SLIDE, ((0.0, 0.0, 0.55), (1.0, 1.0, 0.6))))
    assert safe.joints[0].upper == pytest.approx(0.6)


@pytest.mark.parametrize(("travel", "upper"), [(0.3, 0.3), (0.9, 0.45)])
def test_a_drawer_keeps_an_overlap(travel: float, upper: float) -> None:
    """The drawer is 0.5 long and inside a case of the same length."""
    case = [((0.0, 0.0, 0.0), (0.02, 1.0, 0.5)), ((0.98, 0.0, 0.0), (1.0, 1.0, 0.5)), ((0.0, 0.0, 0.0), (1.0, 1.0, 0.01))]
    drawer = ((0.1, 0.1, 0.02), (0.9, 0.9, 0.5))
    joint = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, travel)
    shape = shape_of_boxes([*case, drawer], [Body(0, "case", (1, 2, 3)), Body(1, "drawer", (4,), 0, joint)])
    safe = with_safe_limits(build_robot(shape, shape.mobility))
    assert safe.joints[0].upper == pytest.approx(upper, abs=0.02)
    assert safe.joints[0].lower == 0.0


def test_a_lid_may_leave_its_box() -> None:
    lid = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 2.0)
    assert with_safe_limits(robot_with(lid)).joints[0].upper == pytest.approx(2.0)
