"""Where a picture is taken from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector

FROM_FRONT, FROM_SIDE, FROM_ABOVE = 1.0, -0.55, 0.5
"""Direction to the viewer along front, side and up: in front of the object, to its left, a little above."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel projection.

    `rows` [3, 3] are unit vectors to the right, to the top and to the viewer, `center` [3] is seen in the middle, `scale`
    is in pixels a unit of length.

    Pixels count from the upper left corner of a square picture of `size` pixels.
    """

    rows: NDArray[np.float64]
    center: Vector
    scale: float
    size: int

    def project(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Pixels [..., 2] and depths [...] (larger is nearer to the viewer) of points [..., 3]."""
        seen = (points - self.center) @ self.rows.T * self.scale
        half = 0.5 * self.size
        return np.stack([half + seen[..., 0], half - seen[..., 1]], axis=-1), seen[..., 2]


def front_left(points: NDArray[np.float64], up: Vector, size: int, margin: float = 0.1) -> Camera:
    """The camera that sees all `points` [N, 3] from the front left.

    `margin` is the share of the picture that is left free at each side. The front of an object is +z where y is
    up (PartNet's convention), and -y where z is up.
    """
    front = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    front = front - up * (front @ up)
    front /= np.linalg.norm(front)
    toward = FROM_FRONT * front + FROM_SIDE * np.cross(up, front) + FROM_ABOVE * up
    toward /= np.linalg.norm(toward)
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    rows = np.stack([right, np.cross(toward, right), toward])
    seen = points @ rows.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    extent = max(float(np.max(high[:2] - low[:2])), np.finfo(float).tiny)
    return Camera(rows, 0.5 * (low + high) @ rows, (1.0 - 2.0 * margin) * size / extent, size)
