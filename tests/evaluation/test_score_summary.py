"""Summaries of shape scores: shares, means, macro means, medians and precision."""

import json
import math

import pytest

from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.score_summary import FIGURES, summarise_scores, without_controls


def record(shape_id="a", category="Door", body=0, *, axis=0.0, line=0.0, name="door", type=MotionType.R_V_S, **change):
    """A record with the given errors (degrees, diagonals); missed if `axis` is None."""
    errors = {} if axis is None else {"axis_error": math.radians(axis), "line_distance": line, "line_at_part": line}
    predicted = None if axis is None else type
    return JointRecord(shape_id, category, body, name, type, 2.0, **{"predicted_type": predicted, **errors, **change})


def shape(shape_id, category, *records, alarms=(), has_fine_types=True):
    return ShapeScore(shape_id, category, tuple(records), tuple(FalseAlarm(name, 0.5) for name in alarms), has_fine_types)


def doors(count, category="Door", **change):
    """Shapes with one joint each, all with the same errors."""
    return [shape(f"{category}{i}", category, record(f"{category}{i}", category, **change)) for i in range(count)]


def test_a_missed_joint_fails_every_share_and_enters_no_mean():
    summary = summarise_scores([shape("a", "Door", record(axis=2.0), record(body=1, axis=None))])
    assert summary.micro["missed"].value == 0.5
    assert summary.micro["ok"].value == 0.5
    assert summary.micro["axis_ok"].value == 0.5
    assert summary.micro["recall"].value == 0.5
    assert summary.micro["axis"].value == pytest.approx(2.0)
    assert summary.medians["axis"] == pytest.approx(2.0)


def test_macro_means_count_each_large_category_once():
    scores = doors(8, "Door", axis=1.0) + doors(16, "Safe", axis=4.0) + doors(3, "Oven", axis=31.0) + doors(2, "Pen", axis=90.0)
    summary = summarise_scores(scores)
    assert summary.macro[8]["axis"].value == pytest.approx(2.5)
    assert summary.macro[8]["axis"].count == 2
    assert summary.macro[3]["axis"].value == pytest.approx(12.0)
    assert summary.micro["axis"].value == pytest.approx((8 + 64 + 93 + 180) / 29)


def test_a_category_without_a_value_does_not_count_as_zero():
    slider = MotionType.P_H
    scores = doors(8, "Door", line=0.2) + doors(8, "Table", type=slider, line=None, line_distance=None, line_at_part=None)
    line = summarise_scores(scores).macro[8]["line"]
    assert line.value == pytest.approx(0.2)
    assert line.count == 1


def test_several_seeds_of_one_shape_count_as_one_object():
    runs = [shape("a", "Door", record("a", axis=axis)) for axis in (0.0, 3.0, 30.0)]
    summary = summarise_scores(runs)
    assert (summary.objects, summary.joints, summary.runs) == (1, 1, 3)
    assert summary.micro["axis"].value == pytest.approx(11.0)
    assert summary.micro["axis"].low == summary.micro["axis"].high == pytest.approx(11.0)


def test_false_alarms_lower_precision_and_not_recall():
    micro_figures = summarise_scores([shape("a", "Door", record(), record(body=1, axis=None), alarms=("shelf", "knob"))]).micro
    assert micro_figures["precision"].value == pytest.approx(1 / 3)
    assert micro_figures["recall"].value == pytest.approx(1 / 2)
    assert micro_figures["f1"].value == pytest.approx(2 / 5)


def test_a_method_with_five_types_has_no_accuracy_among_ten():
    coarse = shape("a", "Door", record(predicted_type=CoarseType.R), has_fine_types=False)
    summary = summarise_scores([coarse])
    assert summary.micro["fine_type"] is None
    assert summary.micro["coarse_type"].value == 1.0


def test_shapes_with_controls_only_are_left_out_without_controls():
    scores = [shape("a", "Toaster", record(name="Knob_1")), shape("b", "Door", record(), record(body=1, name="push button"))]
    kept = without_controls(scores)
    assert [(score.shape_id, len(score.records)) for score in kept] == [("b", 1)]


def test_false_alarms_named_like_controls_do_not_count_without_controls():
    scores = [
        shape("a", "Door", record(), record(body=1, name="knob"), alarms=("Push_Button", "light switch", "shelf")),
        shape("b", "Toaster", record(name="knob"), alarms=("knob", "shelf")),
    ]
    kept = without_controls(scores)
    assert [(score.shape_id, [alarm.name for alarm in score.false_alarms]) for score in kept] == [("a", ["shelf"])]
    assert summarise_scores(kept).micro["precision"].value == pytest.approx(1 / 2)
    assert summarise_scores(kept).micro["f1"].value == pytest.approx(2 / 3)
    assert summarise_scores(scores).micro["precision"].value == pytest.approx(3 / 8)


def test_the_raw_line_distance_is_in_the_lengths_of_the_file():
    summary = summarise_scores([shape("a", "Door", record(line=0.1))])
    assert summary.micro["raw_line"].value == pytest.approx(0.2)


def test_a_summary_can_be_written_as_json():
    document = json.loads(json.dumps(summarise_scores(doors(3)).to_json(), allow_nan=False))
    assert set(document["micro"]) == {figure.key for figure in FIGURES}
