"""Criteria of the tests in simulators."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from kinmo.evaluation.simulation.object_check import check_object, drive_problem, kinematics_problems, rest_problems
from kinmo.evaluation.simulation.simulator import RestRecord, SimulatedJoint

DOOR = SimulatedJoint("door_joint", True, (0.0, 2.0))
STILL = RestRecord(np.zeros(1), np.zeros(1), 0.0, 0.0, True)


@dataclass
class Slider:
    """A simulator with one link that slides along x, and stops at a wall."""

    wall: float = 10.0
    scale: float = 1.0
    joints: tuple[SimulatedJoint, ...] = (SimulatedJoint("slide", False, (0.0, 1.0)),)

    def link_poses(self, values):
        pose = np.eye(4)
        pose[0, 3] = self.scale * values[0]
        return {"box": pose}

    def rest(self, seconds):
        return STILL

    def drive(self, joint, targets, seconds):
        return min(targets), min(self.wall, max(targets))


def sliding(values):
    pose = np.eye(4)
    pose[0, 3] = values["slide"]
    return {"box": pose}


def test_a_good_object_works() -> None:
    check = check_object("Slider", Slider(), sliding, 1.0)
    assert check.works and check.problems == ()


@pytest.mark.parametrize(
    ("record", "problem"),
    [
        (replace(STILL, values=np.array([0.1])), "does not rest: door_joint moves by 5.7 degrees"),
        (replace(STILL, values=np.array([-0.1]), gravity=np.array([1.0])), "does not rest: door_joint moves by -5.7 degrees"),
        (replace(STILL, fastest=1.5), "does not rest: a link reaches 1.5 m/s"),
        (replace(STILL, penetration=0.01), "does not rest: two links overlap by 10.0 mm"),
        (replace(STILL, is_finite=False), "does not rest: the simulation diverges"),
    ],
)
def test_what_moves_by_itself_does_not_rest(record: RestRecord, problem: str) -> None:
    assert rest_problems([DOOR], record, 2.0) == [problem]


def test_small_motion_and_what_gravity_opens_is_rest() -> None:
    assert rest_problems([DOOR], replace(STILL, values=np.array([0.039])), 2.0) == []
    assert rest_problems([DOOR], replace(STILL, values=np.array([1.5]), gravity=np.array([3.0])), 2.0) == []


@pytest.mark.parametrize(("wall", "problem"), [(0.96, ""), (0.5, "does not move: slide reaches 50 % of its range")])
def test_a_wall_in_the_range_is_reported(wall: float, problem: str) -> None:
    assert drive_problem(Slider(wall), 0) == problem


def test_other_kinematics_do_not_agree() -> None:
    assert kinematics_problems(Slider(), sliding) == []
    (problem,) = kinematics_problems(Slider(scale=1.001), sliding)
    assert problem.startswith("does not agree: box is off by")


def test_links_that_are_not_expected_do_not_agree() -> None:
    assert kinematics_problems(Slider(), lambda values: {})[0].startswith("does not agree: joints.json has no link box")
