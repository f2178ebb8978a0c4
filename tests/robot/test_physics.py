"""Densities, and damping and friction against gravity."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from articulated import shape_of_boxes

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.io.writers import ExportOptions, export
from kinmo.robot.physics import DECAY, GRAVITY, HOLD, MAX_FALL, MIN_FRICTION, Physics
from kinmo.robot.robot import Robot
from kinmo.robot.robot_builder import build_robot

CARCASS = ((0.0, 0.0, 0.0), (1.0, 1.0, 0.5))
LID = ((0.0, 1.1, 0.0), (1.0, 1.2, 0.5))
X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
HINGE = Joint(JointKind.REVOLUTE, X, np.array([0.0, 1.1, 0.0]), -1.5, 1.5)


def shape_with(joint: Joint):
    """A carcass with a lid above it. Up is y."""
    return shape_of_boxes([CARCASS, LID], [Body(0, "carcass", (1,)), Body(1, "lid", (2,), 0, joint)])


def robot_with(joint: Joint, physics: Physics) -> Robot:
    shape = shape_with(joint)
    return build_robot(shape, shape.mobility, physics=physics)


@pytest.mark.parametrize(
    ("constants", "problem"),
    [
        ({"density": 0.0}, "physics: density: expected a positive number, got 0.0"),
        ({"part_densities": {"lid": math.nan}}, "physics: part_densities.lid: expected a positive number, got nan"),
        ({"friction": -0.1}, "physics: friction: expected a finite number of at least 0, got -0.1"),
        ({"velocity": math.inf}, "physics: velocity: expected a finite number of at least 0, got inf"),
    ],
)
def test_constants_that_no_simulator_bears_are_refused(constants: dict[str, Any], problem: str) -> None:
    with pytest.raises(InputError) as caught:
        Physics(**constants)
    assert str(caught.value) == problem


@pytest.mark.parametrize("joint", [HINGE, Joint(JointKind.PRISMATIC, Y, np.zeros(3), -0.05, 3.0)], ids=["hinge", "slider"])
def test_parts_fall_slowly_in_mujoco(tmp_path, joint: Joint) -> None:
    mujoco = pytest.importorskip("mujoco")
    shape = shape_with(joint)
    path = export(
        shape, shape.mobility, tmp_path / "out", ["mjcf"], ExportOptions(collision="none", physics=Physics(density=900.0))
    )
    model = mujoco.MjModel.from_xml_path(str(path["mjcf"]))
    data = mujoco.MjData(model)
    reach = 1.0 if joint.kind is JointKind.PRISMATIC else float(np.hypot(0.1, 0.5))
    data.qpos[0] = 0.5 if joint.kind is JointKind.REVOLUTE else 3.0
    speeds = []
    for _ in range(400):
        mujoco.mj_step(model, data)
        speeds.append(abs(float(data.qvel[0])) * reach)
    assert 0.1 * MAX_FALL < max(speeds) <= 1.01 * MAX_FALL


def test_motion_without_gravity_dies_out() -> None:
    drawer = robot_with(Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.4), Physics())
    assert drawer.joints[0].damping == pytest.approx(DECAY * drawer.links[1].inertial.mass)
    door = robot_with(Joint(JointKind.REVOLUTE, Y, np.zeros(3), 0.0, 1.5), Physics())
    mass = door.links[1].inertial.mass
    assert door.joints[0].damping == pytest.approx(DECAY * mass * (1.0**2 + 0.5**2) / 3.0)


def test_stated_damping_counts() -> None:
    (found,) = robot_with(HINGE, Physics(damping=0.7)).joints
    assert found.damping == 0.7


def button_with(physics: Physics, upright: np.ndarray = Y) -> Robot:
    """A case with a light button on it that is pressed along `upright`."""
    boxes = [CARCASS, ((0.4, 1.0, 0.2), (0.5, 1.02, 0.3))]
    press = Joint(JointKind.PRISMATIC, upright, np.zeros(3), -0.004, 0.0)
    shape = shape_of_boxes(boxes, [Body(0, "case", (1,)), Body(1, "button", (2,), 0, press)])
    return build_robot(shape, shape.mobility, physics=physics)


def test_friction_holds_light_parts() -> None:
    button = button_with(Physics())
    weight = GRAVITY * button.links[1].inertial.mass
    assert button.joints[0].friction == pytest.approx(HOLD * weight)
    assert button_with(Physics(), X).joints[0].friction == MIN_FRICTION, "a level slider needs no more"


@pytest.mark.parametrize(("axis", "share"), [(X, 1.0), (Y, 0.0)], ids=["tilts", "turns upright"])
def test_friction_holds_level_buttons_on_parts_that_tilt(axis: np.ndarray, share: float) -> None:
    boxes = [CARCASS, LID, ((0.4, 1.12, 0.5), (0.5, 1.18, 0.52))]
    press = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), -0.004, 0.0)
    hinge = Joint(JointKind.REVOLUTE, axis, np.array([0.0, 1.1, 0.0]), -1.5, 1.5)
    shape = shape_of_boxes(boxes, [Body(0, "case", (1,)), Body(1, "lid", (2,), 0, hinge), Body(2, "button", (3,), 1, press)])
    robot = build_robot(shape, shape.mobility)
    weight = GRAVITY * robot.links[2].inertial.mass
    assert robot.joints[1].friction == pytest.approx(max(MIN_FRICTION, share * HOLD * weight))


def test_friction_does_not_hold_a_heavy_lid() -> None:
    rim = float(np.hypot(0.1, 0.5))
    assert robot_with(HINGE, Physics()).joints[0].friction == pytest.approx(MIN_FRICTION * rim)


def test_friction_holds_the_largest_moment_of_a_knob() -> None:
    boxes = [CARCASS, ((0.4, 0.5, 0.5), (0.44, 0.54, 0.52))]
    knob = Joint(JointKind.REVOLUTE, np.array([0.0, 0.0, 1.0]), np.array([0.4, 0.52, 0.5]), None, None)
    shape = shape_of_boxes(boxes, [Body(0, "stove", (1,)), Body(1, "knob", (2,), 0, knob)])
    robot = build_robot(shape, shape.mobility, physics=Physics(density=2000.0))
    mass = robot.links[1].inertial.mass
    assert robot.joints[0].friction == pytest.approx(HOLD * GRAVITY * mass * 0.02)
    light = build_robot(shape, shape.mobility)
    assert light.joints[0].friction == pytest.approx(MIN_FRICTION * np.hypot(0.04, 0.02)), "it does not spin on"


def test_stated_friction_counts() -> None:
    assert robot_with(HINGE, Physics(friction=0.3)).joints[0].friction == 0.3
    assert button_with(Physics(friction=0.0)).joints[0].friction == 0.0


def test_a_part_may_have_another_density() -> None:
    light, heavy = (
        robot_with(HINGE, Physics(part_densities=densities)).links[1].inertial for densities in ({}, {"part 1": 700.0})
    )
    assert heavy.mass == pytest.approx(7.0 * light.mass)
    assert heavy.center == pytest.approx(light.center)
