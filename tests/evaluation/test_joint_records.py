"""Records of joints with parts given and with the hierarchy given: found and missed joints, false alarms, and their errors."""

import math
from dataclasses import replace

import numpy as np
import pytest
from articulated import articulated_shapes, prepared_from, shape_of_boxes
from hypothesis import given, settings
from scipy.spatial.transform import Rotation

from kinmo.core.edge_labels import label_edges
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.evaluation.hierarchy_given import score_hierarchy_given
from kinmo.evaluation.joint_records import failed_shape, joint_record, with_edge_types
from kinmo.evaluation.parts_given import score_parts_given

UP = np.array([0.0, 1, 0])
HINGE = Joint(JointKind.REVOLUTE, UP, np.array([0.0, 0, 1]), 0.0, 1.5)
KNOB = Joint(JointKind.PRISMATIC, np.array([0.0, 0, 1]), np.zeros(3), 0.0, 0.1)


def cabinet():
    """A door with a handle on it and a knob that is pushed, on a cabinet."""
    boxes = [
        ((0, 0, 0), (1, 2, 1)),
        ((0, 0, 1), (1, 2, 1.1)),
        ((0.8, 1, 1.1), (0.9, 1.1, 1.2)),
        ((0.2, 2, 0.2), (0.4, 2.1, 0.4)),
    ]
    bodies = (Body(0, "body", (1,)), Body(1, "door", (2, 3), 0, HINGE), Body(2, "Knob", (4,), 0, KNOB))
    return shape_of_boxes(boxes, bodies)


def estimate_of(truth, body, **change):
    joint = replace(truth.mobility.bodies[body].joint, **change)
    return JointEstimate(joint, truth.body_types[body], 0.9, {"feasibility": 0.8})


def true_estimates(truth):
    return {body: estimate_of(truth, body) for body, _ in truth.mobility.movable()}


def prediction_of(shape, mobility):
    truth = prepared_from(shape)
    answers = tuple(
        (JointEstimate(body.joint, MotionType.P_H if body.joint else MotionType.FIXED, 0.7),) for body in mobility.bodies
    )
    return ShapeEstimate(truth.id, truth.category, mobility, answers, tuple(a[0] for a in answers), "test")


@settings(max_examples=20)
@given(articulated_shapes())
def test_the_truth_has_no_errors_in_either_setting(shape):
    truth = prepared_from(shape)
    estimates = true_estimates(truth)
    given_parts = score_parts_given(truth, estimates, parents={i: b.parent for i, b in enumerate(truth.mobility.bodies)})
    given_tree = score_hierarchy_given(truth, prediction_of(shape, shape.mobility))
    assert len(given_parts.records) == len(estimates)
    assert all(record.is_ok and record.fine_type_ok and record.parent_ok for record in given_parts.records)
    found = [record for record in given_tree.records if not record.is_missed]
    assert all(record.axis_and_line_ok and record.parent_ok for record in found)
    assert not given_parts.false_alarms


def test_a_joint_without_an_estimate_is_missed_and_has_no_errors():
    truth = prepared_from(cabinet())
    fixed = JointEstimate(None, MotionType.FIXED, 0.9)
    for estimates in ({}, {1: fixed, 2: fixed}):
        score = score_parts_given(truth, estimates)
        assert [record.name for record in score.records] == ["door", "Knob"]
        for record in score.records:
            assert record.is_missed
            assert not record.axis_ok
            assert not record.is_ok
            assert (record.axis_error, record.line_distance, record.range_iou, record.parent_ok) == (None,) * 4


def test_buttons_knobs_and_switches_are_controls_in_any_case():
    score = score_parts_given(prepared_from(cabinet()), {})
    assert [record.is_control for record in score.records] == [False, True]
    assert [record.name for record in score.without_controls().records] == ["door"]


@pytest.mark.parametrize(("degrees", "expected"), [(0, True), (4.99, True), (5.01, False), (175.01, True), (174.9, False)])
def test_a_joint_is_ok_up_to_five_degrees(degrees, expected):
    truth = prepared_from(cabinet())
    turned = Rotation.from_rotvec([0, 0, math.radians(degrees)]).apply(UP)
    middle = truth.body_boxes[1].center
    pivot = truth.mobility.bodies[1].joint.pivot
    foot = pivot + UP * np.dot(middle - pivot, UP)
    record = joint_record(truth, 1, estimate_of(truth, 1, direction=turned, pivot=foot))
    assert math.degrees(record.axis_error) == pytest.approx(min(degrees, 180 - degrees))
    assert record.is_ok is expected


@pytest.mark.parametrize(("offset", "expected"), [(0.0, True), (0.049, True), (0.051, False)])
def test_a_hinge_is_ok_up_to_a_twentieth_of_the_diagonal(offset, expected):
    truth = prepared_from(cabinet())
    pivot = truth.mobility.bodies[1].joint.pivot + offset * np.array([1.0, 0, 0])
    record = joint_record(truth, 1, estimate_of(truth, 1, pivot=pivot))
    for value in (record.line_distance, record.line_at_part, record.pivot_distance):
        assert value == pytest.approx(offset, abs=1e-12)
    assert record.is_ok is expected


