"""Random choices of a family, from ranges that can be narrowed as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import TypeVar

import numpy as np

Item = TypeVar("Item")


class ParameterRange(str, Enum):
    """Window of every continuous range that shapes are drawn from.

    The windows of labelled and unlabelled shapes overlap but differ, as annotated and unannotated data do.
    """

    LABELLED = "labelled"
    UNLABELLED = "unlabelled"
    BOTH = "both"

    @property
    def window(self) -> tuple[float, float]:
        """Start and end of the window, as fractions of a range."""
        return {"labelled": (0.0, 0.7), "unlabelled": (0.3, 1.0), "both": (0.0, 1.0)}[self.value]


class Draw:
    """Source of all random values of a family. One seed gives one shape.

    Args:
        rng: Generator of the random numbers.
        parameter_range: Window of the ranges given to `between`.

    Example:
        >>> draw = Draw(np.random.default_rng(0))
        >>> width = draw.between(0.6, 1.2)
        >>> side = draw.pick(["left", "right"], [1, 2])
    """

    def __init__(self, rng: np.random.Generator, parameter_range: ParameterRange = ParameterRange.BOTH) -> None:
        self.generator = rng
        self._low, self._high = parameter_range.window

    def between(self, low: float, high: float) -> float:
        """Uniform value from the window of [low, high]."""
        return low + (high - low) * float(self.generator.uniform(self._low, self._high))

    def ratio(self, low: float, high: float) -> float:
        """Log-uniform value from the window of [low, high], for proportions. Both ends are positive."""
        return float(np.exp(self.between(np.log(low), np.log(high))))

    def integer(self, low: int, high: int) -> int:
        """Uniform integer from `low` to `high`, both included."""
        return int(self.generator.integers(low, high + 1))

    def chance(self, probability: float) -> bool:
        """True with the given probability."""
        return bool(self.generator.random() < probability)

    def sign(self) -> float:
        """-1 or 1, with equal probability."""
        return 1.0 if self.chance(0.5) else -1.0

    def pick(self, options: Sequence[Item], weights: Sequence[float] | None = None) -> Item:
        """One of several options.

        Args:
            options: The options.
            weights: Relative frequency of each option; None for equal ones.

        Returns:
            The option that was picked.
        """
        if weights is None:
            return options[int(self.generator.integers(len(options)))]
        edges = np.cumsum(weights)
        return options[int(np.searchsorted(edges, self.generator.random() * edges[-1], side="right"))]

    def identical(self, count: int) -> list[Draw]:
        """Sources that all give the same values, for parts that an object has several times.

        Args:
            count: Number of sources.

        Returns:
            New, independent sources with one seed and the same window.
        """
        seed = self.integer(0, 1 << 62)
        copies = [Draw(np.random.default_rng(seed)) for _ in range(count)]
        for copy in copies:
            copy._low, copy._high = self._low, self._high
        return copies
