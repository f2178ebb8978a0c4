"""The figures of one joint: exact values, and what they must not depend on."""

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


def figures(true, predicted, near):
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
    return angle > 1.1 * metrics.PARALLEL_WITHIN or angle < 0.9 * metrics.PARALLEL_WITHIN


def away_from_right_angles(true, predicted):
    """At a right angle the aligned sense of the range is a coin toss."""
    return abs(true.direction @ predicted.direction) > 1e-6


def nearly_same_joints(draw_from):
    return st.tuples(draw_from, vectors, st.floats(0, 0.5)).map(
        lambda t: (t[0], replace(t[0], pivot=t[0].pivot + 0.1 * t[1], lower=-t[2], upper=0.3))
    )


pairs = st.one_of(st.tuples(joints(PIVOTED), joints(PIVOTED)), nearly_same_joints(joints(PIVOTED)))


def test_a_turned_axis_reads_its_angle():
    for degrees in (0, 1e-6, 7, 45, 89.999, 90):
        angle = math.radians(degrees)
        turned = np.array([math.cos(angle), math.sin(angle), 0])
        assert metrics.axis_error(X, turned) == pytest.approx(angle, abs=1e-15)
        assert metrics.axis_error(X, -turned) == pytest.approx(angle, abs=1e-15)


def test_parallel_lines_are_as_far_apart_as_their_offset():
    true, shifted = Joint(JointKind.REVOLUTE, Z, np.zeros(3)), Joint(JointKind.REVOLUTE, -Z, np.array([0.03, 0.04, 9.0]))
    for distance in (metrics.line_distance, metrics.line_distance_at_part):
        assert distance(true, shifted, np.array([5.0, 5.0, 5.0])) == pytest.approx(0.05, abs=1e-15)
    assert metrics.pivot_distance(true, shifted) == pytest.approx(0.05, abs=1e-15)


def test_skew_lines_pass_each_other_but_not_at_the_part():
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
def test_nothing_depends_on_the_sign_of_a_direction(pair, near):
    true, predicted = pair
    assume(away_from_right_angles(true, predicted) and away_from_the_parallel_threshold(true, predicted))
    expected = figures(true, predicted, near)
    assert figures(true.reversed(), predicted, near) == pytest.approx(expected, abs=1e-12)
    assert figures(true, predicted.reversed(), near) == pytest.approx(expected, abs=1e-12)


@given(pairs, vectors, st.floats(-3, 3), st.floats(-3, 3))
def test_nothing_depends_on_where_the_pivot_sits_on_its_axis(pair, near, first, second):
    true, predicted = pair
    assume(away_from_the_parallel_threshold(true, predicted))
    slid_true = replace(true, pivot=true.pivot + first * true.direction)
    slid = replace(predicted, pivot=predicted.pivot + second * predicted.direction)
    # Lines barely over the threshold amplify rounding by 1 / sin(1 degree).
    assert figures(slid_true, slid, near) == pytest.approx(figures(true, predicted, near), abs=1e-10)


@given(pairs, vectors, rotations, vectors)
def test_nothing_depends_on_the_frame(pair, near, rotation, shift):
    assume(away_from_right_angles(*pair) and away_from_the_parallel_threshold(*pair))
    moved = [replace(j, direction=rotation @ j.direction, pivot=rotation @ j.pivot + shift) for j in pair]
    assert figures(*moved, rotation @ near + shift) == pytest.approx(figures(*pair, near), abs=1e-10)


@given(pairs, vectors, st.floats(0.01, 100))
def test_lengths_scale_with_the_scene_and_angles_do_not(pair, near, scale):
    scaled = [replace(j, pivot=scale * j.pivot) for j in pair]
    expected = figures(*pair, near) * [1, scale, scale, 1]
    assert figures(*scaled, scale * near) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_ranges_overlap_by_hand_worked_values():
    door = Joint(JointKind.REVOLUTE, Y, np.zeros(3), 0.0, math.pi / 2)
    half = replace(door, upper=math.pi / 4)
    assert metrics.range_iou(door, half) == pytest.approx(0.5)
    assert metrics.range_iou(door, half.reversed()) == pytest.approx(0.5)
    assert metrics.range_iou(door, replace(half, lower=-math.pi / 4, upper=0.0)) == 0.0
    assert metrics.range_iou(door, replace(door, lower=2 * math.pi, upper=2.5 * math.pi)) == pytest.approx(1.0)


def test_a_slider_does_not_come_round_again():
    drawer = Joint(JointKind.PRISMATIC, Z, np.zeros(3), 0.0, 1.0)
    away = replace(drawer, lower=2 * math.pi, upper=2 * math.pi + 1)
    assert metrics.range_iou(drawer, away) == 0.0


@pytest.mark.parametrize("change", [{"lower": None, "upper": None}, {"upper": 0.0}, {"kind": JointKind.SCREW}])
def test_a_range_without_a_counterpart_is_not_a_figure(change):
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
def test_an_axis_needs_no_unit_length(first, second, length):
    assert metrics.axis_error(first, length * second) == pytest.approx(metrics.axis_error(first, second), abs=1e-12)
