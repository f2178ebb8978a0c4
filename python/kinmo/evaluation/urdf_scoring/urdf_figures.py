"""Figures of scored URDF files (docs/background/metrics.md, "URDF files"), and their tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import Any

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
    summarise,
)
from kinmo.evaluation.hierarchy_given import MIN_IOU
from kinmo.evaluation.metrics import MAX_AXIS_ERROR, is_line_ok
from kinmo.evaluation.tables import Caption, Column, Table
from kinmo.evaluation.urdf_scoring.urdf_folders import UrdfReport
from kinmo.evaluation.urdf_scoring.urdf_scores import FAILED, MISSING, SCORED, ObjectScore, PartScore

PartValue = Callable[[PartScore], float | None]
PartTest = Callable[[PartScore], bool]

TEN_DEGREES = math.radians(10.0)
COUNTS = ("objects", SCORED, FAILED, MISSING, "parts", "found", "false_positives")
DECIMALS = {Unit.SHARE: 3, Unit.DEGREES: 2, Unit.DIAGONALS: 4}
MEDIAN_COLUMNS = {"angle_median": Column("median angle", 2), "line_median": Column("median line", 4)}


def _mean(key: str, title: str, unit: Unit, value: PartValue) -> Figure[ObjectScore]:
    """The mean of a value over the parts that have it."""
    return mean_figure(key, title, unit, lambda scored: scored.parts, value)


def _share(key: str, title: str, test: PartTest, among: PartTest = lambda part: True) -> Figure[ObjectScore]:
    """The share of the parts `among` which `test` holds."""
    return _mean(key, title, Unit.SHARE, lambda part: test(part) if among(part) else None)


def _degrees(part: PartScore) -> float | None:
    return None if part.angle is None else math.degrees(part.angle)


def _axis_within(limit: float) -> PartTest:
    return lambda part: part.angle is not None and part.angle <= limit


def _detections(scored: ObjectScore) -> tuple[int, int, int]:
    return len(scored.parts), sum(part.found for part in scored.parts), scored.false_alarms


def _recall_scored(scored: ObjectScore) -> tuple[float, float]:
    true, found, _ = _detections(scored)
    return (found, true) if scored.status == SCORED else (0, 0)


FIGURES: tuple[Figure[ObjectScore], ...] = (
    _share("ok", "ok", lambda part: part.is_ok),
    *detection_figures(_detections),
    Figure("recall_scored", "R of scored", Unit.SHARE, _recall_scored),
    _share("relative", "relative", lambda part: part.is_relative),
    _share("type", "type", lambda part: part.kind_ok, lambda part: part.found),
    _mean("angle", "angle (deg)", Unit.DEGREES, _degrees),
    _share("a5", "<= 5 deg", _axis_within(MAX_AXIS_ERROR), lambda part: part.kind_ok),
    _share("a10", "<= 10 deg", _axis_within(TEN_DEGREES), lambda part: part.kind_ok),
    _share("strict_a5", "s <= 5 deg", _axis_within(MAX_AXIS_ERROR)),
    _share("strict_a10", "s <= 10 deg", _axis_within(TEN_DEGREES)),
    _mean("line", "line", Unit.DIAGONALS, lambda part: part.line),
    _share("l05", "line <= .05", lambda part: is_line_ok(part.line), lambda part: part.line is not None),
    _share("strict_l05", "s <= .05", lambda part: is_line_ok(part.line), lambda part: part.turns),
    _mean("pivot", "line at part", Unit.DIAGONALS, lambda part: part.line_at_part),
    _mean("range_iou", "range IoU", Unit.SHARE, lambda part: part.range_iou),
    _share("limited", "limited", lambda part: part.limited_ok, lambda part: part.kind_ok),
    _share("parent", "parent", lambda part: part.parent_ok, lambda part: part.found),
)
"""All figures, in the order of columns. "ok" and figures that begin with s are shares of all true parts, misses included."""

MEDIANS: tuple[tuple[str, PartValue], ...] = (("angle_median", _degrees), ("line_median", lambda part: part.line))
"""Values with a median over parts, by key."""


def summarise_urdf_scores(report: UrdfReport) -> dict[str, Any]:
    """Figures of a report as plain data for JSON: over parts (micro), over categories (macro), and by category."""
    categories = [scored.category for scored in report.objects]
    by_category = {
        name: _group([scored for scored in report.objects if scored.category == name]) for name in sorted(set(categories))
    }
    return {
        "match": MIN_IOU,
        "micro": _group(report.objects),
        "macro": _plain(by_key(FIGURES, macro(figure_sums(report.objects, FIGURES), categories))),
        "categories": by_category,
        "objects": [asdict(scored) for scored in report.objects],
        "unreadable": report.unreadable,
    }


def _group(objects: Sequence[ObjectScore]) -> dict[str, Any]:
    parts = [part for scored in objects for part in scored.parts]
    counts: dict[str, Any] = {"objects": len(objects)}
    counts |= {status: sum(scored.status == status for scored in objects) for status in (SCORED, FAILED, MISSING)}
    counts |= {"parts": len(parts), "found": sum(part.found for part in parts)}
    counts["false_positives"] = sum(scored.false_alarms for scored in objects)
    counts |= {key: median(map(value, parts)) for key, value in MEDIANS}
    return counts | _plain(summarise(objects, FIGURES))


def _plain(estimates: Estimates) -> dict[str, Any]:
    return {key: None if found is None else asdict(found) for key, found in estimates.items()}


def urdf_table(summary: dict[str, Any], report: UrdfReport, caption: Caption) -> Table:
    """All figures of a report's summary by category, over all parts, and as a mean of categories; the caption gets counts."""
    columns = {key: Column(key.replace("_", " "), 0) for key in COUNTS}
    columns |= {figure.key: Column(figure.title, DECIMALS[figure.unit]) for figure in FIGURES} | MEDIAN_COLUMNS
    groups = {**summary["categories"], "all parts": summary["micro"], "mean of categories": summary["macro"]}
    rows = []
    for name, group in groups.items():
        values = {key: value["value"] if isinstance(value, dict) else value for key, value in group.items()}
        rows.append({"category": name, **{column.title: values.get(key) for key, column in columns.items()}})
    parts = sum(len(scored.parts) for scored in report.objects)
    caption = replace(caption, shapes=len(report.objects), joints=parts)
    return Table.of(caption, (Column("category"), *columns.values()), rows)


def urdf_failures_table(report: UrdfReport, caption: Caption) -> Table:
    """The objects that were not scored, with reasons; the caption gets counts."""
    failed = [scored for scored in report.objects if scored.status != SCORED]
    rows = [(scored.id, scored.category, scored.status, scored.reason) for scored in failed]
    rows += [(name, "", "truth not readable", reason) for name, reason in report.unreadable.items()]
    caption = replace(caption, shapes=len(rows), joints=sum(len(scored.parts) for scored in failed))
    return Table(caption, tuple(map(Column, ("object", "category", "status", "reason"))), tuple(rows))
