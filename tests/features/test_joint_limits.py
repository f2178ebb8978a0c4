"""Joint limits of candidate joints, from collision-free travel and typical ranges."""

from __future__ import annotations

import math

import numpy as np
import pytest
from small_shapes import box_mesh, box_surface

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.joint_limits import MAX_HINGE_ANGLE, SLIDE_RANGE, estimate_joint_limits


def meshes(*boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> _core.Meshes:
    """Meshes of boxes (centre, half extents)."""
    made = [box_mesh(np.array(center), np.array(half)) for center, half in boxes]
    return _core.Meshes([mesh.vertices for mesh in made], [mesh.faces for mesh in made])


def candidate(kind: JointKind, direction, pivot) -> CandidateJoints:
    """One candidate joint."""
    return CandidateJoints.of([Joint(kind, np.array(direction, float), np.array(pivot, float))], ["test"])


DOOR, WALL = ((0.0, 0.0, 0.03), (0.3, 0.4, 0.01)), ((0.0, 0.0, -0.2), (0.3, 0.4, 0.2))
DOOR_POINTS = box_surface(np.zeros(3), np.array(DOOR[1]), 200, np.random.default_rng(0))[0]


def test_a_door_opens_one_way() -> None:
    hinge = candidate(JointKind.REVOLUTE, (0, 1, 0), (0.3, 0, 0.04))
    limits = estimate_joint_limits(meshes(DOOR, WALL), [0], [1], hinge, DOOR_POINTS)
    lower, upper = limits.range(0)
    assert sorted([abs(lower), abs(upper)])[0] < math.radians(20)
    assert sorted([abs(lower), abs(upper)])[1] == pytest.approx(MAX_HINGE_ANGLE)
    assert limits.freedom[0] == 1.0


def test_a_wheel_without_obstacles_has_no_limits() -> None:
    limits = estimate_joint_limits(meshes(DOOR), [0], [], candidate(JointKind.REVOLUTE, (0, 0, 1), (0, 0, 0)), DOOR_POINTS)
    assert limits.range(0) == (None, None)


def test_a_door_without_obstacles_opens_to_a_right_angle() -> None:
    limits = estimate_joint_limits(meshes(DOOR), [0], [], candidate(JointKind.REVOLUTE, (0, 1, 0), (0.3, 0, 0)), DOOR_POINTS)
    assert limits.range(0) == pytest.approx((-MAX_HINGE_ANGLE, MAX_HINGE_ANGLE))


def test_a_drawer_opens_to_the_free_side() -> None:
    drawer, body = ((0.0, 0.0, 0.1), (0.2, 0.1, 0.2)), ((0.0, 0.0, -0.2), (0.3, 0.4, 0.1))
    points = box_surface(np.array(drawer[0]), np.array(drawer[1]), 400, np.random.default_rng(0))[0]
    for sign in (1, -1):
        slide = candidate(JointKind.PRISMATIC, (0, 0, sign), (0, 0, 0))
        lower, upper = estimate_joint_limits(meshes(drawer, body), [0], [1], slide, points).range(0)
        travel = sign * SLIDE_RANGE * 0.4
        assert (lower, upper) == pytest.approx((min(0, travel), max(0, travel)), rel=0.02)


def test_a_button_is_pressed_into_its_panel() -> None:
    button, panel = ((0.0, 0.0, 0.02), (0.02, 0.02, 0.01)), ((0.0, 0.0, -0.09), (0.3, 0.4, 0.1))
    points = box_surface(np.array(button[0]), np.array(button[1]), 400, np.random.default_rng(0))[0]
    slide = candidate(JointKind.PRISMATIC, (0, 0, 1), (0, 0, 0))
    lower, upper = estimate_joint_limits(meshes(button, panel), [0], [1], slide, points).range(0)
    assert (lower, upper) == pytest.approx((-SLIDE_RANGE * 0.02, 0.0), rel=0.02)


def test_a_part_enclosed_on_all_sides_is_not_free() -> None:
    inside = ((0.0, 0.0, 0.0), (0.1, 0.1, 0.1))
    walls = [((0.0, 0.0, s * 0.15), (0.2, 0.2, 0.04)) for s in (-1, 1)]
    points = box_surface(np.zeros(3), np.array(inside[1]), 200, np.random.default_rng(0))[0]
    slide = candidate(JointKind.PRISMATIC, (0, 0, 1), (0, 0, 0))
    assert estimate_joint_limits(meshes(inside, *walls), [0], [1, 2], slide, points).freedom[0] < 0.5
