"""What networks are to say of the surroundings of joints."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.core.joint import Joint, JointKind
from kinmo.core.vector import Vector
from kinmo.scans.ancsh.ancsh_targets import REACH, JointAxes, layout, surroundings
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


def test_a_point_near_to_two_hinges_tells_of_the_nearest_and_in_the_release_of_the_last() -> None:
    nearest = surroundings(PLACES, PARTS, AXES, STRUCTURE)
    release = surroundings(PLACES, PARTS, AXES, STRUCTURE, nearest=False, lines_only=True)
    assert nearest.joints.tolist() == [[1, 1, 3, 3]]
    assert release.joints.tolist() == [[2, 1, 3, 0]], "of the base the last; on door 1 only its own; of the drawer what is near"
    assert nearest.heatmap[0, 0] == pytest.approx(1.0 - 0.02 / REACH)
    assert release.heatmap[0, 0] == pytest.approx(1.0 - 0.08 / REACH)
    np.testing.assert_allclose(nearest.toward[0, 0], [-1.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(release.toward[0, 0], [1.0, 0.0, 0.0], atol=1e-6)


def test_a_slider_is_told_of_by_all_of_its_part_and_has_a_place_in_the_release_alone() -> None:
    found = surroundings(PLACES, PARTS, AXES, STRUCTURE)
    assert found.has_pivot.tolist() == [[True, True, False, False]]
    assert found.heatmap[0, 2:].tolist() == [0.0, 0.0]
    np.testing.assert_array_equal(found.axes[0, 2:], [AHEAD, AHEAD])
    release = surroundings(PLACES, PARTS, AXES, STRUCTURE, nearest=False, lines_only=True)
    assert release.has_pivot.tolist() == [[True, True, True, False]]
    assert release.heatmap[0, 2] == pytest.approx(1.0), "on the line through its stored origin"


@pytest.mark.parametrize("release", [False, True])
def test_scans_of_many_objects_are_told_of_as_each_alone(release: bool) -> None:
    rng = np.random.default_rng(0)
    places, parts = rng.uniform(-0.3, 0.3, (5, 40, 3)), rng.integers(-1, 4, (5, 40))
    objects = [[Joint(kind, unit(rng), rng.uniform(-0.2, 0.2, 3)) for kind in STRUCTURE.kinds] for _ in range(5)]
    options = {"nearest": not release, "lines_only": release}
    together = surroundings(places, parts, JointAxes.of(objects), STRUCTURE, **options)
    for row, joints in enumerate(objects):
        alone = surroundings(places[row : row + 1], parts[row : row + 1], JointAxes.of([joints]), STRUCTURE, **options)
        for name, values in vars(alone).items():
            np.testing.assert_array_equal(getattr(together, name)[row], values[0], err_msg=name)


def test_a_layout_has_boxes_of_diagonal_one_and_the_pivots_next_to_the_parts_that_move(file: ScanFile) -> None:
    half_sizes, pivots = layout(Extents.stack([file.extents]), JointAxes.of([file.joints]))
    np.testing.assert_allclose(np.linalg.norm(half_sizes, axis=-1), 0.5, atol=1e-3)
    for joint, pivot, middle in zip(file.joints, pivots[0] - 0.5, file.extents.centers[1:], strict=True):
        np.testing.assert_allclose(np.cross(pivot - joint.pivot, joint.direction), 0.0, atol=1e-6)
        assert (middle - pivot) @ joint.direction == pytest.approx(0.0, abs=1e-6)


def unit(rng: np.random.Generator) -> Vector:
    direction = rng.normal(size=3)
    return direction / np.linalg.norm(direction)
