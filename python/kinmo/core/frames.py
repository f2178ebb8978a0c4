"""Which way is up: from a shape's own frame to the z-up frame of robotics, and to the y-up frame of what kinmo learns from."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.vector import Vector

Y_UP_TO_Z_UP: NDArray[np.float64] = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""x, y, z of PartNet-Mobility's object files to its own URDFs: up is z, the front (+z) is -x."""

Up = Literal["y", "z"]
"""Which axis of a shape's own frame points up; its front is then at +z or at -y."""
TO_Y_UP: dict[Up, NDArray[np.float64]] = {
    "y": np.eye(3),
    "z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
"""Rotations [3, 3] to a frame with y up and the front at +z."""


def z_up_rotation(up: Vector) -> NDArray[np.float64]:
    """Rotation [3, 3] from a frame in which the unit vector `up` [3] points up to one where z does.

    y-up shapes go where PartNet-Mobility's own URDFs have them, z-up shapes stay as they are, any other `up` is turned into y
    first, the short way.
    """
    y_up, z_up = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    if np.allclose(up, z_up, atol=1e-9):
        return np.eye(3)
    axis = np.cross(up, y_up)
    sine, cosine = float(np.linalg.norm(axis)), float(np.dot(up, y_up))
    if sine < 1e-9:
        return Y_UP_TO_Z_UP @ np.diag([1.0, np.sign(cosine), np.sign(cosine)])
    turn = Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine)).as_matrix()
    return np.asarray(Y_UP_TO_Z_UP @ turn)


def roll_pitch_yaw(rotation: NDArray[np.float64]) -> Vector:
    """Angles [3] (radians) about the fixed axes x, y, z, as URDF writes a rotation."""
    return np.asarray(Rotation.from_matrix(rotation).as_euler("xyz"))
