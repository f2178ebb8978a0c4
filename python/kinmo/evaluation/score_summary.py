"""Figures of shape scores: means, shares and medians (docs/background/metrics.md, "Tables")."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from kinmo.core.joint import JointKind
from kinmo.evaluation.aggregate import (
    Estimates,
    Figure,
    Unit,
    by_key,
    detection_figures,
    figure_sums,
    macro,
    mean_figure,
    median,
    micro,
)
from kinmo.evaluation.joint_records import JointRecord, ShapeScore

MIN_OBJECTS = (8, 3)
"""Macro means are over the categories with at least this many objects; there is one for each number."""

Value = Callable[[JointRecord], float | None]


def _mean(key: str, title: str, unit: Unit, value: Value) -> Figure[ShapeScore]:
    """The mean of a value over the joints that have it."""
    return mean_figure(key, title, unit, lambda score: score.records, value)


def _share(key: str, title: str, test: Callable[[JointRecord], bool]) -> Figure[ShapeScore]:
    """The share of all true joints for which `test` holds. A missed joint is a failure."""
    return _mean(key, title, Unit.SHARE, lambda record: float(test(record)))


def _fine_types(score: ShapeScore) -> tuple[float, float]:
    """Right types among ten; nothing for a method that distinguishes five."""
    return (sum(record.fine_type_ok for record in score.records), len(score.records)) if score.has_fine_types else (0, 0)


def _detections(score: ShapeScore) -> tuple[int, int, int]:
    return len(score.records), sum(not record.is_missed for record in score.records), len(score.false_alarms)


def axis_degrees(record: JointRecord) -> float | None:
    """The axis error in degrees, None for a missed joint."""
    return _degrees(record.axis_error)


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)


def _hinge_within_ten_degrees(record: JointRecord) -> float | None:
    if record.kind is not JointKind.REVOLUTE:
        return None
    return float(record.axis_error is not None and record.axis_error <= math.radians(10.0))


def _raw_line(record: JointRecord) -> float | None:
    return None if record.line_distance is None else record.line_distance * record.diagonal


FIGURES: tuple[Figure[ShapeScore], ...] = (
    _share("ok", "ok", lambda record: record.is_ok),
    _share("coarse_type", "type (5)", lambda record: record.coarse_type_ok),
    Figure("fine_type", "type (10)", Unit.SHARE, _fine_types),
    _share("missed", "missed", lambda record: record.is_missed),
    _mean("axis", "axis (deg)", Unit.DEGREES, axis_degrees),
    _mean("typed_axis", "axis, type given (deg)", Unit.DEGREES, lambda record: _degrees(record.typed_axis_error)),
    _share("axis_ok", "axis <= 5 deg", lambda record: record.axis_ok),
    _share("axis_and_line_ok", "axis and line", lambda record: record.axis_and_line_ok),
    _mean("hinge_within_10", "R: axis <= 10 deg", Unit.SHARE, _hinge_within_ten_degrees),
    _mean("line", "line", Unit.DIAGONALS, lambda record: record.line_distance),
    _mean("line_at_part", "line at part", Unit.DIAGONALS, lambda record: record.line_at_part),
    _mean("pivot", "point to line", Unit.DIAGONALS, lambda record: record.pivot_distance),
    _mean("raw_line", "line (file's lengths)", Unit.LENGTH, _raw_line),
    _mean("range_iou", "range IoU", Unit.SHARE, lambda record: record.range_iou),
    _mean("parent", "parent", Unit.SHARE, lambda record: record.parent_ok),
    _mean("penetration", "penetration", Unit.SHARE, lambda record: record.penetration),
    Figure("edge_type", "edges", Unit.SHARE, lambda score: (score.edges_right, score.edges)),
    *detection_figures(_detections),
)
"""All figures, in the order of columns. Shares (ok, type, "axis <= 5 deg", "axis and line", R) are of all true joints."""

FIGURE_BY_KEY: dict[str, Figure[ShapeScore]] = {figure.key: figure for figure in FIGURES}
MEDIANS: dict[str, Value] = {"axis": axis_degrees, "line": lambda record: record.line_distance}
"""Values that also have a median over joints, by key."""


@dataclass(frozen=True)
class Summary:
    """The figures of one method on one set of shapes.

    Each object (shape) and each true joint counts once, whatever the number of `runs` (seeds). `failures` are scores without a
    prediction. Figures are over joints (`micro`), and over categories (`macro`) by their smallest number of objects.
    """

    objects: int
    joints: int
    runs: int
    failures: int
    micro: Estimates
    macro: dict[int, Estimates]
    medians: dict[str, float | None]
    categories: dict[str, CategorySummary]

    def to_json(self) -> dict[str, Any]:
        """The summary as plain data for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class CategorySummary:
    """The figures of one category, over joints."""

    objects: int
    joints: int
    micro: Estimates


def summarise_scores(scores: Sequence[ShapeScore]) -> Summary:
    """Summarise the scores of one method. A shape may occur several times, once a seed, and then counts as one object."""
    by_shape: dict[str, list[ShapeScore]] = {}
    for score in scores:
        by_shape.setdefault(score.shape_id, []).append(score)
    categories = [runs[0].category for runs in by_shape.values()]
    sums = np.array([figure_sums(runs, FIGURES).sum(axis=0) for runs in by_shape.values()]).reshape(-1, len(FIGURES), 2)
    joints = np.array([len(runs[0].records) for runs in by_shape.values()], int)

    def category(name: str) -> CategorySummary:
        inside = np.array(categories) == name
        return CategorySummary(int(inside.sum()), int(joints[inside].sum()), by_key(FIGURES, micro(sums[inside])))

    return Summary(
        objects=len(by_shape),
        joints=int(joints.sum()),
        runs=max(map(len, by_shape.values()), default=0),
        failures=sum(score.failure is not None for score in scores),
        micro=by_key(FIGURES, micro(sums)),
        macro={count: by_key(FIGURES, macro(sums, categories, min_objects=count)) for count in MIN_OBJECTS},
        medians={key: median(value(record) for score in scores for record in score.records) for key, value in MEDIANS.items()},
        categories={name: category(name) for name in sorted(set(categories))},
    )


def without_controls(scores: Sequence[ShapeScore]) -> list[ShapeScore]:
    """The scores without buttons, knobs and switches, and without the shapes whose joints are all of these."""
    rest = [(score, score.without_controls()) for score in scores]
    return [kept for score, kept in rest if kept.records or not score.records]
