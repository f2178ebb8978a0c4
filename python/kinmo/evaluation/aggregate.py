"""Means over joints and over categories, with bootstrap intervals.

Every figure is a ratio of two sums over objects: a share, or a mean over the joints that have a value. Each object adds to both
sums. Leaving objects out, resampling and grouping are therefore sums too, and nothing without a value counts as 0.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Scored = TypeVar("Scored")
Item = TypeVar("Item")
Sums = NDArray[np.float64]  # array [O, F, 2]: numerators and denominators of F figures for each of O objects

BOOTSTRAP_DRAWS = 1000
COVERAGE = 0.95  # share of the bootstrap values inside an interval
SEED = 0  # seed of all bootstrap samples


class Unit(str, Enum):
    """Unit of a figure. Figures of different units are never averaged."""

    SHARE = "share"
    DEGREES = "degrees"
    DIAGONALS = "diagonals"
    LENGTH = "length"


@dataclass(frozen=True)
class Figure(Generic[Scored]):
    """A ratio of sums over objects. `sums` gives the numerator and the denominator of one object."""

    key: str
    title: str
    unit: Unit
    sums: Callable[[Scored], tuple[float, float]]


def mean_figure(
    key: str, title: str, unit: Unit, items: Callable[[Scored], Iterable[Item]], value: Callable[[Item], float | None]
) -> Figure[Scored]:
    """The mean of a value over the items of all objects, such as joints, that have it."""

    def sums(scored: Scored) -> tuple[float, float]:
        known = [found for item in items(scored) if (found := value(item)) is not None]
        return float(sum(known)), len(known)

    return Figure(key, title, unit, sums)


def detection_figures(counts: Callable[[Scored], tuple[int, int, int]]) -> tuple[Figure[Scored], ...]:
    """Precision, recall and F1. `counts` gives the numbers of true joints, of found ones, and of false alarms."""

    def precision(scored: Scored) -> tuple[float, float]:
        _, found, alarms = counts(scored)
        return found, found + alarms

    def recall(scored: Scored) -> tuple[float, float]:
        true, found, _ = counts(scored)
        return found, true

    def f1(scored: Scored) -> tuple[float, float]:
        true, found, alarms = counts(scored)
        return 2 * found, true + found + alarms

    named = (("precision", "P", precision), ("recall", "R", recall), ("f1", "F1", f1))
    return tuple(Figure(key, title, Unit.SHARE, sums) for key, title, sums in named)


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % bootstrap interval. `count` is the number of objects (micro) or categories (macro) in the mean."""

    value: float
    low: float
    high: float
    count: int


Estimates = dict[str, Estimate | None]  # estimates by key of the figure


def figure_sums(objects: Sequence[Scored], figures: Sequence[Figure[Scored]]) -> Sums:
    """Sums [O, F, 2] of all figures for all objects."""
    rows = [[figure.sums(scored) for figure in figures] for scored in objects]
    return np.array(rows, float).reshape(len(objects), len(figures), 2)


def by_key(figures: Sequence[Figure[Scored]], estimates: Sequence[Estimate | None]) -> Estimates:
    """Estimates of figures by their keys."""
    return {figure.key: estimate for figure, estimate in zip(figures, estimates, strict=True)}


def summarise(objects: Sequence[Scored], figures: Sequence[Figure[Scored]], *, draws: int = BOOTSTRAP_DRAWS) -> Estimates:
    """Figures over all objects (`micro`) by their keys."""
    return by_key(figures, micro(figure_sums(objects, figures), draws=draws))


def ratios(sums: Sums) -> NDArray[np.float64]:
    """Numerators over denominators [..., F]; NaN where nothing was counted."""
    numerators, denominators = sums[..., 0], sums[..., 1]
    return np.asarray(np.divide(numerators, denominators, out=np.full(numerators.shape, np.nan), where=denominators > 0))


def micro(sums: Sums, *, draws: int = BOOTSTRAP_DRAWS) -> list[Estimate | None]:
    """Figures over all joints of all objects, from their sums [O, F, 2], with `draws` bootstrap samples of the objects.

    There is one estimate a figure, None where no object has the figure.
    """
    if not len(sums):
        return [None] * sums.shape[1]
    samples = ratios(_resampled(sums, draws, np.random.default_rng(SEED)))
    counts = (sums[..., 1] > 0).sum(axis=0)
    return _estimates(ratios(sums.sum(axis=0)), samples, counts)


def paired_differences(before: Sums, after: Sums) -> list[Estimate | None]:
    """Differences `after` minus `before` of all figures. Every bootstrap sample has the same objects on both sides.

    Both sums [O, F, 2] are of the same objects, in the same order. The `count` of an estimate is the number of objects with the
    figure on both sides.
    """
    if not len(before):
        return [None] * before.shape[1]
    both = np.stack([before, after], axis=1)
    flat = _resampled(both.reshape(len(both), -1, 2), BOOTSTRAP_DRAWS, np.random.default_rng(SEED))
    earlier, later = np.moveaxis(ratios(flat.reshape(BOOTSTRAP_DRAWS, *both.shape[1:])), 1, 0)
    counts = (both[..., 1] > 0).all(axis=1).sum(axis=0)
    return _estimates(np.subtract(*ratios(both.sum(axis=0))[::-1]), later - earlier, counts)


def macro(sums: Sums, categories: Sequence[str], *, min_objects: int = 1) -> list[Estimate | None]:
    """Means over categories of the figures of each category.

    Sums [O, F, 2] are of the objects (`figure_sums`), each with its category; bootstrap samples are drawn within each category.
    Categories with fewer than `min_objects` are left out. A category without a value for a figure does not count in it; the
    `count` of an estimate is the number of those that do.
    """
    rng = np.random.default_rng(SEED)
    names = np.array(categories)
    groups = [sums[names == name] for name in sorted(set(categories))]
    groups = [group for group in groups if len(group) >= min_objects]
    if not groups:
        return [None] * sums.shape[1]
    values = np.array([ratios(group.sum(axis=0)) for group in groups])
    samples = np.array([ratios(_resampled(group, BOOTSTRAP_DRAWS, rng)) for group in groups])
    return _estimates(_mean(values), _mean(samples), (~np.isnan(values)).sum(axis=0))


def median(values: Iterable[float | None]) -> float | None:
    """Median of the known values; None if there is none."""
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _resampled(sums: Sums, draws: int, rng: np.random.Generator) -> Sums:
    """Total sums [draws, F, 2] of `draws` samples of the objects, with replacement."""
    count = len(sums)
    weights = rng.multinomial(count, np.full(count, 1.0 / count), size=draws).astype(float)
    return np.asarray(np.einsum("dn,nfk->dfk", weights, sums))


def _mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean over the first axis without NaN."""
    known = ~np.isnan(values)
    return ratios(np.stack([np.where(known, values, 0.0).sum(axis=0), known.sum(axis=0)], axis=-1))


def _estimates(values: NDArray[np.float64], samples: NDArray[np.float64], counts: NDArray[np.int64]) -> list[Estimate | None]:
    """Estimates of `values` [F] with the intervals of `samples` [draws, F], NaN left out."""
    tail = 50.0 * (1.0 - COVERAGE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a figure that no sample has stays NaN
        ends = np.nanpercentile(samples, [tail, 100.0 - tail], axis=0)
    low, high = np.where(np.isnan(ends), values, ends)
    return [
        None if np.isnan(value) else Estimate(float(value), float(first), float(last), int(count))
        for value, first, last, count in zip(values, low, high, counts, strict=True)
    ]
