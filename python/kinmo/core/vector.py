"""3D vectors and distances to lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""A direction, point or axis: float64 [3]."""


def distance_to_line(points: NDArray[np.float64], pivot: Vector, direction: Vector) -> NDArray[np.float64]:
    """Distances [N] of points [N, 3] from the line through `pivot` along the unit vector `direction`."""
    offsets = points - pivot
    along = offsets @ direction
    squared: NDArray[np.float64] = np.sum(offsets * offsets, axis=-1) - along * along
    return np.sqrt(np.maximum(squared, 0.0))
