"""The first setting: the rigid bodies of the truth are given, and their joints are asked for (paper, Table 1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from kinmo.core.joint import CoarseType
from kinmo.core.prediction import JointEstimate
from kinmo.evaluation.joint_records import ShapeScore, false_alarm, joint_record
from kinmo.features.prepared_shape import PreparedShape


def parts_given(
    truth: PreparedShape,
    estimates: Mapping[int, JointEstimate],
    *,
    parents: Mapping[int, int | None] | None = None,
    penetrations: Mapping[int, float] | None = None,
    told: Mapping[int, JointEstimate] | None = None,
) -> ShapeScore:
    """Score the answers to the bodies of `truth`, by index of the body, joints in the normalised frame.

    A movable body without an answer, or with one that does not move, is missed; a body of the truth that does not move but is
    said to is a false alarm. `parents` and `penetrations`, where known, are by body
    too; so is `told`, the answers when the true types are told, to those bodies at least that otherwise got a wrong type.
    """
    mobility, _ = truth.annotation
    records = []
    for index, body in mobility.movable():
        record = joint_record(truth, index, estimates.get(index))
        if parents is not None and not record.is_missed:
            record = replace(record, parent_ok=parents.get(index) == body.parent)
        if penetrations is not None and index in penetrations:
            record = replace(record, penetration=penetrations[index])
        if told is not None:
            typed = record if record.type_ok else joint_record(truth, index, told.get(index))
            record = replace(record, typed_axis_error=typed.axis_error)
        records.append(record)
    still = {index: body.name for index, body in enumerate(mobility.bodies) if not body.is_movable}
    alarms = tuple(
        false_alarm(still[index], estimate)
        for index, estimate in estimates.items()
        if index in still and estimate.joint is not None
    )
    is_fine = not any(isinstance(estimate.type, CoarseType) for estimate in estimates.values())
    return ShapeScore(truth.id, truth.category, tuple(records), alarms, is_fine)
