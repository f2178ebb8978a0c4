"""3D vectors and distances to lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""A direction, point or axis: float64 [3]."""


def distance_to_line(points: NDArray[np.float64], pivot: Vector, direction: Vector) -> NDArray[np.float64]:
    """Distances of points from a line.

    Args:
        points: [N, 3].
        pivot: [3], a point of the line.
        direction: [3], the unit direction of the line.

    Returns:
        Distances [N], in the length unit of the points.
    """
    offsets = points - pivot
    along = offsets @ direction
    squared: NDArray[np.float64] = np.sum(offsets * offsets, axis=-1) - along * along
    return np.sqrt(np.maximum(squared, 0.0))
