"""Figures of scored URDF files (docs/background/metrics.md, "URDF files")."""

from __future__ import annotations

import math
from collections.abc import Callable

from kinmo.evaluation.aggregate import Figure, Unit
from kinmo.evaluation.metrics import MAX_AXIS_ERROR, is_line_ok
from kinmo.evaluation.urdf_scoring.urdf_scores import SCORED, ObjectScore, PartScore

PartValue = Callable[[PartScore], float | None]
PartTest = Callable[[PartScore], bool]


def _is_found(score: PartScore) -> bool:
    return score.found


def _kind_ok(score: PartScore) -> bool:
    return score.kind_ok


def _has_line(score: PartScore) -> bool:
    return score.line is not None


def _any(score: PartScore) -> bool:
    return True


def _turns(score: PartScore) -> bool:
    return score.turns


def _axis_within(limit: float) -> PartTest:
    return lambda score: score.angle is not None and score.angle <= limit


def _line_ok(score: PartScore) -> bool:
    return is_line_ok(score.line)


def _share(key: str, title: str, test: PartTest, among: PartTest) -> Figure[ObjectScore]:
    """The share of the parts `among` which `test` holds."""

    def sums(scored: ObjectScore) -> tuple[float, float]:
        chosen = [part for part in scored.parts if among(part)]
        return sum(map(test, chosen)), len(chosen)

    return Figure(key, title, Unit.SHARE, sums)


def _mean(key: str, title: str, unit: Unit, value: PartValue) -> Figure[ObjectScore]:
    """The mean of a value over the parts that have it."""

    def sums(scored: ObjectScore) -> tuple[float, float]:
        known = [found for part in scored.parts if (found := value(part)) is not None]
        return sum(known), len(known)

    return Figure(key, title, unit, sums)


def _degrees(score: PartScore) -> float | None:
    return None if score.angle is None else math.degrees(score.angle)


def _found_count(scored: ObjectScore) -> int:
    return sum(part.found for part in scored.parts)


def _precision(scored: ObjectScore) -> tuple[float, float]:
    return _found_count(scored), _found_count(scored) + scored.false_alarms


def _f1(scored: ObjectScore) -> tuple[float, float]:
    found = _found_count(scored)
    return 2.0 * found, len(scored.parts) + found + scored.false_alarms


def _recall_scored(scored: ObjectScore) -> tuple[float, float]:
    return (_found_count(scored), len(scored.parts)) if scored.status == SCORED else (0.0, 0.0)


TEN_DEGREES = math.radians(10.0)

FIGURES: tuple[Figure[ObjectScore], ...] = (
    _share("ok", "ok", lambda part: part.is_ok, _any),
    Figure("precision", "P", Unit.SHARE, _precision),
    _share("recall", "R", _is_found, _any),
    Figure("f1", "F1", Unit.SHARE, _f1),
    Figure("recall_scored", "R of scored", Unit.SHARE, _recall_scored),
    _share("relative", "relative", lambda part: part.is_relative, _any),
    _share("type", "type", _kind_ok, _is_found),
    _mean("angle", "angle (deg)", Unit.DEGREES, _degrees),
    _share("a5", "<= 5 deg", _axis_within(MAX_AXIS_ERROR), _kind_ok),
    _share("a10", "<= 10 deg", _axis_within(TEN_DEGREES), _kind_ok),
    _share("strict_a5", "s <= 5 deg", _axis_within(MAX_AXIS_ERROR), _any),
    _share("strict_a10", "s <= 10 deg", _axis_within(TEN_DEGREES), _any),
    _mean("line", "line", Unit.DIAGONALS, lambda part: part.line),
    _share("l05", "line <= .05", _line_ok, _has_line),
    _share("strict_l05", "s <= .05", _line_ok, _turns),
    _mean("pivot", "line at part", Unit.DIAGONALS, lambda part: part.line_at_part),
    _mean("range_iou", "range IoU", Unit.SHARE, lambda part: part.range_iou),
    _share("limited", "limited", lambda part: part.limited_ok, _kind_ok),
    _share("parent", "parent", lambda part: part.parent_ok, _is_found),
)
"""All figures, in the order of columns. "ok" and figures that begin with s are shares of all true parts, misses included."""

MEDIANS: tuple[tuple[str, PartValue], ...] = (("angle_median", _degrees), ("line_median", lambda part: part.line))
"""Values with a median over parts, by key."""
