"""Errors of one joint: exact values, and invariance to frames, signs and pivots."""

import math
from dataclasses import replace

import numpy as np
import pytest
from articulated import directions, joints, rotations, vectors
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from kinmo.core.joint import Joint, JointKind
from kinmo.evaluation import metrics

X, Y, Z = np.eye(3)
PIVOTED = (JointKind.REVOLUTE, JointKind.SCREW)


def errors(true, predicted, near):
    span = metrics.range_iou(true, predicted)
    return np.array(
        [
            metrics.axis_error(true.direction, predicted.direction),
            metrics.line_distance(true, predicted, near),
            metrics.line_distance_at_part(true, predicted, near),
            -1.0 if span is None else span,
        ]
    )


def away_from_the_parallel_threshold(true, predicted):
    angle = metrics.axis_error(true.direction, predicted.direction)
    return angle > 1.1 * metrics.PARALLEL_ANGLE or angle < 0.9 * metrics.PARALLEL_ANGLE


def away_from_right_angles(true, predicted):
    """True unless the axes are at right angles, where rounding decides how the ranges are aligned."""
    return abs(true.direction @ predicted.direction) > 1e-6


def nearly_same_joints(draw_from):
    return st.tuples(draw_from, vectors, st.floats(0, 0.5)).map(
        lambda t: (t[0], replace(t[0], pivot=t[0].pivot + 0.1 * t[1], lower=-t[2], upper=0.3))
    )


pairs = st.one_of(st.tuples(joints(PIVOTED), joints(PIVOTED)), nearly_same_joints(joints(PIVOTED)))


def test_the_axis_error_is_the_angle_of_rotation():
    for degrees in (0, 1e-6, 7, 45, 89.999, 90):
        angle = math.radians(degrees)
        turned = np.array([math.cos(angle), math.sin(angle), 0])
        assert metrics.axis_error(X, turned) == pytest.approx(angle, abs=1e-15)
        assert metrics.axis_error(X, -turned) == pytest.approx(angle, abs=1e-15)


def test_the_distance_of_parallel_lines_is_their_offset():
    true, shifted = Joint(JointKind.REVOLUTE, Z, np.zeros(3)), Joint(JointKind.REVOLUTE, -Z, np.array([0.03, 0.04, 9.0]))
    for distance in (metrics.line_distance, metrics.line_distance_at_part):
        assert distance(true, shifted, np.array([5.0, 5.0, 5.0])) == pytest.approx(0.05, abs=1e-15)
    assert metrics.pivot_distance(true, shifted) == pytest.approx(0.05, abs=1e-15)


def test_skew_lines_can_be_near_each_other_but_far_apart_at_the_part():
    true = Joint(JointKind.REVOLUTE, X, np.zeros(3))
    skew = Joint(JointKind.REVOLUTE, Y, np.array([10.0, 0, 0.2]))
    assert metrics.line_distance(true, skew, np.zeros(3)) == pytest.approx(0.2)
    assert metrics.line_distance_at_part(true, skew, np.zeros(3)) == pytest.approx(math.hypot(10, 0.2))


@given(pairs)
def test_line_distance_is_the_minimum_over_both_lines(pair):
    true, predicted = pair
    assume(metrics.axis_error(true.direction, predicted.direction) > 0.05)

    def at(t):
        return metrics.point_to_line(true.pivot + t * true.direction, predicted.pivot, predicted.direction)

    found = minimize_scalar(at, bracket=(-1, 1), tol=1e-12).fun
    assert metrics.line_distance(true, predicted, np.zeros(3)) == pytest.approx(found, abs=1e-6)


@given(pairs, vectors)
def test_the_smallest_distance_is_never_larger_than_the_one_at_the_part(pair, near):
    assert metrics.line_distance(*pair, near) <= metrics.line_distance_at_part(*pair, near) + 1e-12


@given(pairs, vectors)
def test_errors_do_not_depend_on_the_sign_of_a_direction(pair, near):
    true, predicted = pair
    assume(away_from_right_angles(true, predicted) and away_from_the_parallel_threshold(true, predicted))
    expected = errors(true, predicted, near)
    assert errors(true.reversed(), predicted, near) == pytest.approx(expected, abs=1e-12)
    assert errors(true, predicted.reversed(), near) == pytest.approx(expected, abs=1e-12)


