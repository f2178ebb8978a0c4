"""The figures of URDF files (docs/metrics.md, "URDF files")."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from kinmo.evaluation.aggregate import Figure, Unit
from kinmo.evaluation.urdf_scoring.urdf_scores import SCORED, ObjectScore, PartScore

Part = Callable[[PartScore], float | None]
Test = Callable[[PartScore], bool]

NEAR_LINE = 0.05


def _found(score: PartScore) -> bool:
    return score.found


def _right(score: PartScore) -> bool:
    return score.kind_ok


def _with_line(score: PartScore) -> bool:
    return score.line is not None


def _every(score: PartScore) -> bool:
    return True


def _turning(score: PartScore) -> bool:
    return score.turns


def _within(degrees: float) -> Test:
    return lambda score: score.angle is not None and math.degrees(score.angle) < degrees


def _near(score: PartScore) -> bool:
    return score.line is not None and score.line < NEAR_LINE


def _share(key: str, title: str, test: Test, among: Test) -> Figure[ObjectScore]:
    """The share of the parts `among` which `test` holds."""

    def sums(scored: ObjectScore) -> tuple[float, float]:
        chosen = [part for part in scored.parts if among(part)]
        return sum(map(test, chosen)), len(chosen)

    return Figure(key, title, Unit.SHARE, sums)


def _mean(key: str, title: str, unit: Unit, value: Part) -> Figure[ObjectScore]:
    """The mean of a value over the parts that have it."""

    def sums(scored: ObjectScore) -> tuple[float, float]:
        known = _known(value(part) for part in scored.parts)
        return sum(known), len(known)

    return Figure(key, title, unit, sums)


def _known(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


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


FIGURES: tuple[Figure[ObjectScore], ...] = (
    Figure("precision", "P", Unit.SHARE, _precision),
    _share("recall", "R", _found, _every),
    Figure("f1", "F1", Unit.SHARE, _f1),
    Figure("recall_scored", "R of scored", Unit.SHARE, _recall_scored),
    _share("relative", "relative", lambda part: part.is_relative, _every),
    _share("type", "type", _right, _found),
    _mean("angle", "angle (deg)", Unit.DEGREES, _degrees),
    _share("a5", "< 5 deg", _within(5.0), _right),
    _share("a10", "< 10 deg", _within(10.0), _right),
    _share("strict_a5", "s < 5 deg", _within(5.0), _every),
    _share("strict_a10", "s < 10 deg", _within(10.0), _every),
    _mean("line", "line", Unit.DIAGONALS, lambda part: part.line),
    _share("l05", "line < .05", _near, _with_line),
    _share("strict_l05", "s < .05", _near, _turning),
    _mean("pivot", "line at part", Unit.DIAGONALS, lambda part: part.line_at_part),
    _mean("range_iou", "range IoU", Unit.SHARE, lambda part: part.range_iou),
    _share("limited", "limited", lambda part: part.limited_ok, _right),
    _share("parent", "parent", lambda part: part.parent_ok, _found),
)
"""s: over all true parts, misses counted as failures."""

MEDIANS: tuple[tuple[str, Part], ...] = (("angle_median", _degrees), ("line_median", lambda part: part.line))
"""Medians over parts, by key."""
