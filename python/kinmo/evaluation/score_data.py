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
    data = asdict(score)
    for record, own in zip(score.records, data["records"], strict=True):
        predicted = record.predicted_type
        own["true_type"] = record.true_type.name
        own["predicted_type"] = None if predicted is None else [type(predicted).__name__, predicted.name]
    return data


def score_from_data(data: Mapping[str, Any]) -> ShapeScore:
    """The score of data made by `score_to_data`. Raises KeyError, TypeError or ValueError for data of another form."""
    records = tuple(_record_from_data(record) for record in data["records"])
    alarms = tuple(FalseAlarm(**alarm) for alarm in data["false_alarms"])
    return ShapeScore(**{**data, "records": records, "false_alarms": alarms})


def _record_from_data(data: Mapping[str, Any]) -> JointRecord:
    predicted = data["predicted_type"]
    types = {
        "true_type": MotionType[data["true_type"]],
        "predicted_type": None if predicted is None else TYPE_SETS[predicted[0]][predicted[1]],
    }
    return JointRecord(**{**data, **types})
