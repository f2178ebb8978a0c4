"""Truth of pseudo labels: scores of labelled shapes, predicted without their labels, against the true joints.

A joint becomes a pseudo label if its score is above a threshold. A useful score sorts right joints from wrong ones: precision
rises with the threshold, and accepted joints have smaller errors than refused ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.score_summary import axis_degrees
from kinmo.evaluation.shape_tables import Rows, caption_for
from kinmo.evaluation.tables import Caption, Column, Table

THRESHOLDS: NDArray[np.float64] = np.linspace(0.0, 0.9, 19)

WEIGHTS: dict[str, dict[str, float]] = {
    "full": {"feasibility": 0.5, "direction": 0.3, "position": 0.2},
    "feasibility alone": {"feasibility": 1.0},
    "consistency alone": {"direction": 0.3, "position": 0.2},
    "full and sweep": {"feasibility": 0.5, "direction": 0.3, "position": 0.2, "sweep": 0.5},
}
"""Weights of the terms in the paper's score (section 3.3) and in others, by name."""

RANKING_WEIGHTS: dict[str, dict[str, float]] = {
    "full": {"score": 1.0},
    "that it moves, alone": {"moves": 1.0},
    "kind alone": {"kind": 1.0},
    "axis alone": {"axis": 1.0},
    "full and sweep": {"score": 1.0, "sweep": 0.5},
}
"""The same for kinmo's own method; its score is a probability, the term `score`."""


def weighted_score(terms: Mapping[str, float], weights: Mapping[str, float]) -> float | None:
    """Weighted mean of the known terms; None if none is known."""
    known = {name: weight for name, weight in weights.items() if name in terms and weight > 0}
    total = sum(known.values())
    return sum(weight * terms[name] for name, weight in known.items()) / total if total > 0 else None


@dataclass(frozen=True)
class Point:
    """Accepted and refused joints at one threshold.

    Errors are means, in degrees and diagonals; None where there is nothing to average. `precision` is the share of right joints
    among the accepted ones, false alarms included. `recall` is the share of true joints that are accepted and right.
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


def curves(scores: Sequence[ShapeScore], weights: Mapping[str, Mapping[str, float]]) -> dict[str, tuple[Point, ...]]:
    """One curve over `THRESHOLDS` for each set of weights."""
    return {name: tuple(_point(scores, own, float(threshold)) for threshold in THRESHOLDS) for name, own in weights.items()}


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
        accepted_axis=_mean(map(axis_degrees, accepted)),
        refused_axis=_mean(map(axis_degrees, refused)),
        accepted_line=_mean(record.line_at_part for record in accepted),
        refused_line=_mean(record.line_at_part for record in refused),
    )


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


COLUMNS = (  # those after the first are the fields of `Point`
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
    """Points of all curves as a table."""
    return Table(caption, COLUMNS, tuple((name, *astuple(point)) for name, points in found.items() for point in points))


LABELLING_ROWS = {"kinmo": RANKING_WEIGHTS, "OBB_fine": WEIGHTS}
"""Rows of Table 1 whose predictions become pseudo labels, and the weights to compare."""


def label_truth_tables(rows: Rows, caption: Caption) -> dict[str, Table]:
    """A table for each row of Table 1 whose predictions become pseudo labels (see `evaluate_shapes.MoreTables`)."""
    tables = {}
    for name, weights in LABELLING_ROWS.items():
        if name in rows:
            shapes = rows[name].shapes
            title = replace(caption_for(shapes, caption), title=f"{caption.title}: truth of the pseudo labels of {name}")
            tables[f"label_truth_{name}"] = label_truth_table(curves(shapes, weights), title)
    return tables
