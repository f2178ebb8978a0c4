"""Facts that the user states: what they change, and what they leave."""

from __future__ import annotations

from pathlib import Path

import pytest

import kinmo
from kinmo.core.frames import AXIS_VECTORS, Axis
from kinmo.core.shape import Shape

LINK = '<link name="{0}"><visual><geometry><box size="1 1 {1}"/></geometry></visual></link>'


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.urdf"
    fixed = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
    path.write_text(f'<robot name="r">{LINK.format("a", 1)}{LINK.format("b", 2)}{fixed}</robot>')
    return path


def frame(shape: Shape) -> tuple[object, object]:
    return shape.up, shape.front


def test_the_up_direction_of_a_robot_may_be_stated_without_a_change(robot: Path) -> None:
    stated = kinmo.load(robot, up="z")
    assert frame(stated) == frame(kinmo.load(robot)) == (AXIS_VECTORS["z"], AXIS_VECTORS["-x"])
    assert "up" not in stated.guesses


@pytest.mark.parametrize(("up", "front"), [("y", "z"), ("x", None), ("-z", None)])
def test_another_up_direction_of_a_robot_has_its_usual_front(robot: Path, up: Axis, front: Axis | None) -> None:
    assert frame(kinmo.load(robot, up=up)) == (AXIS_VECTORS[up], None if front is None else AXIS_VECTORS[front])


def test_a_stated_front_holds_with_the_up_direction_of_the_file(robot: Path) -> None:
    assert frame(kinmo.load(robot, up="z", front="y")) == (AXIS_VECTORS["z"], AXIS_VECTORS["y"])
    with pytest.raises(kinmo.InputError, match="--front: z is not perpendicular to the up direction"):
        kinmo.load(robot, up="z", front="z")
