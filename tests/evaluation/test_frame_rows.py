"""The rows around a table, and the truth test of pseudo labels."""

import numpy as np
import pytest
from hypothesis import given, settings

from articulated import articulated_shapes, prepared_from, shape_of_boxes
from kinmo.evaluation.frame_rows import ceiling, choices, without_learning
from kinmo.evaluation.label_truth import THRESHOLDS, curves, label_truth_table, weighted_score
from kinmo.evaluation.parts_given import parts_given
from kinmo.evaluation.records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.tables import Caption, as_text
from kinmo.evaluation.trees import fit_kinds, fit_rank
from kinmo.joint import CoarseType, Joint, JointKind, MotionType
from kinmo.mobility import Body


@settings(max_examples=15, deadline=None)
@given(articulated_shapes())
def test_the_ceiling_is_right_if_the_truth_is_among_the_candidates(shape):
    truth = prepared_from(shape)
    rng = np.random.default_rng(0)
    candidates = {}
    for index, body in truth.mobility.movable():
        directions = np.vstack([np.linalg.qr(rng.normal(size=(3, 3)))[0], body.joint.direction])
        candidates[index] = directions, np.vstack([rng.normal(size=(3, 3)), body.joint.pivot])
    score = parts_given(truth, ceiling(truth, candidates))
    assert all(record.is_ok for record in score.records)


def test_a_body_without_candidates_is_missed_even_by_the_ceiling():
    truth = prepared_from(furniture())
    assert ceiling(truth, {}) == {}


def furniture(**door):
    """A closed door, a drawer, a button and a lid that stands open, on a cabinet."""
    boxes = [
        ((-0.5, 0, -0.5), (0.5, 2, 0.5)),
        ((0.0, 1, 0.5), (0.5, 2, 0.52)),
        ((-0.4, 0.2, 0.0), (0.4, 0.6, 0.6)),
        ((-0.3, 1.5, 0.5), (-0.28, 1.52, 0.51)),
        ((-0.5, 2.0, -0.5), (0.5, 2.6, -0.48)),
    ]
    up, front = np.array([0.0, 1, 0]), np.array([0.0, 0, 1])
    joints = [
        Joint(JointKind.REVOLUTE, up, np.array([0.5, 0, 0.5])),
        Joint(JointKind.PRISMATIC, front, np.zeros(3)),
        Joint(JointKind.PRISMATIC, front, np.zeros(3)),
        Joint(JointKind.REVOLUTE, np.array([1.0, 0, 0]), np.array([0, 2.0, -0.5])),
    ]
    names = ("door", "drawer", "button", "lid")
    bodies = [Body(i + 1, name, (i + 2,), 0, joint) for i, (name, joint) in enumerate(zip(names, joints, strict=True))]
    return shape_of_boxes(boxes, (Body(0, "body", (1,)), *bodies))


def test_the_rule_opens_plain_furniture():
    truth = prepared_from(furniture(), points=400)
    score = parts_given(truth, without_learning(truth))
    assert {record.name: record.is_ok for record in score.records} == dict.fromkeys(("door", "drawer", "button", "lid"), True)
    assert not score.false_alarms


@settings(max_examples=20, deadline=None)
@given(articulated_shapes())
def test_the_rule_answers_every_body_with_a_unit_axis(shape):
    truth = prepared_from(shape)
    answers = without_learning(truth)
    assert set(answers) == set(range(len(truth.mobility.bodies)))
    for answer in answers.values():
        if answer.joint is not None:
            assert np.linalg.norm(answer.joint.direction) == pytest.approx(1)
            assert answer.type.kind is answer.joint.kind


def test_the_best_row_of_a_group_is_chosen_and_ties_go_to_the_first():
    groups, values = np.array([4, 4, 7, 7, 4]), np.array([0.1, 0.9, 0.5, 0.5, 0.2])
    assert choices(groups, values) == {4: 1, 7: 2}


def test_trees_learn_to_pick_and_to_class_what_features_show():
    rng = np.random.default_rng(0)
    groups = np.repeat(np.arange(60), 8)
    right = np.zeros(480, bool)
    right[np.arange(60) * 8 + rng.integers(0, 8, 60)] = True
    features = rng.normal(size=(480, 5)) + 6.0 * right[:, None] * [1, 0, 0, 0, 0]
    train = groups < 40
    picks = fit_rank(features[train], groups[train], right[train], iterations=30).pick(features[~train], groups[~train])
    assert np.mean([right[~train][row] for row in picks.values()]) > 0.8
    kinds = np.where(features[:, 0] > 3.0, CoarseType.R, CoarseType.FIXED)
    found = fit_kinds(features[train], kinds[train], iterations=30).probabilities(features[~train], len(CoarseType))
    assert np.mean(found.argmax(axis=1) == kinds[~train]) > 0.95
    assert np.all(found[:, CoarseType.PR] == 0)


def labelled(right, score, **terms):
    axis = 0.0 if right else 1.0
    values = {"feasibility": score, "direction": score, **terms}
    return JointRecord("a", "Door", 0, "door", MotionType.P_H, 1.0, MotionType.P_H, axis, score=score, terms=values)


def test_precision_rises_and_recall_falls_with_a_score_that_sorts():
    rng = np.random.default_rng(0)
    records = [labelled(value > 0.4, value) for value in rng.uniform(0.05, 1, 200)]
    points = curves([ShapeScore("a", "Door", tuple(records))])["full"]
    precision = [point.precision for point in points]
    recall = [point.recall for point in points]
    assert [point.threshold for point in points] == pytest.approx(list(THRESHOLDS))
    assert precision[0] < 0.7
    assert precision[-1] == 1.0
    assert recall == sorted(recall, reverse=True)
    middle = points[8]
    assert middle.accepted_axis == 0.0
    assert middle.refused_axis > middle.accepted_axis
    assert middle.accepted + middle.refused == 200


def test_false_alarms_that_pass_count_against_precision():
    shape = ShapeScore(
        "a", "Door", (labelled(True, 0.8),), (FalseAlarm(0.7, {"feasibility": 0.7}), FalseAlarm(0.2, {"feasibility": 0.2}))
    )
    point = curves([shape])["feasibility alone"][10]
    assert (point.threshold, point.accepted, point.refused) == (pytest.approx(0.5), 2, 1)
    assert point.precision == 0.5
    assert point.recall == 1.0


def test_a_term_that_is_absent_leaves_its_weight_to_the_others():
    assert weighted_score({"feasibility": 1.0, "direction": 0.2}, {"feasibility": 0.5, "direction": 0.3, "position": 0.2}) == (
        pytest.approx(0.7)
    )
    assert weighted_score({}, {"feasibility": 1.0}) is None


def test_the_sweep_can_refuse_what_the_paper_accepts():
    shape = ShapeScore("a", "Door", (labelled(False, 0.9, sweep=0.0),))
    found = curves([shape])
    assert found["full"][13].accepted == 1
    assert found["full and sweep"][13].accepted == 0


def test_the_curves_print_as_a_table():
    table = label_truth_table(
        curves([ShapeScore("a", "Door", (labelled(True, 0.8),))]), Caption("Truth", "synth", 1, 1, "test", (0,))
    )
    assert len(table.rows) == 4 * len(THRESHOLDS)
    assert "consistency alone" in as_text(table)
