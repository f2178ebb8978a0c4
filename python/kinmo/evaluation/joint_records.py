"""Evaluation records of true joints, false alarms and whole shapes, in the normalised frame (lengths in diagonals)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.evaluation import metrics
from kinmo.features.prepared_shape import PreparedShape

CONTROLS = ("button", "knob", "switch")
"""Names of small parts that nearly any axis of their box fits. Tables are also printed without them."""


def is_control(name: str) -> bool:
    """True if the name of a part contains the name of a control (`CONTROLS`), in any case."""
    return any(word in name.lower() for word in CONTROLS)


@dataclass(frozen=True)
class JointRecord:
    """One true joint, its prediction and the errors of the prediction. Angles are in radians, lengths in diagonals.

    A joint is *missed* if no predicted body that moves matches its body. An error is None where it has no meaning: the axis of
    a missed joint, the line of a slider, the range of an unlimited joint.
    """

    shape_id: str
    category: str
    body: int
    name: str
    true_type: MotionType
    diagonal: float  # diagonal of the object's box in the lengths of its file
    predicted_type: MotionType | CoarseType | None = None
    axis_error: float | None = None
    typed_axis_error: float | None = None  # axis error of the prediction given the true type
    line_distance: float | None = None  # smallest distance of the two axis lines
    line_at_part: float | None = None  # distance of the axis lines at the part, the stricter error
    pivot_distance: float | None = None  # distance of the predicted line from the annotated pivot
    range_iou: float | None = None
    parent_ok: bool | None = None
    penetration: float | None = None
    """Share of the part's surface that collides on the way through the predicted range."""
    score: float | None = None
    terms: Mapping[str, float] = field(default_factory=dict)  # parts of `score` by name

    @property
    def is_control(self) -> bool:
        """True if the part is a button, knob or switch by name."""
        return is_control(self.name)

    @property
    def kind(self) -> JointKind:
        """The true kind."""
        kind = self.true_type.kind
        assert kind is not None, "records are of true joints"
        return kind

    @property
    def predicted_kind(self) -> JointKind | None:
        """The predicted kind, None for a missed joint."""
        return None if self.predicted_type is None else self.predicted_type.kind

    @property
    def is_missed(self) -> bool:
        """True if no predicted body that moves matches the body of the joint."""
        return self.predicted_kind is None

    @property
    def coarse_type_ok(self) -> bool:
        """True if the type is right among five, which for a joint is its kind."""
        return self.predicted_kind is self.kind

    @property
    def fine_type_ok(self) -> bool:
        """True if the type is right among ten; never for a method that distinguishes five."""
        return self.predicted_type is self.true_type

    @property
    def type_ok(self) -> bool:
        """True if the type is right among the types that the method distinguishes."""
        return self.fine_type_ok if isinstance(self.predicted_type, MotionType) else self.coarse_type_ok

    @property
    def axis_ok(self) -> bool:
        """True if the axis is ok, whatever the type."""
        return metrics.is_axis_ok(self.axis_error)

    @property
    def axis_and_line_ok(self) -> bool:
        """True if the axis is ok and, unless the true joint slides, the line too."""
        return metrics.is_axis_and_line_ok(self.kind, self.axis_error, self.line_at_part)

    @property
    def is_ok(self) -> bool:
        """True if kind, axis and line are ok (`metrics.is_ok`)."""
        return metrics.is_ok(self.kind, self.predicted_kind, self.axis_error, self.line_at_part)


@dataclass(frozen=True)
class FalseAlarm:
    """A body that moves in the prediction but not in the truth. `name` is its name in the prediction."""

    name: str
    score: float
    terms: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ShapeScore:
    """The records of all true joints of one shape, and the false alarms of its prediction.

    Methods without fine types distinguish five types, not ten. `failure` is the reason why there is no prediction. Of the
    `edges` of the hierarchy with a predicted type, `edges_right` have the right one.
    """

    shape_id: str
    category: str
    records: tuple[JointRecord, ...]
    false_alarms: tuple[FalseAlarm, ...] = ()
    has_fine_types: bool = True
    failure: str | None = None
    edges_right: int = 0
    edges: int = 0

    def without_controls(self) -> ShapeScore:
        """The score without buttons, knobs and switches, in the records and in the false alarms."""
        records = tuple(record for record in self.records if not record.is_control)
        return replace(self, records=records, false_alarms=tuple(a for a in self.false_alarms if not is_control(a.name)))


def missed_record(truth: PreparedShape, body: int) -> JointRecord:
    """The record of the joint of `body`, a movable body of the truth, that was not predicted."""
    mobility, _ = truth.annotation
    name = mobility.bodies[body].name
    return JointRecord(truth.id, truth.category, body, name, truth.body_types[body], truth.diagonal)


def false_alarm(name: str, estimate: JointEstimate) -> FalseAlarm:
    """The false alarm of an `estimate` for a body called `name`."""
    return FalseAlarm(name, estimate.score, score_terms(estimate))


def joint_record(truth: PreparedShape, body: int, estimate: JointEstimate | None) -> JointRecord:
    """Compare an estimate in the normalised frame with the true joint of `body`, a movable body of the truth.

    The joint is missed if nothing (None) or no motion was predicted.
    """
    record = missed_record(truth, body)
    if estimate is None:
        return record
    record = replace(record, predicted_type=estimate.type, score=estimate.score, terms=score_terms(estimate))
    return record if estimate.joint is None or record.is_missed else _with_errors(record, truth, estimate.joint)


def score_terms(estimate: JointEstimate) -> dict[str, float]:
    """The terms of an estimate's score that have a meaning: a slider has no position."""
    slides = estimate.joint is not None and not estimate.joint.has_pivot
    return {name: value for name, value in estimate.terms.items() if not (slides and name == "position")}


def _with_errors(record: JointRecord, truth: PreparedShape, predicted: Joint) -> JointRecord:
    mobility, boxes = truth.annotation
    true, middle = mobility.bodies[record.body].joint, boxes[record.body].center
    assert true is not None, "records are of true joints"
    has_lines = true.has_pivot and predicted.has_pivot
    return replace(
        record,
        axis_error=metrics.axis_error(true.direction, predicted.direction),
        range_iou=metrics.range_iou(true, predicted),
        line_distance=metrics.line_distance(true, predicted, middle) if has_lines else None,
        line_at_part=metrics.line_distance_at_part(true, predicted, middle) if has_lines else None,
        pivot_distance=metrics.pivot_distance(true, predicted) if has_lines else None,
    )


def with_edge_types(score: ShapeScore, truth: PreparedShape, predicted: NDArray[np.int64]) -> ShapeScore:
    """Add the accuracy of the predicted types [E] of edges to a score: MotionType, or CoarseType for a method with five types.

    Raises ValueError if the shape has no labelled edges, or another number of them.
    """
    if truth.edge_labels is None or len(predicted) != len(truth.edges):
        raise ValueError(f"predicted: expected the types of the {len(truth.edges)} edges of a labelled shape")
    types = truth.edge_labels.types
    expected = types if score.has_fine_types else np.array([MotionType(label).coarse for label in types], np.int64)
    return replace(score, edges_right=int(np.sum(expected == predicted)), edges=len(predicted))


def failed_shape(truth: PreparedShape, reason: str, *, has_fine_types: bool = True) -> ShapeScore:
    """The score of a shape without a prediction: all its joints are missed."""
    mobility, _ = truth.annotation
    records = tuple(missed_record(truth, body) for body, _ in mobility.movable())
    return ShapeScore(truth.id, truth.category, records, has_fine_types=has_fine_types, failure=reason)
