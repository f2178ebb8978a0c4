"""Means over joints and over categories, with bootstrap intervals.

Every figure is a ratio of two sums over objects: a share, or a mean over the joints that have a value. Each object adds to both
sums. Leaving objects out, resampling and grouping are therefore sums too, and nothing without a value counts as 0.
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
"""Array [O, F, 2]: numerators and denominators of F figures for each of O objects."""

BOOTSTRAP_DRAWS = 1000
COVERAGE = 0.95
"""Share of the bootstrap values inside an interval."""


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


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % bootstrap interval. `count` is the number of objects (micro) or categories (macro) in the mean."""

    value: float
    low: float
    high: float
    count: int

    def interval(self, decimals: int) -> str:
        """The interval as printed text."""
        return f"{self.low:.{decimals}f} to {self.high:.{decimals}f}"


def figure_sums(objects: Sequence[Scored], figures: Sequence[Figure[Scored]]) -> Sums:
    """Sums [O, F, 2] of all figures for all objects."""
    rows = [[figure.sums(scored) for figure in figures] for scored in objects]
    return np.array(rows, float).reshape(len(objects), len(figures), 2)


def ratios(sums: Sums) -> NDArray[np.float64]:
    """Numerators over denominators [..., F]; NaN where nothing was counted."""
    numerators, denominators = sums[..., 0], sums[..., 1]
    return np.asarray(np.divide(numerators, denominators, out=np.full(numerators.shape, np.nan), where=denominators > 0))


def micro(sums: Sums, *, draws: int = BOOTSTRAP_DRAWS, seed: int = 0) -> list[Estimate | None]:
    """Figures over all joints of all objects.

    Args:
        sums: Sums [O, F, 2] of the objects (`figure_sums`).
        draws: Number of bootstrap samples of the objects.
        seed: Seed of the samples.

    Returns:
        One estimate a figure; None where no object has the figure.
    """
    if not len(sums):
        return [None] * sums.shape[1]
    samples = ratios(_resampled(sums, draws, np.random.default_rng(seed)))
    counts = (sums[..., 1] > 0).sum(axis=0)
    return _estimates(ratios(sums.sum(axis=0)), samples, counts)


def paired_differences(before: Sums, after: Sums, *, draws: int = BOOTSTRAP_DRAWS, seed: int = 0) -> list[Estimate | None]:
    """Differences `after` minus `before` of all figures. Every bootstrap sample has the same objects on both sides.

    Args:
        before: Sums [O, F, 2] of the objects.
        after: Sums [O, F, 2] of the same objects, in the same order.
        draws: Number of bootstrap samples of the objects.
        seed: Seed of the samples.

    Returns:
        One estimate a figure. `count` is the number of objects with the figure on both sides.
    """
    if not len(before):
        return [None] * before.shape[1]
    both = np.stack([before, after], axis=1)
    samples = _resampled(both.reshape(len(both), -1, 2), draws, np.random.default_rng(seed)).reshape(draws, *both.shape[1:])
    earlier, later = np.moveaxis(ratios(samples), 1, 0)
    counts = (both[..., 1] > 0).all(axis=1).sum(axis=0)
    return _estimates(np.subtract(*ratios(both.sum(axis=0))[::-1]), later - earlier, counts)


def macro(
    sums: Sums, categories: Sequence[str], *, min_objects: int = 1, draws: int = BOOTSTRAP_DRAWS, seed: int = 0
) -> list[Estimate | None]:
    """Means over categories of the figures of each category.

    Args:
        sums: Sums [O, F, 2] of the objects (`figure_sums`).
        categories: Category of each object.
        min_objects: Categories with fewer objects are left out.
        draws: Number of bootstrap samples. Objects are drawn within their category.
        seed: Seed of the samples.

    Returns:
        One estimate a figure. A category without a value for a figure does not count in it; `count` is the number that do.
    """
    rng = np.random.default_rng(seed)
    names = np.array(categories)
    groups = [sums[names == name] for name in sorted(set(categories))]
    groups = [group for group in groups if len(group) >= min_objects]
    if not groups:
        return [None] * sums.shape[1]
    values = np.array([ratios(group.sum(axis=0)) for group in groups])
    samples = np.array([ratios(_resampled(group, draws, rng)) for group in groups])
    return _estimates(_mean(values), _mean(samples), (~np.isnan(values)).sum(axis=0))


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
