"""Conversion of shape scores to plain data for JSON, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore

TYPE_SETS: dict[str, type[MotionType] | type[CoarseType]] = {kind.__name__: kind for kind in (MotionType, CoarseType)}
"""The two sets of types by name. FIXED and NONE are in both."""


def score_to_data(score: ShapeScore) -> dict[str, Any]:
    """A score as plain data, to be read by `score_from_data`."""
    return {**asdict(score), "records": [_record_to_data(record) for record in score.records]}


def score_from_data(data: Mapping[str, Any]) -> ShapeScore:
    """The score of data made by `score_to_data`.

    Raises:
        KeyError, TypeError, ValueError: if the data has another form.
    """
    records = tuple(_record_from_data(record) for record in data["records"])
    alarms = tuple(FalseAlarm(**alarm) for alarm in data["false_alarms"])
    return ShapeScore(**{**data, "records": records, "false_alarms": alarms})


def _record_to_data(record: JointRecord) -> dict[str, Any]:
    predicted = record.predicted_type
    types = {
        "true_type": record.true_type.name,
        "predicted_type": None if predicted is None else [type(predicted).__name__, predicted.name],
    }
    return {**asdict(record), **types}


def _record_from_data(data: Mapping[str, Any]) -> JointRecord:
    predicted = data["predicted_type"]
    types = {
        "true_type": MotionType[data["true_type"]],
        "predicted_type": None if predicted is None else TYPE_SETS[predicted[0]][predicted[1]],
    }
    return JointRecord(**{**data, **types})
