"""Coordinate frames: from a shape's own frame to the z-up frame of robotics, and to the y-up frame that models see."""

from __future__ import annotations

import warnings
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.vector import Vector

Y_UP_TO_Z_UP: NDArray[np.float64] = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Rotation from PartNet-Mobility's OBJ files (y up, front at +z) to its URDF files (z up, front at -x)."""

Axis = Literal["x", "y", "z", "-x", "-y", "-z"]
"""An axis of a shape's own frame, or the direction against it."""
AXIS_VECTORS: dict[Axis, tuple[float, float, float]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}
"""Unit vectors of the axes."""
USUAL_FRONT: dict[Axis, Axis] = {"y": "z", "z": "-y"}
"""Axis of the front by the up axis: as in glTF and PartNet for y, and as in Blender for z. Others have no convention."""


def y_up_rotation(up: Vector, front: Vector | None = None) -> NDArray[np.float64]:
    """Rotation [3, 3] from a frame with the unit vectors `up` and `front` [3] to the frame that models see: y up, front at +z.

    Without a front that is perpendicular to `up`, a y-up shape stays as it is, and a z-up shape is rotated so that -y comes to
    +z. Any other `up` is then rotated to y by the smallest angle.
    """
    up = np.asarray(up, float)
    if front is None or abs(np.dot(up, front)) > 1e-6:
        usual = [(AXIS_VECTORS[one], AXIS_VECTORS[other]) for one, other in USUAL_FRONT.items()]
        front = next((np.array(other) for one, other in usual if np.allclose(up, one, atol=1e-9)), None)
    if front is None:
        return _rotation_to_y(up)
    rotation = np.stack([np.cross(up, front), up, np.asarray(front, float)])
    return rotation + 0.0  # no negative zeros


def gltf_rotation(up: Vector, front: Vector | None = None) -> NDArray[np.float64]:
    """Rotation [3, 3] from a frame with the unit vectors `up` and `front` [3] to that of glTF.

    A y-up shape stays as it is. Any other one is rotated as by `y_up_rotation`: its front comes to +z.
    """
    up = np.asarray(up, float)
    return np.eye(3) if np.allclose(up, AXIS_VECTORS["y"], atol=1e-9) else y_up_rotation(up, front)


def z_up_rotation(up: Vector) -> NDArray[np.float64]:
    """Rotation [3, 3] from a frame with the unit vector `up` [3] to the z-up frame of exports.

    A y-up shape is rotated as in PartNet-Mobility's own URDF files. A z-up shape stays as it is. Any other `up` is first
    rotated to y by the smallest angle.
    """
    if np.allclose(up, AXIS_VECTORS["z"], atol=1e-9):
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
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Gimbal lock")  # one of the equal angles is as good as another
        return np.asarray(Rotation.from_matrix(rotation).as_euler("xyz"))


def quaternion(rotation: NDArray[np.float64]) -> Vector:
    """The quaternion [4] of a rotation matrix [3, 3], real part first and not negative."""
    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    values = np.array([w, x, y, z])
    return (-values if w < 0.0 else values) + 0.0
