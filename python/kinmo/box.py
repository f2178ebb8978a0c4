"""Oriented boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.shape import Vector

CORNER_SIGNS: NDArray[np.float64] = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)


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