def test_typed_estimates_count_where_the_type_was_wrong_or_missing():
    truth = prepared_from(cabinet())
    tilted = estimate_of(truth, 1, direction=Rotation.from_euler("x", 7, degrees=True).apply(UP))
    typed = {1: tilted, 2: estimate_of(truth, 2)}
    slides = JointEstimate(replace(HINGE, kind=JointKind.PRISMATIC, direction=np.array([1.0, 0, 0])), MotionType.P_H, 0.5)
    for estimates, expected in (
        ({1: estimate_of(truth, 1), 2: estimate_of(truth, 2)}, (0.0, 0.0)),
        ({1: slides, 2: estimate_of(truth, 2)}, (7.0, 0.0)),
        ({1: JointEstimate(None, CoarseType.FIXED, 0.5)}, (7.0, 0.0)),
    ):
        found = [record.typed_axis_error for record in score_parts_given(truth, estimates, typed_estimates=typed).records]
        np.testing.assert_allclose(np.degrees(found), expected, atol=1e-5)
    alone = score_parts_given(truth, true_estimates(truth)).records
    assert {record.typed_axis_error for record in alone} == {None}


def test_a_slider_needs_no_line():
    truth = prepared_from(cabinet())
    record = joint_record(truth, 2, estimate_of(truth, 2, pivot=np.full(3, 9.0)))
    assert record.is_ok
    assert record.line_at_part is None


def test_a_hinge_predicted_as_a_slider_has_an_axis_but_no_line_and_is_not_ok():
    truth = prepared_from(cabinet())
    estimate = JointEstimate(Joint(JointKind.PRISMATIC, UP, np.zeros(3)), MotionType.P_V, 0.5)
    record = joint_record(truth, 1, estimate)
    assert record.axis_ok
    assert not (record.is_missed or record.is_ok or record.axis_and_line_ok or record.coarse_type_ok)
    assert record.line_distance is None


def test_a_coarse_type_counts_among_five_types_but_not_among_ten():
    truth = prepared_from(cabinet())
    estimate = replace(estimate_of(truth, 2), type=CoarseType.P)
    score = score_parts_given(truth, {2: estimate})
    knob = score.records[1]
    assert knob.coarse_type_ok
    assert not knob.fine_type_ok
    assert not score.has_fine_types
    assert not joint_record(truth, 2, replace(estimate, type=CoarseType(int(truth.body_types[1]) % 3))).fine_type_ok


def test_a_body_that_moves_only_in_the_prediction_is_a_false_alarm():
    truth = prepared_from(cabinet())
    score = score_parts_given(truth, {**true_estimates(truth), 0: estimate_of(truth, 1)})
    assert [(alarm.name, alarm.score) for alarm in score.false_alarms] == [("body", 0.9)]


def test_a_door_without_its_handle_is_still_found_and_the_loose_handle_is_a_false_alarm():
    shape = cabinet()
    body, door, knob = shape.mobility.bodies
    parts = (body, replace(door, leaves=(2,)), knob, Body(3, "handle", (3,), 1, KNOB))
    score = score_hierarchy_given(prepared_from(shape), prediction_of(shape, Mobility(parts)))
    assert [record.is_missed for record in score.records] == [False, False]
    assert [alarm.name for alarm in score.false_alarms] == ["handle"]


def test_a_door_glued_to_the_body_is_missed():
    shape = cabinet()
    body, _, knob = shape.mobility.bodies
    parts = (replace(body, leaves=(1, 2, 3)), replace(knob, parent=0))
    score = score_hierarchy_given(prepared_from(shape), prediction_of(shape, Mobility(parts)))
    assert [record.is_missed for record in score.records] == [True, False]
    assert not score.false_alarms


def test_predicted_bodies_that_are_fixed_to_each_other_count_as_one():
    shape = cabinet()
    body, door, knob = shape.mobility.bodies
    parts = (body, replace(door, leaves=(2,)), knob, Body(3, "handle", (3,), 1))
    score = score_hierarchy_given(prepared_from(shape), prediction_of(shape, Mobility(parts)))
    assert not any(record.is_missed for record in score.records)
    assert not score.false_alarms


def test_a_wrong_parent_is_not_ok():
    shape = cabinet()
    body, door, knob = shape.mobility.bodies
    score = score_hierarchy_given(prepared_from(shape), prediction_of(shape, Mobility((body, door, replace(knob, parent=1)))))
    assert [record.parent_ok for record in score.records] == [True, False]


def test_junk_does_not_change_the_matching():
    shape = cabinet()
    body, door, knob = shape.mobility.bodies
    junk = replace(shape, mobility=Mobility((body, door, replace(knob, joint=None)), frozenset({4})))
    glued = Mobility((body, replace(door, leaves=(2, 3, 4))))
    score = score_hierarchy_given(prepared_from(junk), prediction_of(shape, glued))
    assert [record.is_missed for record in score.records] == [False]


def test_all_joints_of_a_failed_shape_are_missed():
    truth = prepared_from(cabinet())
    score = failed_shape(truth, "out of memory")
    assert [record.is_missed for record in score.records] == [True, True]
    assert score.failure == "out of memory"


def test_edge_types_are_counted_apart_from_joints():
    shape = cabinet()
    truth = prepared_from(shape)
    labels = label_edges(shape, truth.mobility, truth.edges, truth.body_types)
    truth = replace(truth, edge_labels=labels)
    predicted = labels.types.copy()
    predicted[:3] = (predicted[:3] + 1) % 10
    score = with_edge_types(score_parts_given(truth, {}), truth, predicted)
    assert (score.edges_right, score.edges) == (len(predicted) - 3, len(predicted))
    coarse = np.array([MotionType(label).coarse for label in labels.types])
    score = with_edge_types(replace(score, has_fine_types=False), truth, coarse)
    assert score.edges_right == score.edges
    with pytest.raises(ValueError, match="predicted"):
        with_edge_types(score, truth, coarse[1:])


def test_a_truth_without_an_annotation_raises_an_input_error():
    truth = replace(prepared_from(cabinet()), mobility=None)
    with pytest.raises(InputError, match="annotated"):
        score_parts_given(truth, {})
