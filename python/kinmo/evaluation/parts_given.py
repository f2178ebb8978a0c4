"""Evaluation with parts given: a method gets the true rigid bodies and predicts their joints (paper, Table 1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from kinmo.core.motion_types import CoarseType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.evaluation.joint_records import ShapeScore, false_alarm, joint_record
from kinmo.features.prepared_shape import PreparedShape


def score_parts_given(
    truth: PreparedShape,
    estimates: Mapping[int, JointEstimate],
    *,
    parents: Mapping[int, int | None] | None = None,
    penetrations: Mapping[int, float] | None = None,
    typed_estimates: Mapping[int, JointEstimate] | None = None,
) -> ShapeScore:
    """Score predicted joints of the true bodies.

    A movable body without an estimate, or with one that does not move, is missed. A body of the truth that does not move, with
    an estimate that does, is a false alarm. All mappings are by index of the body; joints are in the normalised frame.

    Parents are given if the method predicts them, penetrations (`PenetrationMeter`) where they are known. Typed estimates are
    the predictions given the true types, at least for bodies with a wrong type in `estimates`.
    """
    mobility, _ = truth.annotation
    records = []
    for index, body in mobility.movable():
        record = joint_record(truth, index, estimates.get(index))
        if parents is not None and not record.is_missed:
            record = replace(record, parent_ok=parents.get(index) == body.parent)
        if penetrations is not None and index in penetrations:
            record = replace(record, penetration=penetrations[index])
        if typed_estimates is not None:
            typed = record if record.type_ok else joint_record(truth, index, typed_estimates.get(index))
            record = replace(record, typed_axis_error=typed.axis_error)
        records.append(record)
    fixed = {index: body.name for index, body in enumerate(mobility.bodies) if not body.is_movable}
    alarms = tuple(
        false_alarm(fixed[index], estimate)
        for index, estimate in estimates.items()
        if index in fixed and estimate.joint is not None
    )
    has_fine_types = not any(isinstance(estimate.type, CoarseType) for estimate in estimates.values())
    return ShapeScore(truth.id, truth.category, tuple(records), alarms, has_fine_types)
