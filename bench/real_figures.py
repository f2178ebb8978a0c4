"""Figures of real objects for a table of rows (docs/background/metrics.md). A row is a list of shape scores, of all seeds."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from common import print_table
from kinmo.core.joint import JointKind
from kinmo.evaluation import metrics
from kinmo.evaluation.joint_records import JointRecord, ShapeScore
from kinmo.evaluation.score_summary import MIN_OBJECTS as MACRO_MEANS
from kinmo.evaluation.shape_tables import OVERVIEW, Scores, overview
from kinmo.evaluation.tables import Caption, as_text

MIN_OBJECTS = 3
"""Smallest number of objects of a category in a macro mean."""
Figures = dict[str, float]


def figures_of(scores: Sequence[ShapeScore]) -> Figures:
    """Shares, and means in degrees and diagonals. A screw counts as a slider; a missed joint is a failure in every share."""
    objects = Counter(category for category, _ in {(score.category, score.shape_id) for score in scores})
    records = [record for score in scores for record in score.records]
    found = [record for record in records if record.axis_error is not None]
    hinges = [record for record in records if record.kind is JointKind.REVOLUTE]
    alarms = sum(len(score.false_alarms) for score in scores)
    moving = sum(not record.is_missed for record in records)
    return {
        "joints": float(len(records)),
        "type": _mean(records, _kind_ok),
        "axis": _mean(found, _degrees),
        "axis within 5": _mean(records, lambda r: r.axis_ok),
        "axis macro": _macro(found, _degrees, objects),
        "R within 10": _mean(hinges, lambda r: r.axis_error is not None and r.axis_error <= math.radians(10.0)),
        "line macro": _macro([r for r in hinges if r.line_at_part is not None], lambda r: r.line_at_part or 0.0, objects),
        "ok": _mean(records, _is_ok),
        "ok macro": _macro(records, _is_ok, objects),
        "ok, no controls": _mean([r for r in records if not r.is_control], _is_ok),
        "F1": 2.0 * moving / max(len(records) + moving + alarms, 1),
    }


def _hinge_or_slider(kind: JointKind | None) -> JointKind | None:
    """The kind, with a screw counted as a slider."""
    return JointKind.PRISMATIC if kind is JointKind.SCREW else kind


def _kind_ok(record: JointRecord) -> bool:
    return _hinge_or_slider(record.predicted_kind) is _hinge_or_slider(record.kind)


def _is_ok(record: JointRecord) -> bool:
    true, predicted = _hinge_or_slider(record.kind), _hinge_or_slider(record.predicted_kind)
    assert true is not None, "records are of true joints"
    return metrics.is_ok(true, predicted, record.axis_error, record.line_at_part)


def _degrees(record: JointRecord) -> float:
    return math.degrees(record.axis_error or 0.0)


def _mean(records: Sequence[JointRecord], value: Callable[[JointRecord], float]) -> float:
    return float(np.mean([value(record) for record in records])) if records else math.nan


def _macro(records: Sequence[JointRecord], value: Callable[[JointRecord], float], objects: Mapping[str, int]) -> float:
    by_category: dict[str, list[float]] = defaultdict(list)
    for record in records:
        if objects[record.category] >= MIN_OBJECTS:
            by_category[record.category].append(float(value(record)))
    return float(np.mean([np.mean(values) for values in by_category.values()])) if by_category else math.nan


def print_figures(rows: Mapping[str, Figures]) -> None:
    """Print a line for each row."""
    names = list(next(iter(rows.values())))
    print_table(("", *names), [(row, *figures.values()) for row, figures in rows.items()])


def print_overviews(rows: Mapping[str, Sequence[ShapeScore]], data: str, split: str, seeds: int) -> None:
    """Print the tables of `kinmo eval` for the rows: over joints with 95 % intervals, and over categories."""
    caption = Caption("Rows of this benchmark", data, 0, 0, split, tuple(range(seeds)))
    methods = {name: Scores(merge_seeds(scores)) for name, scores in rows.items()}
    figures = (*OVERVIEW, "line", "line_at_part", "precision", "recall", "f1")
    for count in (None, *MACRO_MEANS):
        print(as_text(overview(methods, caption, figures=figures, macro_over=count)), flush=True)


def merge_seeds(scores: Iterable[ShapeScore]) -> list[ShapeScore]:
    """One score a shape, with the joints of all its seeds. Intervals are over objects, not over runs."""
    merged: dict[str, ShapeScore] = {}
    for score in scores:
        before = merged.get(score.shape_id)
        if before is not None:
            alarms = before.false_alarms + score.false_alarms
            score = replace(before, records=before.records + score.records, false_alarms=alarms)
        merged[score.shape_id] = score
    return list(merged.values())
