"""Random choices of a family, from ranges that can be narrowed as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import TypeVar

import numpy as np

Item = TypeVar("Item")


class ParameterRange(str, Enum):
    """Which part of every continuous range shapes are drawn from: labelled and unlabelled shapes overlap, and differ."""

    LABELLED = "labelled"
    UNLABELLED = "unlabelled"
    BOTH = "both"

    @property
    def window(self) -> tuple[float, float]:
        """The part of a range, as fractions of it."""
        return {"labelled": (0.0, 0.7), "unlabelled": (0.3, 1.0), "both": (0.0, 1.0)}[self.value]


class Draw:
    """A source of random values. All of a family's randomness comes from here, so that a seed decides the shape."""

    def __init__(self, rng: np.random.Generator, parameter_range: ParameterRange = ParameterRange.BOTH) -> None:
        self.generator = rng
        self._low, self._high = parameter_range.window

    def between(self, low: float, high: float) -> float:
        """A parameter of the shape, uniform in the window of [low, high]."""
        return low + (high - low) * float(self.generator.uniform(self._low, self._high))

    def integer(self, low: int, high: int) -> int:
        """Uniform in low..high, both included."""
        return int(self.generator.integers(low, high + 1))

    def chance(self, probability: float) -> bool:
        """True with the given probability."""
        return bool(self.generator.random() < probability)

    def sign(self) -> float:
        """-1 or 1."""
        return 1.0 if self.chance(0.5) else -1.0

    def pick(self, options: Sequence[Item], weights: Sequence[float] | None = None) -> Item:
        """One of `options`, with `weights` in proportion to which they are picked."""
        if weights is None:
            return options[int(self.generator.integers(len(options)))]
        edges = np.cumsum(weights)
        return options[int(np.searchsorted(edges, self.generator.random() * edges[-1], side="right"))]

    def alike(self, count: int) -> list[Draw]:
        """`count` sources that give the same values: for parts of which an object has several."""
        seed = self.integer(0, 1 << 62)
        copies = [Draw(np.random.default_rng(seed)) for _ in range(count)]
        for copy in copies:
            copy._low, copy._high = self._low, self._high
        return copies
