"""Errors of estimates of a scan that are off by known amounts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import directions
from hypothesis import given, settings
from hypothesis import strategies as st
from scanned_objects import cupboard_object, true_estimate
from scipy.spatial.transform import Rotation

from kinmo.config import ScansConfig
from kinmo.core.joint import JointKind
from kinmo.evaluation.scan_metrics import score_frame
from kinmo.scans.poses.scan_estimate import PartPoses, ScanEstimate
from kinmo.scans.rendering.labelled_frames import scan_object

TARGET = cupboard_object()
TRUE = true_estimate(TARGET, scan_object(TARGET, ScansConfig(states=1, views=1, size=64, points=64), 3), 0)
KINDS = TARGET.structure.kinds
HINGE = KINDS.index(JointKind.REVOLUTE)
SLIDER = KINDS.index(JointKind.PRISMATIC)
angles = st.floats(-1.5, 1.5)


def score(found: ScanEstimate):
    return score_frame(found, TRUE, TARGET.structure)


def turned(part: int, rotation: Rotation, shift: np.ndarray) -> ScanEstimate:
    """The true estimate with one part rotated about its middle and shifted."""
    poses = TRUE.poses
    rotations, translations, centers = poses.rotations.copy(), poses.translations.copy(), TRUE.centers.copy()
    rotations[part] = rotation.as_matrix() @ rotations[part]
    translations[part] = poses.middles[part] + rotation.apply(poses.translations[part] - poses.middles[part]) + shift
    centers[part] += shift
    return replace(TRUE, poses=PartPoses(rotations, poses.scales, translations), centers=centers)


def with_joint(row: int, **changed) -> ScanEstimate:
    """The true estimate with other values of one joint."""
    values = {name: getattr(TRUE, name).copy() for name in changed}
    for name, value in changed.items():
        values[name][row] = value
    return replace(TRUE, **values)


def test_the_true_estimate_has_no_errors() -> None:
    found = score(TRUE)
    assert found.is_whole
    for name in ("rotation", "translation", "state", "axis"):
        np.testing.assert_allclose(getattr(found, name), 0.0, atol=1e-7)
    np.testing.assert_allclose(found.iou, 1.0, atol=1e-9)
    assert [bool(np.isnan(line)) for line in found.line] == [kind is JointKind.PRISMATIC for kind in KINDS]


@settings(max_examples=40)
@given(directions, st.floats(0.0, 3.1), directions, st.floats(0.0, 1.0), st.integers(0, len(KINDS)))
def test_part_errors_are_the_rotation_and_the_shift_of_the_middle(axis, angle, way, length, part) -> None:
    found = score(turned(part, Rotation.from_rotvec(angle * axis), length * way))
    expected = np.zeros(len(KINDS) + 1)
    expected[part] = angle
    np.testing.assert_allclose(found.rotation, expected, atol=1e-6)
    expected[part] = length
    np.testing.assert_allclose(found.translation, expected, atol=1e-9)


@pytest.mark.parametrize("part", range(len(KINDS) + 1))
def test_half_a_box_overlaps_by_a_half_and_a_half_shifted_one_by_a_third(part: int) -> None:
    half = TRUE.half_extents.copy()
    half[part, 1] *= 0.5
    assert score(replace(TRUE, half_extents=half)).iou[part] == pytest.approx(0.5)
    shift = TRUE.poses.rotations[part][:, 1] * TRUE.half_extents[part, 1]
    assert score(turned(part, Rotation.identity(), shift)).iou[part] == pytest.approx(1.0 / 3.0)


@settings(max_examples=40)
@given(directions, st.floats(0.0, 1.5), st.integers(0, len(KINDS) - 1))
def test_the_axis_error_is_the_angle_in_either_direction(across, angle, row) -> None:
    right = TRUE.directions[row]
    across = across - (across @ right) * right
    across = across / np.linalg.norm(across) if np.linalg.norm(across) > 1e-3 else np.cross(right, np.roll(right, 1))
    tilted = np.cos(angle) * right + np.sin(angle) * across / np.linalg.norm(across)
    for sign in (1.0, -1.0):
        assert score(with_joint(row, directions=sign * tilted)).axis[row] == pytest.approx(angle, abs=1e-6)


@given(st.floats(0.0, 0.5), st.floats(-1.0, 1.0))
def test_the_line_error_is_the_shift_across_the_axis(across, along) -> None:
    right = TRUE.directions[HINGE]
    aside = np.cross(right, np.roll(right, 1))
    pivot = TRUE.pivots[HINGE] + across * aside / np.linalg.norm(aside) + along * right
    assert score(with_joint(HINGE, pivots=pivot)).line[HINGE] == pytest.approx(across, abs=1e-9)


@given(angles)
def test_states_are_compared_along_the_true_direction(off) -> None:
    for row in (HINGE, SLIDER):
        assert score(with_joint(row, states=TRUE.states[row] + off)).state[row] == pytest.approx(abs(off))
        reversed_ = with_joint(row, states=-TRUE.states[row] - off, directions=-TRUE.directions[row])
        assert score(reversed_).state[row] == pytest.approx(abs(off))


@given(angles)
def test_a_screw_has_a_state_error_and_a_turn_error(off) -> None:
    (row,) = (row for row, kind in enumerate(KINDS) if kind is JointKind.SCREW)
    for sign in (1.0, -1.0):
        turn, state, direction = TRUE.turns[row] + off, TRUE.states[row], TRUE.directions[row]
        found = score(with_joint(row, turns=sign * turn, states=sign * state, directions=sign * direction))
        assert found.turn[row] == pytest.approx(abs(off), abs=1e-9)
        assert found.state[row] == pytest.approx(0.0, abs=1e-9)
        assert np.isfinite(found.turn).sum() == 1


def test_a_whole_turn_is_no_error_for_a_hinge_but_for_a_slider() -> None:
    for row, error in ((HINGE, 0.0), (SLIDER, 2.0 * np.pi)):
        assert score(with_joint(row, states=TRUE.states[row] + 2.0 * np.pi)).state[row] == pytest.approx(error, abs=1e-9)


def test_a_part_that_was_not_found_has_no_error() -> None:
    poses = PartPoses(*(values.copy() for values in (TRUE.poses.rotations, TRUE.poses.scales, TRUE.poses.translations)))
    for values in (poses.rotations, poses.scales, poses.translations):
        values[1] = np.nan
    found = score(replace(TRUE, poses=poses))
    assert not found.is_whole
    for name in ("rotation", "translation", "iou"):
        assert np.flatnonzero(np.isnan(getattr(found, name))).tolist() == [1]
