"""Oriented boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector

CORNER_SIGNS: NDArray[np.float64] = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
SAME_SIZE = 0.15
"""Boxes whose sorted extents differ by less than this (in logarithms) are alike."""
SMALLEST = 0.003


@dataclass(frozen=True, eq=False)
class Box:
    """An oriented box: `center` [3], `axes` [3, 3] with unit rows (right-handed), `half_extents` [3] along them."""

    center: Vector
    axes: NDArray[np.float64]
    half_extents: Vector

    def corners(self) -> NDArray[np.float64]:
        """The eight corners [8, 3], in the order of `CORNER_SIGNS`."""
        return self.center + (CORNER_SIGNS * self.half_extents) @ self.axes

    @property
    def volume(self) -> float:
        return float(8.0 * np.prod(self.half_extents))


def are_alike(half_extents: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of the boxes with half extents `others` [..., 3] are as large as one with `half_extents` [3], in diagonals.

    Order and place do not matter; what is smaller than SMALLEST counts as that.
    """
    here, there = np.sort(half_extents)[::-1] + SMALLEST, np.sort(others, axis=-1)[..., ::-1] + SMALLEST
    alike: NDArray[np.bool_] = np.asarray((np.abs(np.log(there / here)) < SAME_SIZE).all(axis=-1))
    return alike
