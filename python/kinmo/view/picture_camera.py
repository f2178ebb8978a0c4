"""Camera of an object's picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector

FRONT, SIDE, ABOVE = 1.0, -0.55, 0.5
"""Direction to the viewer along front, side and up: in front of the object, to its left, a little above."""
DISTANCE = 6.0
"""Distance of the viewer from the middle of the object, in radii of the object."""

MIN_EXTENT = 1e-9
"""Least extent of what is seen, over its distance: a single point is not enlarged further."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera with square pictures. Lengths in its frame are in radii of the object.

    Attributes:
        rotation: Unit vectors [3, 3] to the right, down and forward, as rows.
        middle: Point [3] that the camera looks at.
        radius: Radius of the object.
        focal: Focal length in pixels.
        center: Principal point [2] in pixels, from the upper left corner.
        size: Width and height of the picture in pixels.
    """

    rotation: NDArray[np.float64]
    middle: Vector
    radius: float
    focal: float
    center: NDArray[np.float64]
    size: int

    def to_view(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points [..., 3] in the frame of the camera: x to the right, y down, z forward."""
        return np.asarray((points - self.middle) @ self.rotation.T / self.radius + [0.0, 0.0, DISTANCE])

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pixels [..., 2] of points [..., 3]."""
        seen = self.to_view(points)
        return self.focal * seen[..., :2] / seen[..., 2:] + self.center


def front_left(points: NDArray[np.float64], up: Vector, size: int, margin: float = 0.1) -> Camera:
    """Camera that sees all points from the front left.

    The front of an object is +z where y is up (PartNet's convention), and -y where z is up.

    Args:
        points: Points [N, 3].
        up: Unit vector [3] that points up.
        size: Width and height of the picture in pixels.
        margin: Share of the picture that is left free at each side.
    """
    front = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    front = front - up * (front @ up)
    toward = FRONT * front / np.linalg.norm(front) + SIDE * np.cross(up, front) + ABOVE * up
    toward /= np.linalg.norm(toward)
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(right, toward), -toward])
    low, high = points.min(axis=0), points.max(axis=0)
    radius = max(0.5 * float(np.linalg.norm(high - low)), np.finfo(float).tiny)
    camera = Camera(rotation, 0.5 * (low + high), radius, 1.0, np.zeros(2), size)
    seen = camera.project(points)
    first, last = seen.min(axis=0), seen.max(axis=0)
    focal = (1.0 - 2.0 * margin) * size / max(float(np.max(last - first)), MIN_EXTENT)
    return Camera(rotation, camera.middle, radius, focal, 0.5 * size - focal * 0.5 * (first + last), size)
