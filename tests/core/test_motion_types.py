"""Motion types of joints."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.core.joint import Joint, JointKind
from kinmo.core.motion_types import CoarseType, MotionType, motion_type
from kinmo.core.oriented_box import Box

UP = np.array([0.0, 1.0, 0.0])
PANEL = Box(np.zeros(3), np.eye(3), np.array([0.3, 0.5, 0.02]))


@pytest.mark.parametrize(
    ("kind", "direction", "pivot", "expected"),
    [
        (JointKind.REVOLUTE, (0, 1, 0), (0.3, 0, 0), "R_V_S"),
        (JointKind.REVOLUTE, (0, 1, 0), (0.01, 0, 0), "R_V_C"),
        (JointKind.REVOLUTE, (1, 0, 0), (0, -0.5, 0), "R_H_S"),
        (JointKind.REVOLUTE, (0, 0, 1), (0, 0, 0), "R_H_C"),
        (JointKind.PRISMATIC, (0, 0, 1), (9, 9, 9), "P_H"),
        (JointKind.PRISMATIC, (0, -1, 0), (0, 0, 0), "P_V"),
        (JointKind.SCREW, (0, 1, 0), (0, 0, 0), "PR_V"),
        (JointKind.SCREW, (1, 0, 0), (0.3, 0, 0), "PR_H"),
    ],
)
def test_a_fine_type_has_the_kind_direction_and_position_of_the_axis(
    kind: JointKind, direction: tuple[float, ...], pivot: tuple[float, ...], expected: str
) -> None:
    joint = Joint(kind, np.array(direction, float), np.array(pivot, float))
    assert motion_type(joint, PANEL, UP) is MotionType[expected]
    assert motion_type(joint.reversed(), PANEL, UP) is MotionType[expected]
    assert MotionType[expected].coarse is CoarseType[kind.value]
    assert MotionType[expected].kind is kind


def test_edges_without_motion_have_no_joint_kind() -> None:
    for types in (MotionType, CoarseType):
        assert types.FIXED.kind is types.NONE.kind is None
