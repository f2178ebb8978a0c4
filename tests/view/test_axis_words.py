"""Words for joints: sides are those of the viewer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinmo.core.joint import Joint, JointKind
from kinmo.view.axis_words import joint_words

X, Y, Z = np.eye(3)
BOUNDS = np.array([-1.0, -1.0, -0.1]), np.array([1.0, 1.0, 0.1])


def words(kind: JointKind, axis: np.ndarray, pivot: list[float]) -> str:
    return joint_words(Joint(kind, np.asarray(axis, float), np.array(pivot, float)), BOUNDS, Y, Z)


@pytest.mark.parametrize(
    ("kind", "axis", "pivot", "expected"),
    [
        (JointKind.REVOLUTE, Y, [-1.0, 5.0, 0.0], "hinge, vertical, left edge"),
        (JointKind.REVOLUTE, -Y, [1.0, 0.0, 0.1], "hinge, vertical, right edge"),
        (JointKind.REVOLUTE, X, [9.0, -1.0, 0.0], "hinge, horizontal, bottom edge"),
        (JointKind.REVOLUTE, Z, [0.1, 0.1, 7.0], "hinge, horizontal, centre"),
        (JointKind.REVOLUTE, Z, [1.0, 1.0, 0.0], "hinge, horizontal, top right edge"),
        (JointKind.REVOLUTE, (X + Y) / np.sqrt(2), [0.0, 0.0, 0.0], "hinge, oblique, centre"),
        (JointKind.PRISMATIC, Z, [3.0, 3.0, 3.0], "slider, to the front"),
        (JointKind.PRISMATIC, -X, [0.0, 0.0, 0.0], "slider, to the left"),
        (JointKind.PRISMATIC, Y, [0.0, 0.0, 0.0], "slider, upwards"),
        (JointKind.SCREW, Y, [0.0, 0.0, 0.0], "screw, vertical, centre"),
    ],
)
def test_kind_direction_and_side_are_named(kind: JointKind, axis: np.ndarray, pivot: list[float], expected: str) -> None:
    assert words(kind, axis, pivot) == expected


@pytest.mark.parametrize("seed", range(5))
def test_a_turned_object_has_the_same_words(seed: int) -> None:
    turn = Rotation.random(random_state=seed).as_matrix()
    cube = np.full(3, -1.0), np.full(3, 1.0)
    joint = Joint(JointKind.REVOLUTE, Y, np.array([-1.0, 0.0, 0.0]))
    told = joint_words(joint, cube, Y, Z)
    assert joint_words(joint.rotated(turn), cube, turn @ Y, turn @ Z) == told == "hinge, vertical, left edge"


def test_without_a_front_sides_are_named_after_axes() -> None:
    joint = Joint(JointKind.REVOLUTE, Y, np.array([-1.0, 0.0, 0.0]))
    assert joint_words(joint, BOUNDS, Y, None) == "hinge, vertical, x- edge"
