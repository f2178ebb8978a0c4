"""What was measured of one true joint, and of one shape.

Everything is in the normalised frame: lengths are diagonals of the object's box.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import CoarseType, Joint, JointKind, MotionType
from kinmo.core.prediction import JointEstimate
from kinmo.evaluation import metrics
from kinmo.features.prepared_shape import PreparedShape

AXIS_WITHIN = math.radians(5.0)
LINE_WITHIN = 0.05
"""In diagonals."""
CONTROLS = ("button", "knob", "switch")
"""Small parts that nearly any axis of their box fits: figures are also given without them."""


def is_control(name: str) -> bool:
    """Whether a part of this name is a button, knob or switch."""
    return any(word in name.lower() for word in CONTROLS)


@dataclass(frozen=True)
class JointRecord:
    """One true joint and the answer to it.

    Angles in radians, lengths in diagonals. A joint is *missed* if no moving body answers to it; a figure is None where it
    has no meaning: the axis of a missed joint, the line of a slider, the range of an unlimited joint, what was not asked for.
    """

    shape_id: str
    category: str
    body: int
    name: str
    true_type: MotionType
    diagonal: float
    """Of the object, in the lengths of its file."""
    predicted_type: MotionType | CoarseType | None = None
    axis_error: float | None = None
    typed_axis_error: float | None = None
    """Of the answer when the true type is told."""
    line_distance: float | None = None
    """Smallest distance of the two lines."""
    line_at_part: float | None = None
    """Distance of the predicted line from the true one at the part: the stricter figure."""
    pivot_distance: float | None = None
    """Distance of the predicted line from the annotated pivot."""
    range_iou: float | None = None
    parent_ok: bool | None = None
    penetration: float | None = None
    """Share of the part's surface that runs into the rest on the way through the predicted range."""
    score: float | None = None
    terms: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_control(self) -> bool:
        """Whether the part is a button, knob or switch by name."""
        return is_control(self.name)

    @property
    def kind(self) -> JointKind:
        """The true kind."""
        kind = self.true_type.kind
        assert kind is not None, "records are of true joints"
        return kind

    @property
    def predicted_coarse(self) -> CoarseType | None:
        """The predicted type among five."""
        return self.predicted_type.coarse if isinstance(self.predicted_type, MotionType) else self.predicted_type

    @property
    def is_missed(self) -> bool:
        return self.predicted_coarse in (None, CoarseType.FIXED, CoarseType.NONE)

    @property
    def coarse_ok(self) -> bool:
        return self.predicted_coarse is self.true_type.coarse

    @property
    def type_ok(self) -> bool:
        """Right among the types that the method tells apart."""
        return self.fine_ok if isinstance(self.predicted_type, MotionType) else self.coarse_ok

    @property
    def fine_ok(self) -> bool:
        return self.predicted_type is self.true_type

    @property
    def axis_ok(self) -> bool:
        """Axis within 5 degrees, whatever the type."""
        return self.axis_error is not None and self.axis_error <= AXIS_WITHIN

    @property
    def placed_ok(self) -> bool:
        """Axis within 5 degrees and, unless the truth is a slider, the line within 0.05 diagonals."""
        is_slider = self.kind is JointKind.PRISMATIC
        return self.axis_ok and (is_slider or (self.line_at_part is not None and self.line_at_part <= LINE_WITHIN))

    @property
    def is_ok(self) -> bool:
        """Right kind, right axis, right line."""
        return self.coarse_ok and self.placed_ok


@dataclass(frozen=True)
class FalseAlarm:
    """A moving body of the prediction that is no moving body of the truth. `name` is its own, in the prediction."""

    name: str
    score: float
    terms: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_control(self) -> bool:
        """Whether the part is a button, knob or switch by name."""
        return is_control(self.name)


@dataclass(frozen=True)
class ShapeScore:
    """All true joints of one shape, with the moving bodies that it does not have. `failure` says why there is no prediction.

    `is_fine` tells whether the method speaks of ten types or of five.
    """

    shape_id: str
    category: str
    records: tuple[JointRecord, ...]
    false_alarms: tuple[FalseAlarm, ...] = ()
    is_fine: bool = True
    failure: str | None = None
    edges_right: int = 0
    edges: int = 0
    """How many edges of the hierarchy were classed, and how many of them right; 0 where a method has none."""

    def without_controls(self) -> ShapeScore:
        """The same without buttons, knobs and switches, true ones and false alarms."""
        records = tuple(record for record in self.records if not record.is_control)
        return replace(self, records=records, false_alarms=tuple(alarm for alarm in self.false_alarms if not alarm.is_control))


def missed_record(truth: PreparedShape, body: int) -> JointRecord:
    """The record of the joint of `body`, a movable body of the truth, without an answer."""
    mobility, _ = truth.annotation
    name = mobility.bodies[body].name
    return JointRecord(truth.id, truth.category, body, name, truth.body_types[body], truth.diagonal)


def terms_of(estimate: JointEstimate) -> dict[str, float]:
    """The terms of an answer's score that mean something: a slider has no position."""
    slides = estimate.joint is not None and not estimate.joint.has_pivot
    return {name: value for name, value in estimate.terms.items() if not (slides and name == "position")}


def false_alarm(name: str, estimate: JointEstimate) -> FalseAlarm:
    """What is remembered of a joint that there is not, of a body called `name`."""
    return FalseAlarm(name, estimate.score, terms_of(estimate))


def joint_record(truth: PreparedShape, body: int, estimate: JointEstimate | None) -> JointRecord:
    """The record of the joint of `body`, a movable body of the truth, with the answer `estimate` in the normalised frame."""
    record = missed_record(truth, body)
    if estimate is None:
        return record
    record = replace(record, predicted_type=estimate.type, score=estimate.score, terms=terms_of(estimate))
    return record if estimate.joint is None or record.is_missed else _measured(record, truth, body, estimate.joint)


def _measured(record: JointRecord, truth: PreparedShape, body: int, predicted: Joint) -> JointRecord:
    mobility, boxes = truth.annotation
    true, middle = mobility.bodies[body].joint, boxes[body].center
    assert true is not None, "records are of true joints"
    record = replace(
        record,
        axis_error=metrics.axis_error(true.direction, predicted.direction),
        range_iou=metrics.range_iou(true, predicted),
    )
    if not (true.has_pivot and predicted.has_pivot):
        return record
    return replace(
        record,
        line_distance=metrics.line_distance(true, predicted, middle),
        line_at_part=metrics.line_distance_at_part(true, predicted, middle),
        pivot_distance=metrics.pivot_distance(true, predicted),
    )


def with_edges(score: ShapeScore, truth: PreparedShape, predicted: NDArray[np.int64]) -> ShapeScore:
    """The score with the types [E] that a method gives to the edges of `truth`: MotionType, or CoarseType if it is coarse."""
    if truth.edge_labels is None or len(predicted) != len(truth.edges):
        raise ValueError(f"predicted: expected the types of the {len(truth.edges)} edges of a labelled shape")
    types = truth.edge_labels.types
    wanted = types if score.is_fine else np.array([MotionType(label).coarse for label in types], np.int64)
    return replace(score, edges_right=int(np.sum(wanted == predicted)), edges=len(predicted))


def failed_shape(truth: PreparedShape, reason: str, *, is_fine: bool = True) -> ShapeScore:
    """The score of a shape that got no prediction: all its joints are missed."""
    mobility, _ = truth.annotation
    records = tuple(missed_record(truth, body) for body, _ in mobility.movable())
    return ShapeScore(truth.id, truth.category, records, is_fine=is_fine, failure=reason)
