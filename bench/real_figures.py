"""The figures of docs/metrics.md for a table of rows, each row a list of scored shapes (those of several seeds together)."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinmo.core.joint import JointKind
from kinmo.evaluation.joint_records import JointRecord, ShapeScore
from kinmo.evaluation.summary import LEAST_OBJECTS as MACRO_OVER
from kinmo.evaluation.tables import Caption, as_text
from kinmo.experiments.table1.table1_tables import OVERVIEW, Scores, overview

LEAST_OBJECTS = 3
"""Of a category that counts in a macro mean."""
Figures = dict[str, float]


def figures_of(scores: Sequence[ShapeScore]) -> Figures:
    """Shares, and means in degrees and diagonals; a screw counts as a slider, a missed joint as a failure of every share."""
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
        "axis within 5": _mean(records, lambda r: r.axis_error is not None and r.axis_error <= math.radians(5.0)),
        "axis macro": _macro(found, _degrees, objects),
        "R within 10": _mean(hinges, lambda r: r.axis_error is not None and r.axis_error <= math.radians(10.0)),
        "line macro": _macro([r for r in hinges if r.line_at_part is not None], lambda r: r.line_at_part or 0.0, objects),
        "ok": _mean(records, _is_ok),
        "ok macro": _macro(records, _is_ok, objects),
        "ok, no controls": _mean([r for r in records if not r.is_control], _is_ok),
        "F1": 2.0 * moving / max(len(records) + moving + alarms, 1),
    }


def _kind_ok(record: JointRecord) -> bool:
    """Whether R, or one of P and PR, was told right."""
    coarse = record.predicted_coarse
    if coarse is None or record.is_missed:
        return False
    return (coarse.name == "R") == (record.kind is JointKind.REVOLUTE)


def _is_ok(record: JointRecord) -> bool:
    if not _kind_ok(record) or record.axis_error is None or record.axis_error > math.radians(5.0):
        return False
    return record.kind is not JointKind.REVOLUTE or (record.line_at_part is not None and record.line_at_part <= 0.05)


def _degrees(record: JointRecord) -> float:
    return math.degrees(record.axis_error or 0.0)


def _mean(records: Sequence[JointRecord], value: Callable[[JointRecord], float]) -> float:
    return float(np.mean([value(record) for record in records])) if records else math.nan


def _macro(records: Sequence[JointRecord], value: Callable[[JointRecord], float], objects: Mapping[str, int]) -> float:
    by_category: dict[str, list[float]] = defaultdict(list)
    for record in records:
        if objects[record.category] >= LEAST_OBJECTS:
            by_category[record.category].append(float(value(record)))
    return float(np.mean([np.mean(values) for values in by_category.values()])) if by_category else math.nan


def print_figures(rows: Mapping[str, Figures]) -> None:
    """One line a row."""
    names = list(next(iter(rows.values())))
    width = max(len(row) for row in rows)
    print(" " * width, *(f"{name:>16}" for name in names))
    for row, figures in rows.items():
        print(f"{row:<{width}}", *(f"{figures[name]:>16.4g}" for name in names), flush=True)


def print_overviews(rows: Mapping[str, Sequence[ShapeScore]], data: str, split: str, seeds: int) -> None:
    """The tables that `kinmo eval` prints of the same rows: over joints with 95 % intervals, and over categories."""
    caption = Caption("Rows of this bench", data, 0, 0, split, tuple(range(seeds)))
    methods = {name: Scores(over_seeds(scores)) for name, scores in rows.items()}
    figures = (*OVERVIEW, "line", "line_at_part", "precision", "recall", "f1")
    for least in (None, *MACRO_OVER):
        print(as_text(overview(methods, caption, figures=figures, macro_over=least)), flush=True)


def over_seeds(scores: Iterable[ShapeScore]) -> list[ShapeScore]:
    """One score a shape, with the joints of all its seeds: objects, not runs, are what an interval draws again."""
    merged: dict[str, ShapeScore] = {}
    for score in scores:
        before = merged.get(score.shape_id)
        merged[score.shape_id] = score if before is None else replace(
            before, records=before.records + score.records, false_alarms=before.false_alarms + score.false_alarms
        )  # fmt: skip
    return list(merged.values())
