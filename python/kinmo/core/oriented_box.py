"""Oriented boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector

CORNER_SIGNS: NDArray[np.float64] = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
"""Signs [8, 3] of the half extents at the corners of a box."""
SIZE_TOLERANCE = 0.15
"""Largest difference of the logarithms of sorted extents between boxes of similar size."""
MIN_EXTENT = 0.003
"""Length added to every half extent before sizes are compared, in diagonals of the shape."""


@dataclass(frozen=True, eq=False)
class Box:
    """An oriented box.

    Attributes:
        center: [3].
        axes: [3, 3], orthonormal rows that form a right-handed frame.
        half_extents: [3], half of the box's length along each axis.
    """

    center: Vector
    axes: NDArray[np.float64]
    half_extents: Vector

    def corners(self) -> NDArray[np.float64]:
        """The eight corners [8, 3], in the order of `CORNER_SIGNS`."""
        return self.center + (CORNER_SIGNS * self.half_extents) @ self.axes

    @property
    def volume(self) -> float:
        return float(8.0 * np.prod(self.half_extents))


def have_similar_size(half_extents: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.bool_]:
    """True for every box whose sorted extents match those of one box, or of its own partner, within `SIZE_TOLERANCE`.

    Args:
        half_extents: [3] of one box, or [..., 3] of a box for each of the others, in diagonals of the shape.
        others: [..., 3], in diagonals of the shape.
    """
    here, there = np.sort(half_extents, axis=-1)[..., ::-1] + MIN_EXTENT, np.sort(others, axis=-1)[..., ::-1] + MIN_EXTENT
    return np.asarray((np.abs(np.log(there / here)) < SIZE_TOLERANCE).all(axis=-1))
