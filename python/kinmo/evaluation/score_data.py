"""Scores of shapes as plain data, so that they can be kept in JSON and come back as they were."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from kinmo.core.joint import CoarseType, MotionType
from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore

TYPE_SETS: dict[str, type[MotionType] | type[CoarseType]] = {kind.__name__: kind for kind in (MotionType, CoarseType)}
"""FIXED and NONE are in both."""


def score_to_data(score: ShapeScore) -> dict[str, Any]:
    """What `score_from_data` reads."""
    return {**asdict(score), "records": [_record_to_data(record) for record in score.records]}


def score_from_data(data: Mapping[str, Any]) -> ShapeScore:
    """The score that `score_to_data` took apart. Raises KeyError, TypeError or ValueError for anything else."""
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
