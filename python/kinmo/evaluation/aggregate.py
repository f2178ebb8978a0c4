"""Means over joints and over categories, with intervals.

Every figure is a ratio of two sums over objects: a share, or a mean over those joints that have the figure. An object adds to
both sums, so that leaving objects out, drawing them again and grouping them are all sums too, and nothing without a value
counts as 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Scored = TypeVar("Scored")
Sums = NDArray[np.float64]
"""[O, F, 2]: numerator and denominator of F figures for each of O objects."""

DRAWS = 1000
COVERAGE = 0.95


class Unit(str, Enum):
    """What a figure counts. Figures of different units are never averaged."""

    SHARE = "share"
    DEGREES = "degrees"
    DIAGONALS = "diagonals"
    LENGTH = "length"


@dataclass(frozen=True)
class Figure(Generic[Scored]):
    """A ratio of sums. `sums` gives numerator and denominator of one object."""

    key: str
    title: str
    unit: Unit
    sums: Callable[[Scored], tuple[float, float]]


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % bootstrap interval. `count` is what the mean is over: objects (micro) or categories (macro)."""

    value: float
    low: float
    high: float
    count: int

    def interval(self, decimals: int) -> str:
        """The interval as it is printed."""
        return f"{self.low:.{decimals}f} to {self.high:.{decimals}f}"


def sums_of(objects: Sequence[Scored], figures: Sequence[Figure[Scored]]) -> Sums:
    """The sums of all figures for all objects."""
    rows = [[figure.sums(scored) for figure in figures] for scored in objects]
    return np.array(rows, float).reshape(len(objects), len(figures), 2)


def ratios(sums: Sums) -> NDArray[np.float64]:
    """Numerators over denominators [..., F]; NaN where nothing was counted."""
    numerators, denominators = sums[..., 0], sums[..., 1]
    return np.asarray(np.divide(numerators, denominators, out=np.full(numerators.shape, np.nan), where=denominators > 0))


def resampled(sums: Sums, draws: int, rng: np.random.Generator) -> Sums:
    """Total sums [draws, F, 2] of `draws` samples of the objects, with replacement."""
    count = len(sums)
    weights = rng.multinomial(count, np.full(count, 1.0 / count), size=draws).astype(float)
    return np.asarray(np.einsum("dn,nfk->dfk", weights, sums))


def micro(sums: Sums, *, draws: int = DRAWS, seed: int = 0) -> list[Estimate | None]:
    """Every figure over all joints of all objects; None where no object has it."""
    if not len(sums):
        return [None] * sums.shape[1]
    samples = ratios(resampled(sums, draws, np.random.default_rng(seed)))
    counts = (sums[..., 1] > 0).sum(axis=0)
    return _estimates(ratios(sums.sum(axis=0)), samples, counts)


def changes(before: Sums, after: Sums, *, draws: int = DRAWS, seed: int = 0) -> list[Estimate | None]:
    """By how much every figure of some objects is larger in `after` than in `before`; the same objects are drawn for both.

    `count` is of the objects that have the figure in both.
    """
    if not len(before):
        return [None] * before.shape[1]
    both = np.stack([before, after], axis=1)
    samples = resampled(both.reshape(len(both), -1, 2), draws, np.random.default_rng(seed)).reshape(draws, *both.shape[1:])
    earlier, later = np.moveaxis(ratios(samples), 1, 0)
    counts = (both[..., 1] > 0).all(axis=1).sum(axis=0)
    return _estimates(np.subtract(*ratios(both.sum(axis=0))[::-1]), later - earlier, counts)


def macro(
    sums: Sums, categories: Sequence[str], *, least_objects: int = 1, draws: int = DRAWS, seed: int = 0
) -> list[Estimate | None]:
    """Mean over categories of the figure of each category, over those with at least `least_objects` objects.

    Objects are drawn inside their category. A category without a value for a figure is left out of that figure, and the count
    says how many are in.
    """
    rng = np.random.default_rng(seed)
    names = np.array(categories)
    groups = [sums[names == name] for name in sorted(set(categories))]
    groups = [group for group in groups if len(group) >= least_objects]
    if not groups:
        return [None] * sums.shape[1]
    values = np.array([ratios(group.sum(axis=0)) for group in groups])
    samples = np.array([ratios(resampled(group, draws, rng)) for group in groups])
    return _estimates(_mean(values), _mean(samples), (~np.isnan(values)).sum(axis=0))


def _mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean over the first axis of what is not NaN."""
    known = ~np.isnan(values)
    return ratios(np.stack([np.where(known, values, 0.0).sum(axis=0), known.sum(axis=0)], axis=-1))


def _estimates(values: NDArray[np.float64], samples: NDArray[np.float64], counts: NDArray[np.int64]) -> list[Estimate | None]:
    """`values` [F] with the intervals of `samples` [draws, F], of which those that are NaN do not count."""
    low, high = _quantiles(samples)
    low, high = (np.where(np.isnan(bound), values, bound) for bound in (low, high))
    return [
        None if np.isnan(values[row]) else Estimate(float(values[row]), float(low[row]), float(high[row]), int(counts[row]))
        for row in range(len(values))
    ]


def _quantiles(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Both ends of the interval [2, F]; NaN where no sample has a value."""
    tail = 50.0 * (1.0 - COVERAGE)
    ends = [tail, 100.0 - tail]
    found = np.full((2, samples.shape[1]), np.nan)
    missing = np.isnan(samples)
    whole = ~missing.any(axis=0)
    if len(samples):
        found[:, whole] = np.percentile(samples[:, whole], ends, axis=0)
    for column in np.flatnonzero(missing.any(axis=0) & ~missing.all(axis=0)):
        found[:, column] = np.percentile(samples[~missing[:, column], column], ends)
    return found
