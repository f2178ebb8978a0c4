"""Scores that are kept come back as they were."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.joint import CoarseType, MotionType
from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.score_data import score_from_data, score_to_data
from kinmo.experiments.table1.kept_scores import judgement_to_data, read_judgement
from kinmo.experiments.table1.shape_scores import Judgement

numbers = st.floats(allow_nan=False, allow_infinity=False)
terms = st.dictionaries(st.text(max_size=5), numbers, max_size=3)
movable = st.sampled_from([kind for kind in MotionType if kind < MotionType.FIXED])
records = st.builds(
    JointRecord,
    shape_id=st.text(max_size=5),
    category=st.text(max_size=5),
    body=st.integers(0, 9),
    name=st.text(max_size=5),
    true_type=movable,
    diagonal=numbers,
    predicted_type=st.none() | st.sampled_from([*MotionType, *CoarseType]),
    axis_error=st.none() | numbers,
    parent_ok=st.none() | st.booleans(),
    score=st.none() | numbers,
    terms=terms,
)
scores = st.builds(
    ShapeScore,
    shape_id=st.text(max_size=5),
    category=st.text(max_size=5),
    records=st.lists(records, max_size=3).map(tuple),
    false_alarms=st.lists(st.builds(FalseAlarm, name=st.text(max_size=5), score=numbers, terms=terms), max_size=2).map(tuple),
    is_fine=st.booleans(),
    failure=st.none() | st.text(max_size=5),
    edges_right=st.integers(0, 9),
    edges=st.integers(0, 9),
)


@given(score=scores)
def test_a_score_comes_back_from_json_as_it_was(score: ShapeScore) -> None:
    found = score_from_data(json.loads(json.dumps(score_to_data(score))))
    assert found == score
    assert [type(record.predicted_type) for record in found.records] == [
        type(record.predicted_type) for record in score.records
    ]


NAMELESS = {"records": [], "false_alarms": [{"score": 0.5, "terms": {}}]}


@pytest.mark.parametrize(
    "data", [{}, {"records": [{}], "false_alarms": []}, {"records": [], "false_alarms": [], "x": 1}, NAMELESS]
)
def test_anything_else_is_refused(data: dict[str, object]) -> None:
    with pytest.raises((KeyError, TypeError, ValueError)):
        score_from_data(data)


def test_a_kept_judgement_whose_false_alarms_have_no_names_is_made_again(tmp_path: Path) -> None:
    score = ShapeScore("a", "Door", (), (FalseAlarm("knob", 0.5),))
    kept = {"made_from": "x", "judgement": judgement_to_data(Judgement({}, {"kinmo": score}))}
    path = tmp_path / "a.json"
    path.write_text(json.dumps(kept), encoding="utf-8")
    found = read_judgement(path, "x")
    assert found is not None
    assert found.hierarchy_given == {"kinmo": score}
    path.write_text(json.dumps(kept).replace('"name": "knob", ', ""), encoding="utf-8")  # as it was before they had any
    assert read_judgement(path, "x") is None
