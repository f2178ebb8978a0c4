"""Figures of ANCSH's public evaluation code, with its faults."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from scanned_objects import cupboard, cupboard_object, true_estimate

from kinmo import _core
from kinmo.config import ScansConfig
from kinmo.core.joint import JointKind
from kinmo.evaluation.ancsh_protocol import box_overlap, score_as_ancsh
from kinmo.evaluation.scan_metrics import score_frame
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.rendering.labelled_frames import scan_object

CONFIG = ScansConfig(states=1, views=3, size=96, points=256, least_pixels=1, smallest_part=0.05)


def corners(sizes, shift=(0.0, 0.0, 0.0)):
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1)
    return np.array(shift) + 0.5 * signs * np.array(sizes)


@pytest.mark.parametrize(
    ("sizes", "shift", "printed", "exact"),
    [((0.1, 0.7, 0.7), (0.05, 0.0, 0.0), 1.000, 0.333), ((0.6, 0.5, 0.6), (0.1, 0.0, 0.0), 0.975, 0.714)],
)
def test_box_overlaps_are_too_large_by_known_amounts(sizes, shift, printed, exact):
    assert box_overlap(corners(sizes), corners(sizes, shift)) == pytest.approx(printed, abs=0.03)
    boxes = [(np.array([center]), np.eye(3)[None], 0.5 * np.array([sizes])) for center in (np.zeros(3), np.array(shift))]
    assert _core.box_iou(*boxes[0], *boxes[1])[0] == pytest.approx(exact, abs=0.001)


@pytest.fixture(scope="module")
def seen():
    target = cupboard_object()
    scans = scan_object(target, CONFIG, seed=1)
    return target, scans, [true_estimate(target, scans, row) for row in range(len(scans))]


def ancsh_score(seen, found, row=0):
    """Score of `found` in a frame, given the true part of every point."""
    target, scans, truths = seen
    return score_as_ancsh(found, truths[row], target.structure, scans.points[row].astype(float), scans.parts[row])


def joints_of_kind(seen, kind):
    return [row for row, own in enumerate(seen[0].structure.kinds) if own is kind]


def test_the_truth_has_no_error_except_for_sliders(seen):
    for row, true in enumerate(seen[2]):
        score = ancsh_score(seen, true, row)
        for name in ("rotation", "translation", "axis", "line"):
            np.testing.assert_allclose(getattr(score, name), 0.0, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(score.iou, 1.0)
        np.testing.assert_allclose(score.state[joints_of_kind(seen, JointKind.REVOLUTE)], 0.0, atol=1e-6)


def test_rotations_agree_with_the_default_measures_and_translations_with_corners(seen):
    target, _, truths = seen
    for row, found in enumerate(truths[1:] + truths[:1]):
        printed, exact = ancsh_score(seen, found, row), score_frame(found, truths[row], target.structure)
        np.testing.assert_allclose(printed.rotation, exact.rotation, atol=1e-6)
        corners = found.poses.translations - truths[row].poses.translations
        np.testing.assert_allclose(printed.translation, np.linalg.norm(corners, axis=1), atol=1e-9)


def test_a_hinge_open_in_the_other_direction_is_off_by_twice_its_angle(seen):
    _, _, truths = seen
    (row,) = joints_of_kind(seen, JointKind.REVOLUTE)
    base, part = truths[0].poses.rotations[0], row + 1
    turned = truths[0].poses.rotations.copy()
    opposite = base.T @ turned[part]
    turned[part] = base @ opposite.T
    found = replace(truths[0], poses=replace(truths[0].poses, rotations=turned))
    angle = abs(float(truths[0].states[row]))
    assert ancsh_score(seen, found).state[row] == pytest.approx(min(2 * angle, 2 * np.pi - 2 * angle), abs=1e-6)


def test_a_slider_is_taken_to_move_along_x_of_the_base(seen):
    target, scans, truths = seen
    (row,) = joints_of_kind(seen, JointKind.PRISMATIC)
    true, part = truths[0], row + 1
    cloud = scans.points[0][scans.parts[0] == part] - true.poses.translations[0]
    begins = (cloud @ true.poses.rotations[0])[:, 0].min()
    extent = true.half_extents[part, 0] / true.poses.scales[part]
    slid = np.array([begins - 0.5 + extent, 0.0, 0.0])
    right = true.states[row] * target.joints[row].direction
    assert ancsh_score(seen, true).state[row] == pytest.approx(np.linalg.norm(right - slid), abs=1e-6)


def test_a_frame_is_dropped_from_measures_that_lack_something(seen):
    true, missing = seen[2][0], np.full_like(seen[2][0].states, np.nan)
    whole, dropped = ancsh_score(seen, true), ancsh_score(seen, replace(true, states=missing))
    assert dropped.is_whole and np.isnan(dropped.state).all()
    for name in ("rotation", "translation", "iou", "axis", "line"):
        np.testing.assert_array_equal(getattr(dropped, name), getattr(whole, name))
    scales = true.poses.scales.copy()
    scales[1] = np.nan
    lost = ancsh_score(seen, replace(true, poses=replace(true.poses, scales=scales)))
    assert not lost.is_whole and all(np.isnan(getattr(lost, name)).all() for name in ("translation", "iou", "state"))
    scales[0] = np.nan
    lost = ancsh_score(seen, replace(true, poses=replace(true.poses, scales=scales)))
    assert all(np.isnan(getattr(lost, field.name)).all() for field in fields(lost)), "nothing is known without the base"


def test_states_are_dropped_where_no_point_is_predicted_on_a_slider(seen):
    target, scans, truths = seen
    (row,) = joints_of_kind(seen, JointKind.PRISMATIC)
    seen_parts = scans.parts[0] != row + 1
    points, parts = scans.points[0][seen_parts].astype(float), scans.parts[0][seen_parts]
    scales = truths[0].poses.scales.copy()
    for scale in (scales[row + 1], np.nan):
        scales[row + 1] = scale
        found = replace(truths[0], poses=replace(truths[0].poses, scales=scales))
        score = score_as_ancsh(found, truths[0], target.structure, points, parts)
        assert np.isnan(score.state).all()
        assert np.isnan(score.rotation).all() == np.isnan(scale)


def test_joints_are_dropped_where_a_parent_was_not_found():
    target = articulated_object(cupboard(), min_part_size=0.0)
    scans = scan_object(target, replace(CONFIG, least_pixels=0), seed=1)
    true = true_estimate(target, scans, 0)
    (row,) = (row for row, parent in enumerate(target.structure.parents) if parent)
    scales, directions, pivots = true.poses.scales.copy(), true.directions.copy(), true.pivots.copy()
    scales[target.structure.parents[row]] = directions[row] = pivots[row] = np.nan
    lost = replace(true, poses=replace(true.poses, scales=scales), directions=directions, pivots=pivots)
    score = score_as_ancsh(lost, true, target.structure, scans.points[0].astype(float), scans.parts[0])
    assert np.isnan(score.axis).all() and np.isnan(score.line).all()


def test_a_joint_that_no_point_predicts_has_no_error(seen):
    true = seen[2][0]
    unpredicted = replace(true, directions=np.full_like(true.directions, np.nan), pivots=np.full_like(true.pivots, np.nan))
    score = ancsh_score(seen, unpredicted)
    np.testing.assert_array_equal(score.axis, 0.0)
    np.testing.assert_array_equal(score.line, 0.0)
