"""The bench of exports in simulators."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import shape_of_boxes

import simulate
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.pipeline.result_check import FileCheck

SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.8)
BASE, FRONT, WALL = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((0.0, 0.0, 1.0), (1.0, 1.0, 1.1)), ((0.0, 0.0, 1.5), (1.0, 1.0, 1.6))


def shape_with(*obstacles):
    """A box whose front slides away from it, and obstacles that belong to the box."""
    bodies = [Body(0, "base", (1, *range(3, 3 + len(obstacles)))), Body(1, "front", (2,), 0, SLIDE)]
    return shape_of_boxes([BASE, FRONT, *obstacles], bodies)


@pytest.mark.parametrize(("limit", "hits"), [(0.3, False), (0.8, True)])
def test_a_way_into_a_wall_is_not_safe(limit: float, hits: bool) -> None:
    shape = shape_with(WALL)
    (share,) = simulate.swept_shares(shape, shape.mobility, {"front_joint": (0.0, limit)})
    assert (share > simulate.MAX_SHARE) == hits


def test_parts_that_touch_at_rest_do_not_count() -> None:
    shape = shape_with()
    assert simulate.swept_shares(shape, shape.mobility, {"front_joint": (-0.5, 0.0)}) == []


def test_joints_without_limits_do_not_count() -> None:
    shape = shape_with(WALL)
    assert simulate.swept_shares(shape, shape.mobility, {}) == []


def test_rows_have_shares_of_objects() -> None:
    good = FileCheck("urdf", "mujoco", True, True, True, True)
    bad = FileCheck("urdf", "mujoco", True, False, True, True, ("does not rest",))
    rows = simulate.rows_of("predicted", {"a": ([good], []), "b": ([bad], [])})
    assert rows == [["predicted", "URDF in MuJoCo", 2, 1.0, 0.5, 1.0, 1.0, 0.5]]


def test_annotated_joints_are_certain() -> None:
    shape = shape_with()
    estimate = simulate._certain(shape, shape.mobility)
    assert [ranked[0].score for ranked in estimate.estimates] == [1.0, 1.0]
    assert estimate.mobility is shape.mobility
