"""Pinhole cameras and random viewpoints around an object.

The camera frame has x to the right, y down and z forward (as in OpenCV). Its origin is the pinhole; lengths are the shape's.
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
    """Pinhole camera without distortion.

    The point (x, y, z) of the camera frame projects to column `focal[0]` x / z + `center[0]` and row `focal[1]` y / z +
    `center[1]`, in pixels. The middle of pixel (i, j) is (i + 1/2, j + 1/2). Points nearer than `near` or farther than `far`
    are invisible.
    """

    width: int
    height: int
    focal: Vector
    center: Vector
    near: float
    far: float

    @classmethod
    def from_field_of_view(cls, width: int, height: int, degrees: float, near: float, far: float) -> Camera:
        """Camera with a vertical field of view in degrees, its axis through the middle of the image."""
        focal = 0.5 * height / np.tan(np.radians(0.5 * degrees))
        return cls(width, height, np.full(2, focal), 0.5 * np.array([width, height], float), near, far)

    def rays(self, pixels: NDArray[np.intp] | None = None) -> F64:
        """Directions [..., 3] in the camera frame through the centers of `pixels`, with z = 1.

        Pixels are indices [...], row * width + column. By default they are all pixels [height, width].
        """
        if pixels is None:
            pixels = np.arange(self.height * self.width).reshape(self.height, self.width)
        rows, columns = np.divmod(pixels, self.width)
        x, y = (columns + 0.5 - self.center[0]) / self.focal[0], (rows + 0.5 - self.center[1]) / self.focal[1]
        return np.stack([x, y, np.ones_like(x)], axis=-1)

    def back_project(self, depths: NDArray[np.floating], pixels: NDArray[np.intp] | None = None) -> F64:
        """Points [..., 3] of the camera frame from `depths` [...] along z at `pixels` [...] (as in `rays`)."""
        return self.rays(pixels) * np.asarray(depths, np.float64)[..., None]


def look_at(eye: Vector, target: Vector, up: Vector) -> Pose:
    """World-to-camera pose [4, 4] of a camera at `eye` [3] that looks at `target` [3].

    The unit vector `up` [3] points up in the image. A camera that looks along it gets an arbitrary roll.
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
    """Distribution of camera positions around an object; the defaults are those of the paper's rendering pipeline.

    Attributes:
        field_of_view: Vertical field of view, degrees.
        yaw: Range in degrees.
        pitch: Range in degrees. -90 looks straight down; above 0 the camera is below the middle of the object.
        distance: Range, in units of radius * tan(field_of_view / 2), where the radius is half the diagonal of the object.
        target_offset: Largest offset of the target from the middle of the object along each axis, in the same unit.
    """

    field_of_view: float = 75.0
    yaw: tuple[float, float] = (-180.0, 180.0)
    pitch: tuple[float, float] = (-90.0, 5.0)
    distance: tuple[float, float] = (2.3, 3.3)
    target_offset: float = 0.4

    def sample(self, rng: np.random.Generator, center: Vector, radius: float, up: Vector) -> Pose:
        """Draw a pose [4, 4] from the object's frame to the camera frame.

        The object's box has the middle `center` [3] and half the diagonal `radius`; `up` is a unit vector [3].
        """
        unit = radius * np.tan(np.radians(0.5 * self.field_of_view))
        yaw, pitch = np.radians(rng.uniform(*self.yaw)), np.radians(rng.uniform(*self.pitch))
        target = center + self.target_offset * unit * rng.uniform(-1.0, 1.0, 3)
        side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
        side /= np.linalg.norm(side)
        level = np.cos(yaw) * side + np.sin(yaw) * np.cross(up, side)
        eye = target + unit * rng.uniform(*self.distance) * (np.cos(pitch) * level - np.sin(pitch) * up)
        return look_at(eye, target, up)
