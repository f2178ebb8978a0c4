"""Training targets of ANCSH: joints near points, and sizes of boxes."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.core.joint import Joint, JointKind
from kinmo.core.vector import Vector
from kinmo.scans.ancsh.ancsh_targets import JOINT_RADIUS, JointAxes, global_targets, joint_targets
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.object_structure import Extents, Structure

UP, AHEAD = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
STRUCTURE = Structure((JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.PRISMATIC), (0, 0, 0))
AXES = JointAxes.of(
    [
        [
            Joint(JointKind.REVOLUTE, UP, np.zeros(3)),
            Joint(JointKind.REVOLUTE, UP, np.array([0.1, 0.0, 0.0])),
            Joint(JointKind.PRISMATIC, AHEAD, np.array([0.5, 0.5, 0.0])),
        ]
    ]
)
PLACES = np.array([[[0.02, 0.3, 0.0], [0.02, 0.3, 0.0], [0.5, 0.5, 0.1], [0.9, 0.9, 0.0]]])
PARTS = np.array([[0, 1, 3, 3]])


def test_a_point_near_two_hinges_gets_the_nearest_or_in_the_release_the_last() -> None:
    nearest = joint_targets(PLACES, PARTS, AXES, STRUCTURE)
    release = joint_targets(PLACES, PARTS, AXES, STRUCTURE, like_release=True)
    assert nearest.joints.tolist() == [[1, 1, 3, 3]]
    assert release.joints.tolist() == [[2, 1, 3, 0]], (
        "the last joint on the base, its own on door 1, and the points near the line on the drawer"
    )
    assert nearest.heatmap[0, 0] == pytest.approx(1.0 - 0.02 / JOINT_RADIUS)
    assert release.heatmap[0, 0] == pytest.approx(1.0 - 0.08 / JOINT_RADIUS)
    np.testing.assert_allclose(nearest.toward[0, 0], [-1.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(release.toward[0, 0], [1.0, 0.0, 0.0], atol=1e-6)


def test_all_points_of_a_slider_get_its_joint_which_has_a_place_only_in_the_release() -> None:
    found = joint_targets(PLACES, PARTS, AXES, STRUCTURE)
    assert found.has_pivot.tolist() == [[True, True, False, False]]
    assert found.heatmap[0, 2:].tolist() == [0.0, 0.0]
    np.testing.assert_array_equal(found.axes[0, 2:], [AHEAD, AHEAD])
    release = joint_targets(PLACES, PARTS, AXES, STRUCTURE, like_release=True)
    assert release.has_pivot.tolist() == [[True, True, True, False]]
    assert release.heatmap[0, 2] == pytest.approx(1.0), "it lies on the line through the stored origin"


@pytest.mark.parametrize("release", [False, True])
def test_targets_of_a_batch_equal_those_of_each_scan(release: bool) -> None:
    rng = np.random.default_rng(0)
    places, parts = rng.uniform(-0.3, 0.3, (5, 40, 3)), rng.integers(-1, 4, (5, 40))
    objects = [[Joint(kind, unit(rng), rng.uniform(-0.2, 0.2, 3)) for kind in STRUCTURE.kinds] for _ in range(5)]
    together = joint_targets(places, parts, JointAxes.of(objects), STRUCTURE, release)
    for row, joints in enumerate(objects):
        alone = joint_targets(places[row : row + 1], parts[row : row + 1], JointAxes.of([joints]), STRUCTURE, release)
        for name, values in alone._asdict().items():
            np.testing.assert_array_equal(getattr(together, name)[row], values[0], err_msg=name)


def test_global_targets_have_boxes_of_diagonal_one_and_pivots_next_to_the_moving_parts(file: ScanFile) -> None:
    half_sizes, pivots = global_targets(Extents.stack([file.extents]), JointAxes.of([file.joints]))
    np.testing.assert_allclose(np.linalg.norm(half_sizes, axis=-1), 0.5, atol=1e-3)
    for joint, pivot, middle in zip(file.joints, pivots[0] - 0.5, file.extents.centers[1:], strict=True):
        np.testing.assert_allclose(np.cross(pivot - joint.pivot, joint.direction), 0.0, atol=1e-6)
        assert (middle - pivot) @ joint.direction == pytest.approx(0.0, abs=1e-6)


def unit(rng: np.random.Generator) -> Vector:
    direction = rng.normal(size=3)
    return direction / np.linalg.norm(direction)
