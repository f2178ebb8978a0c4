"""Pinhole cameras and where they stand.

The camera's frame has x to the right, y down and z forward (as OpenCV's), its origin at the pinhole, and the shape's lengths.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.kinematics import Pose
from kinmo.core.vector import Vector

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera without distortion.

    The point (x, y, z) of its frame is seen at column `focal[0]` x / z + `center[0]` and row `focal[1]` y / z + `center[1]`, in
    pixels; the middle of the pixel (i, j) is at (i + 1/2, j + 1/2). What is nearer than `near` or farther than `far` is not
    seen.
    """

    width: int
    height: int
    focal: Vector
    center: Vector
    near: float
    far: float

    @classmethod
    def of_field(cls, width: int, height: int, degrees: float, near: float, far: float) -> Camera:
        """A camera with a vertical field of view of so many degrees, its axis through the middle of the picture."""
        focal = 0.5 * height / np.tan(np.radians(0.5 * degrees))
        return cls(width, height, np.full(2, focal), 0.5 * np.array([width, height], float), near, far)

    def rays(self, pixels: NDArray[np.intp] | None = None) -> F64:
        """Directions [..., 3] through the middles of `pixels` [...], with z = 1; a pixel is row * width + column.

        Without `pixels` those of all, [height, width, 3].
        """
        if pixels is None:
            pixels = np.arange(self.height * self.width).reshape(self.height, self.width)
        rows, columns = np.divmod(pixels, self.width)
        x, y = (columns + 0.5 - self.center[0]) / self.focal[0], (rows + 0.5 - self.center[1]) / self.focal[1]
        return np.stack([x, y, np.ones_like(x)], axis=-1)

    def points(self, depths: NDArray[np.floating], pixels: NDArray[np.intp] | None = None) -> F64:
        """Points [..., 3] of the camera's frame that `pixels` [...] (as in `rays`) see at `depths` [...] along z."""
        return self.rays(pixels) * np.asarray(depths, np.float64)[..., None]


def look_at(eye: Vector, target: Vector, up: Vector) -> Pose:
    """Pose [4, 4] that takes the frame of `eye` [3], `target` [3] and the unit vector `up` [3] to that of a camera at `eye`.

    The camera looks at `target`, and `up` is up in its picture; where it looks along `up`, any side may be.
    """
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, up)
    if np.linalg.norm(right) < 1e-9:
        right = np.cross(forward, np.eye(3)[np.argmin(np.abs(forward))])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = -pose[:3, :3] @ eye
    return pose


@dataclass(frozen=True)
class Viewpoints:
    """Where cameras stand, drawn at random about an object of a given radius (half the diagonal of its box).

    `yaw` and `pitch` are ranges in degrees; a pitch of -90 looks straight down, and above 0 the camera stands below the middle.
    `distance` (a range) and `aside` (how far the target may lie off the middle, along each axis) count in radius *
    tan(`field` / 2), the unit of the pipeline that the paper renders with.

    The defaults are those of that pipeline.
    """

    field: float = 75.0
    yaw: tuple[float, float] = (-180.0, 180.0)
    pitch: tuple[float, float] = (-90.0, 5.0)
    distance: tuple[float, float] = (2.3, 3.3)
    aside: float = 0.4

    def draw(self, rng: np.random.Generator, center: Vector, radius: float, up: Vector) -> Pose:
        """Pose [4, 4] from the object's frame to a camera's."""
        unit = radius * np.tan(np.radians(0.5 * self.field))
        yaw, pitch = np.radians(rng.uniform(*self.yaw)), np.radians(rng.uniform(*self.pitch))
        target = center + self.aside * unit * rng.uniform(-1.0, 1.0, 3)
        side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
        side /= np.linalg.norm(side)
        level = np.cos(yaw) * side + np.sin(yaw) * np.cross(up, side)
        eye = target + unit * rng.uniform(*self.distance) * (np.cos(pitch) * level - np.sin(pitch) * up)
        return look_at(eye, target, up)
