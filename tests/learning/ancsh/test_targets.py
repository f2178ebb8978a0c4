"""What networks are to say of the surroundings of joints."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.joint import Joint, JointKind
from kinmo.learning.ancsh.targets import REACH, layout, surroundings
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import ScanFile

UP, AHEAD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
STRUCTURE = Structure((JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.PRISMATIC), (0, 0, 0))
JOINTS = (
    Joint(JointKind.REVOLUTE, UP, np.zeros(3)),
    Joint(JointKind.REVOLUTE, UP, np.array([0.1, 0.0, 0.0])),
    Joint(JointKind.PRISMATIC, AHEAD, np.array([0.5, 0.5, 0.0])),
)
PLACES = np.array([[0.02, 0.3, 0.0], [0.02, 0.3, 0.0], [0.5, 0.5, 0.1], [0.9, 0.9, 0.0]])
PARTS = np.array([0, 1, 3, 3])


def test_a_point_near_to_two_hinges_tells_of_the_nearest_and_in_the_release_of_the_last() -> None:
    nearest = surroundings(PLACES, PARTS, JOINTS, STRUCTURE)
    release = surroundings(PLACES, PARTS, JOINTS, STRUCTURE, nearest=False, lines_only=True)
    assert nearest.joints.tolist() == [1, 1, 3, 3]
    assert release.joints.tolist() == [2, 1, 3, 0], "of the base the last; on door 1 only its own; of the drawer what is near"
    assert nearest.heatmap[0] == pytest.approx(1.0 - 0.02 / REACH)
    assert release.heatmap[0] == pytest.approx(1.0 - 0.08 / REACH)
    np.testing.assert_allclose(nearest.toward[0], [-1.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(release.toward[0], [1.0, 0.0, 0.0], atol=1e-6)


def test_a_slider_is_told_of_by_all_of_its_part_and_has_a_place_in_the_release_alone() -> None:
    found = surroundings(PLACES, PARTS, JOINTS, STRUCTURE)
    assert found.has_pivot.tolist() == [True, True, False, False]
    assert found.heatmap[2:].tolist() == [0.0, 0.0]
    np.testing.assert_array_equal(found.axes[2:], [AHEAD, AHEAD])
    release = surroundings(PLACES, PARTS, JOINTS, STRUCTURE, nearest=False, lines_only=True)
    assert release.has_pivot.tolist() == [True, True, True, False]
    assert release.heatmap[2] == pytest.approx(1.0), "on the line through its stored origin"


def test_a_layout_has_boxes_of_diagonal_one_and_the_pivots_next_to_the_parts_that_move(file: ScanFile) -> None:
    half_sizes, pivots, is_line = layout(file.extents, file.joints)
    np.testing.assert_allclose(np.linalg.norm(half_sizes, axis=1), 0.5, atol=1e-3)
    assert is_line.tolist() == [joint.has_pivot for joint in file.joints]
    for joint, pivot, middle in zip(file.joints, pivots - 0.5, file.extents.centers[1:], strict=True):
        np.testing.assert_allclose(np.cross(pivot - joint.pivot, joint.direction), 0.0, atol=1e-6)
        assert (middle - pivot) @ joint.direction == pytest.approx(0.0, abs=1e-6)