@given(pairs, vectors, st.floats(-3, 3), st.floats(-3, 3))
def test_errors_do_not_depend_on_the_place_of_the_pivot_on_its_axis(pair, near, first, second):
    true, predicted = pair
    assume(away_from_the_parallel_threshold(true, predicted))
    slid_true = replace(true, pivot=true.pivot + first * true.direction)
    slid = replace(predicted, pivot=predicted.pivot + second * predicted.direction)
    # Lines barely over the threshold amplify rounding by 1 / sin(1 degree).
    assert errors(slid_true, slid, near) == pytest.approx(errors(true, predicted, near), abs=1e-10)


@given(pairs, vectors, rotations, vectors)
def test_errors_do_not_depend_on_the_frame(pair, near, rotation, shift):
    assume(away_from_right_angles(*pair) and away_from_the_parallel_threshold(*pair))
    moved = [replace(j, direction=rotation @ j.direction, pivot=rotation @ j.pivot + shift) for j in pair]
    assert errors(*moved, rotation @ near + shift) == pytest.approx(errors(*pair, near), abs=1e-10)


@given(pairs, vectors, st.floats(0.01, 100))
def test_distances_scale_with_the_scene_and_angles_do_not(pair, near, scale):
    scaled = [replace(j, pivot=scale * j.pivot) for j in pair]
    expected = errors(*pair, near) * [1, scale, scale, 1]
    assert errors(*scaled, scale * near) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_range_iou_agrees_with_values_worked_out_by_hand():
    door = Joint(JointKind.REVOLUTE, Y, np.zeros(3), 0.0, math.pi / 2)
    half = replace(door, upper=math.pi / 4)
    assert metrics.range_iou(door, half) == pytest.approx(0.5)
    assert metrics.range_iou(door, half.reversed()) == pytest.approx(0.5)
    assert metrics.range_iou(door, replace(half, lower=-math.pi / 4, upper=0.0)) == 0.0
    assert metrics.range_iou(door, replace(door, lower=2 * math.pi, upper=2.5 * math.pi)) == pytest.approx(1.0)


def test_ranges_of_sliders_are_not_shifted_by_whole_turns():
    drawer = Joint(JointKind.PRISMATIC, Z, np.zeros(3), 0.0, 1.0)
    away = replace(drawer, lower=2 * math.pi, upper=2 * math.pi + 1)
    assert metrics.range_iou(drawer, away) == 0.0


@pytest.mark.parametrize("change", [{"lower": None, "upper": None}, {"upper": 0.0}, {"kind": JointKind.SCREW}])
def test_range_iou_needs_two_limited_joints_of_one_kind(change):
    drawer = Joint(JointKind.PRISMATIC, Z, np.zeros(3), 0.0, 1.0)
    assert metrics.range_iou(drawer, replace(drawer, **change)) is None


@given(joints(limited=True), joints(limited=True))
def test_range_iou_is_symmetric_and_one_for_itself(first, second):
    assume(away_from_right_angles(first, second))
    assert metrics.range_iou(first, first) == pytest.approx(1.0)
    assert metrics.range_iou(first, second) == pytest.approx(metrics.range_iou(second, first), abs=1e-12, nan_ok=True) or (
        metrics.range_iou(first, second) is None and metrics.range_iou(second, first) is None
    )


@given(directions, directions, st.floats(0.1, 10))
def test_the_axis_error_does_not_need_unit_vectors(first, second, length):
    assert metrics.axis_error(first, length * second) == pytest.approx(metrics.axis_error(first, second), abs=1e-12)


@pytest.mark.parametrize(
    ("true", "predicted", "degrees", "line", "expected"),
    [
        (JointKind.REVOLUTE, JointKind.REVOLUTE, 4.9, 0.049, True),
        (JointKind.REVOLUTE, JointKind.REVOLUTE, 5.1, 0.0, False),
        (JointKind.REVOLUTE, JointKind.REVOLUTE, 0.0, 0.051, False),
        (JointKind.REVOLUTE, JointKind.SCREW, 0.0, 0.0, False),
        (JointKind.REVOLUTE, None, None, None, False),
        (JointKind.PRISMATIC, JointKind.PRISMATIC, 4.9, None, True),
        (JointKind.PRISMATIC, JointKind.REVOLUTE, 0.0, 0.0, False),
        (JointKind.SCREW, JointKind.SCREW, 0.0, None, False),
    ],
)
def test_a_joint_is_ok_with_the_right_kind_axis_and_line(true, predicted, degrees, line, expected):
    error = None if degrees is None else math.radians(degrees)
    assert metrics.is_ok(true, predicted, error, line) is expected
