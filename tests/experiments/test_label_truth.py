"""The truth test of pseudo labels."""

import numpy as np
import pytest

from kinmo.core.motion_types import MotionType
from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.tables import Caption, as_text
from kinmo.experiments.label_truth import THRESHOLDS, WEIGHTS, curves, label_truth_table, weighted_score


def labelled(right, score, **terms):
    axis = 0.0 if right else 1.0
    values = {"feasibility": score, "direction": score, **terms}
    return JointRecord("a", "Door", 0, "door", MotionType.P_H, 1.0, MotionType.P_H, axis, score=score, terms=values)


def test_precision_rises_and_recall_falls_with_a_score_that_sorts():
    rng = np.random.default_rng(0)
    records = [labelled(value > 0.4, value) for value in rng.uniform(0.05, 1, 200)]
    points = curves([ShapeScore("a", "Door", tuple(records))], WEIGHTS)["full"]
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
    alarms = tuple(FalseAlarm("shelf", score, {"feasibility": score}) for score in (0.7, 0.2))
    shape = ShapeScore("a", "Door", (labelled(True, 0.8),), alarms)
    point = curves([shape], WEIGHTS)["feasibility alone"][10]
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
    found = curves([shape], WEIGHTS)
    assert found["full"][13].accepted == 1
    assert found["full and sweep"][13].accepted == 0


def test_the_curves_print_as_a_table():
    table = label_truth_table(
        curves([ShapeScore("a", "Door", (labelled(True, 0.8),))], WEIGHTS), Caption("Truth", "synth", 1, 1, "test", (0,))
    )
    assert len(table.rows) == 4 * len(THRESHOLDS)
    assert "consistency alone" in as_text(table)
