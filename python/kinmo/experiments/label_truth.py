"""Do pseudo labels tell the truth? Scores of labelled shapes whose joints were hidden, against what the joints really are.

A joint is written as a pseudo label if its score is above a threshold. A score that does not sort right joints from wrong
ones is not a score: precision must rise with the threshold, and the errors of what is accepted lie below those of what is
refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.summary import axis_degrees
from kinmo.evaluation.tables import Caption, Column, Table

THRESHOLDS: NDArray[np.float64] = np.linspace(0.0, 0.9, 19)

WEIGHTS: dict[str, dict[str, float]] = {
    "full": {"feasibility": 0.5, "direction": 0.3, "position": 0.2},
    "feasibility alone": {"feasibility": 1.0},
    "consistency alone": {"direction": 0.3, "position": 0.2},
    "full and sweep": {"feasibility": 0.5, "direction": 0.3, "position": 0.2, "sweep": 0.5},
}
"""The paper's score (section 3.3) and others: weighted means of its terms, and with the free travel as one more."""

RANKING_WEIGHTS: dict[str, dict[str, float]] = {
    "full": {"score": 1.0},
    "that it moves, alone": {"moves": 1.0},
    "kind alone": {"kind": 1.0},
    "axis alone": {"axis": 1.0},
    "full and sweep": {"score": 1.0, "sweep": 0.5},
}
"""The same for the `kinmo` method, whose score is a probability of its own; the term `score` stands for it."""


def weighted_score(terms: Mapping[str, float], weights: Mapping[str, float]) -> float | None:
    """The weighted mean of those terms that there are; None if there are none."""
    known = {name: weight for name, weight in weights.items() if name in terms and weight > 0}
    total = sum(known.values())
    return sum(weight * terms[name] for name, weight in known.items()) / total if total > 0 else None


@dataclass(frozen=True)
class Point:
    """What a threshold lets through. Errors are means, in degrees and diagonals; None where there is nothing to average.

    `precision` is the share of right joints among the accepted ones, false alarms counted; `recall` is the share of true
    joints that are accepted and right. Right is the `is_ok` of a record.
    """

    threshold: float
    accepted: int
    refused: int
    precision: float | None
    recall: float | None
    accepted_axis: float | None
    refused_axis: float | None
    accepted_line: float | None
    refused_line: float | None


def curves(
    scores: Sequence[ShapeScore], *, weights: Mapping[str, Mapping[str, float]] | None = None
) -> dict[str, tuple[Point, ...]]:
    """One curve over THRESHOLDS for each way of scoring, for shapes scored in either setting."""
    ways = WEIGHTS if weights is None else weights
    return {name: tuple(_point(scores, way, float(threshold)) for threshold in THRESHOLDS) for name, way in ways.items()}


def _point(scores: Sequence[ShapeScore], weights: Mapping[str, float], threshold: float) -> Point:
    def passes(answer: JointRecord | FalseAlarm) -> bool:
        own = {} if answer.score is None else {"score": answer.score}
        value = weighted_score({**answer.terms, **own}, weights)
        return value is not None and value > threshold

    records = [record for score in scores for record in score.records]
    answered = [record for record in records if not record.is_missed]
    alarms = [alarm for score in scores for alarm in score.false_alarms]
    accepted = [record for record in answered if passes(record)]
    refused = [record for record in answered if not passes(record)]
    right = sum(record.is_ok for record in accepted)
    count = len(accepted) + sum(passes(alarm) for alarm in alarms)
    return Point(
        threshold=threshold,
        accepted=count,
        refused=len(answered) + len(alarms) - count,
        precision=right / count if count else None,
        recall=right / len(records) if records else None,
        accepted_axis=_mean([axis_degrees(record) for record in accepted]),
        refused_axis=_mean([axis_degrees(record) for record in refused]),
        accepted_line=_mean([_line(record) for record in accepted]),
        refused_line=_mean([_line(record) for record in refused]),
    )


def _line(record: JointRecord) -> float | None:
    return record.line_at_part


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


COLUMNS = (
    Column("score"),
    Column("tau", 2),
    Column("accepted", 0),
    Column("refused", 0),
    Column("precision", 3),
    Column("recall", 3),
    Column("axis, accepted (deg)", 2),
    Column("axis, refused (deg)", 2),
    Column("line, accepted", 3),
    Column("line, refused", 3),
)


def label_truth_table(found: Mapping[str, Sequence[Point]], caption: Caption) -> Table:
    """The points of all curves as a table."""
    rows = tuple(
        (
            name,
            point.threshold,
            point.accepted,
            point.refused,
            point.precision,
            point.recall,
            point.accepted_axis,
            point.refused_axis,
            point.accepted_line,
            point.refused_line,
        )
        for name, points in found.items()
        for point in points
    )
    return Table(caption, COLUMNS, rows)
