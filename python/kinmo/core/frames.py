"""Coordinate frames: from a shape's own frame to the z-up frame of robotics, and to the y-up frame that models see."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.vector import Vector

Y_UP_TO_Z_UP: NDArray[np.float64] = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Rotation from PartNet-Mobility's OBJ files (y up, front at +z) to its URDF files (z up, front at -x)."""

Up = Literal["y", "z"]
"""The up axis of a shape's own frame. The front is at +z for "y" and at -y for "z"."""
TO_Y_UP: dict[Up, NDArray[np.float64]] = {
    "y": np.eye(3),
    "z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
"""Rotations [3, 3] from a shape's own frame to the frame with y up and the front at +z."""
UP_VECTORS: dict[Up, tuple[float, float, float]] = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
"""Unit vectors that point up, by the name of the axis."""


def y_up_rotation(up: Vector) -> NDArray[np.float64]:
    """Rotation [3, 3] from a frame with the unit vector `up` [3] to the y-up frame that models see.

    A y-up shape stays as it is. A z-up shape is rotated so that its front at -y comes to +z. Any other `up` is rotated to y by
    the smallest angle.
    """
    for axis, vector in UP_VECTORS.items():
        if np.allclose(up, vector, atol=1e-9):
            return TO_Y_UP[axis]
    return _rotation_to_y(np.asarray(up, float))


def z_up_rotation(up: Vector) -> NDArray[np.float64]:
    """Rotation [3, 3] from a frame with the unit vector `up` [3] to the z-up frame of exports.

    A y-up shape is rotated as in PartNet-Mobility's own URDF files. A z-up shape stays as it is. Any other `up` is first
    rotated to y by the smallest angle.
    """
    if np.allclose(up, UP_VECTORS["z"], atol=1e-9):
        return np.eye(3)
    return np.asarray(Y_UP_TO_Z_UP @ _rotation_to_y(np.asarray(up, float)))


def _rotation_to_y(up: Vector) -> NDArray[np.float64]:
    """Rotation [3, 3] of the unit vector `up` to the y axis by the smallest angle; a half turn is about x."""
    y_axis = np.array([0.0, 1.0, 0.0])
    axis = np.cross(up, y_axis)
    sine, cosine = float(np.linalg.norm(axis)), float(np.dot(up, y_axis))
    if sine < 1e-9:
        return np.diag([1.0, np.sign(cosine), np.sign(cosine)])
    return np.asarray(Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine)).as_matrix())


def roll_pitch_yaw(rotation: NDArray[np.float64]) -> Vector:
    """Roll, pitch and yaw [3] in radians of a rotation [3, 3]: angles about the fixed axes x, y, z, as URDF writes them."""
    return np.asarray(Rotation.from_matrix(rotation).as_euler("xyz"))
