"""Frames of USD joints and masses: axes are those of a frame, and inertia is diagonal in a frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import quaternion
from kinmo.core.vector import Vector

AXES = ("X", "Y", "Z")
MIN_MOMENT = 1e-12
"""Least moment of inertia in kg m2. USD regards 0 as not stated."""

MAX_NOISE = 1e-12
"""Largest product of inertia that counts as 0, as a share of the largest moment."""


def axis_frame(axis: Vector) -> tuple[str, Vector]:
    """A frame of which one axis is the axis of a joint.

    Args:
        axis: Unit vector [3].

    Returns:
        The name of that axis, the one that needs the smallest turn but for its sign, and the quaternion [4] of the frame.
    """
    nearest = int(np.argmax(np.abs(axis)))
    own = np.eye(3)[nearest]
    if axis[nearest] < 0.0:  # half a turn about the next axis puts it on the other side
        half = 2.0 * np.outer(np.eye(3)[nearest - 2], np.eye(3)[nearest - 2]) - np.eye(3)
        return AXES[nearest], quaternion(_arc(-own, axis) @ half)
    return AXES[nearest], quaternion(_arc(own, axis))


def _arc(start: Vector, end: Vector) -> NDArray[np.float64]:
    """Rotation [3, 3] by the smallest angle from one unit vector to another. They are less than 90 degrees apart."""
    cross = np.cross(start, end)
    matrix = np.array([[0.0, -cross[2], cross[1]], [cross[2], 0.0, -cross[0]], [-cross[1], cross[0], 0.0]])
    return np.asarray(np.eye(3) + matrix + matrix @ matrix / (1.0 + start @ end))


def principal_inertia(inertia: NDArray[np.float64]) -> tuple[Vector, Vector]:
    """Moments [3] about the principal axes, and the quaternion [4] of the frame of these axes.

    Args:
        inertia: Inertia [3, 3] about the centre of mass in kg m2.
    """
    if np.abs(inertia - np.diag(np.diag(inertia))).max() <= MAX_NOISE * np.abs(inertia).max():
        return np.maximum(np.diag(inertia), MIN_MOMENT), np.array([1.0, 0.0, 0.0, 0.0])
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return np.maximum(moments, MIN_MOMENT), quaternion(axes)
