"""Joints of a prediction are lines of text."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from kinmo.core.joint import Joint, JointKind, joint_to_data
from kinmo.core.shape_estimate import OVERRIDE
from kinmo.pipeline.joint_lines import joint_lines

SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.255)
HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3), 0.0, np.pi / 2)
WHEEL = Joint(JointKind.REVOLUTE, np.array([1.0, 0.0, 0.0]), np.zeros(3))


def document_with(joint: Joint, metres_per_unit: float = 1.0, score: float = 0.85, source: str = "ranking") -> dict[str, Any]:
    estimates = [{"score": score, "source": source}]
    bodies = [{"id": 1, "name": "part", "joint": joint_to_data(joint), "estimates": estimates}]
    return {"shape": {"metres_per_unit": metres_per_unit}, "bodies": bodies}


@pytest.mark.parametrize(("metres_per_unit", "extent"), [(1.0, "0 to 0.255 m"), (0.01, "0 to 0.255 units (0 to 0.00255 m)")])
def test_lengths_have_units(metres_per_unit: float, extent: str) -> None:
    assert joint_lines(document_with(SLIDE, metres_per_unit)) == [f"  part: slider, {extent}, score 0.85"]


def test_angles_are_in_degrees_for_all_units() -> None:
    assert joint_lines(document_with(HINGE, 0.01)) == ["  part: hinge, 0 to 90°, score 0.85"]


def test_a_wheel_has_no_limits() -> None:
    assert joint_lines(document_with(WHEEL)) == ["  part: hinge, without limits, score 0.85"]


def test_low_scores_and_corrections_are_marked() -> None:
    assert joint_lines(document_with(HINGE, score=0.2)) == ["  part: hinge, 0 to 90°, score 0.20, uncertain"]
    assert joint_lines(document_with(HINGE, source=OVERRIDE)) == ["  part: hinge, 0 to 90°, corrected by hand"]
