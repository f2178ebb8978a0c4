"""Scores written as plain data are read unchanged."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.score_data import score_from_data, score_to_data

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
    has_fine_types=st.booleans(),
    failure=st.none() | st.text(max_size=5),
    edges_right=st.integers(0, 9),
    edges=st.integers(0, 9),
)


@given(score=scores)
def test_a_score_written_as_json_is_read_unchanged(score: ShapeScore) -> None:
    found = score_from_data(json.loads(json.dumps(score_to_data(score))))
    assert found == score
    assert [type(record.predicted_type) for record in found.records] == [
        type(record.predicted_type) for record in score.records
    ]


WITHOUT_NAME = {"records": [], "false_alarms": [{"score": 0.5, "terms": {}}]}


@pytest.mark.parametrize(
    "data", [{}, {"records": [{}], "false_alarms": []}, {"records": [], "false_alarms": [], "x": 1}, WITHOUT_NAME]
)
def test_data_of_another_form_raises_an_error(data: dict[str, object]) -> None:
    with pytest.raises((KeyError, TypeError, ValueError)):
        score_from_data(data)
