from __future__ import annotations

import math

import numpy as np
import pytest
from small_shapes import box_mesh, box_surface

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.features.candidate_joints import Candidates
from kinmo.features.free_travel import MOST_TURN, SLIDE, free_travel


def meshes(*boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> _core.Meshes:
    made = [box_mesh(np.array(center), np.array(half)) for center, half in boxes]
    return _core.Meshes([mesh.vertices for mesh in made], [mesh.faces for mesh in made])


def one(kind: JointKind, direction, pivot) -> Candidates:
    return Candidates(np.array([kind.code], np.uint8), np.array([direction], float), np.array([pivot], float), ("test",))


DOOR, WALL = ((0.0, 0.0, 0.03), (0.3, 0.4, 0.01)), ((0.0, 0.0, -0.2), (0.3, 0.4, 0.2))
DOOR_POINTS = box_surface(np.zeros(3), np.array(DOOR[1]), 200, np.random.default_rng(0))[0]


def test_a_door_opens_one_way() -> None:
    travel = free_travel(meshes(DOOR, WALL), [0], [1], one(JointKind.REVOLUTE, (0, 1, 0), (0.3, 0, 0.04)), DOOR_POINTS)
    lower, upper = travel.range(0)
    assert sorted([abs(lower), abs(upper)])[0] < math.radians(20)
    assert sorted([abs(lower), abs(upper)])[1] == pytest.approx(MOST_TURN)
    assert travel.freedom[0] == 1.0


def test_a_wheel_in_the_open_has_no_limit() -> None:
    travel = free_travel(meshes(DOOR), [0], [], one(JointKind.REVOLUTE, (0, 0, 1), (0, 0, 0)), DOOR_POINTS)
    assert travel.range(0) == (None, None)


def test_a_door_that_nothing_stops_opens_to_a_right_angle() -> None:
    travel = free_travel(meshes(DOOR), [0], [], one(JointKind.REVOLUTE, (0, 1, 0), (0.3, 0, 0)), DOOR_POINTS)
    assert travel.range(0) == pytest.approx((-MOST_TURN, MOST_TURN))


def test_a_drawer_comes_out_on_the_side_that_is_free() -> None:
    drawer, body = ((0.0, 0.0, 0.1), (0.2, 0.1, 0.2)), ((0.0, 0.0, -0.2), (0.3, 0.4, 0.1))
    points = box_surface(np.array(drawer[0]), np.array(drawer[1]), 400, np.random.default_rng(0))[0]
    for sign in (1, -1):
        slide = one(JointKind.PRISMATIC, (0, 0, sign), (0, 0, 0))
        lower, upper = free_travel(meshes(drawer, body), [0], [1], slide, points).range(0)
        assert (lower, upper) == pytest.approx((min(0, sign * SLIDE * 0.4), max(0, sign * SLIDE * 0.4)), rel=0.02)


def test_a_button_is_pressed_into_what_it_is_on() -> None:
    button, panel = ((0.0, 0.0, 0.02), (0.02, 0.02, 0.01)), ((0.0, 0.0, -0.09), (0.3, 0.4, 0.1))
    points = box_surface(np.array(button[0]), np.array(button[1]), 400, np.random.default_rng(0))[0]
    slide = one(JointKind.PRISMATIC, (0, 0, 1), (0, 0, 0))
    lower, upper = free_travel(meshes(button, panel), [0], [1], slide, points).range(0)
    assert (lower, upper) == pytest.approx((-SLIDE * 0.02, 0.0), rel=0.02)


def test_a_part_shut_in_on_all_sides_is_not_free() -> None:
    inside = ((0.0, 0.0, 0.0), (0.1, 0.1, 0.1))
    walls = [((0.0, 0.0, s * 0.15), (0.2, 0.2, 0.04)) for s in (-1, 1)]
    points = box_surface(np.zeros(3), np.array(inside[1]), 200, np.random.default_rng(0))[0]
    travel = free_travel(meshes(inside, *walls), [0], [1, 2], one(JointKind.PRISMATIC, (0, 0, 1), (0, 0, 0)), points)
    assert travel.freedom[0] < 0.5
