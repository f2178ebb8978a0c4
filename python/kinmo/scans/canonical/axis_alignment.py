"""Hinge angles at which a part is axis-aligned: its sides face the axes of the frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from kinmo.core.joint import Joint
from kinmo.core.kinematics import joint_motion
from kinmo.core.shape import Mesh

STEP = math.radians(3.0)
"""Step of the angle search, rad."""
MAX_MISALIGNMENT = 1.12
"""Largest misalignment (`axis_aligned_values`) of an axis-aligned part; an axis-aligned box has 1."""
TOLERANCE = 0.03
"""Excess over the least misalignment up to which another angle is axis-aligned too."""


def axis_aligned_values(joint: Joint, mesh: Mesh, low: float, high: float) -> NDArray[np.float64]:
    """Values of a hinge at which its part is axis-aligned.

    The misalignment of a part is the mean of |nx| + |ny| + |nz| over its surface, for unit normals n. The result holds its
    least local minima.

    Args:
        joint: The hinge.
        mesh: The part's mesh, at the joint's rest value.
        low: Lower end of the search, rad.
        high: Upper end of the search, rad.

    Returns:
        Values [n] strictly between `low` and `high`. A part without flat sides has none. A part that is equally aligned at any
        angle has none either, such as a lid that turns in its plane.
    """
    if low >= high:
        return np.zeros(0)
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = float(np.linalg.norm(normals, axis=1).sum())

    def misalignment(value: float) -> float:
        turned = normals @ joint_motion(joint, value)[:3, :3].T
        return float(np.abs(turned).sum()) / max(area, np.finfo(float).tiny)

    values = np.arange(low, high + STEP, STEP)
    sampled = np.array([misalignment(value) for value in values])
    if np.ptp(sampled) <= TOLERANCE:
        return np.zeros(0)
    minima = 1 + np.flatnonzero((sampled[1:-1] <= sampled[:-2]) & (sampled[1:-1] <= sampled[2:]))
    found = [
        minimize_scalar(misalignment, bounds=(value - STEP, min(value + STEP, high)), method="bounded")
        for value in values[minima]
    ]
    limit = min(MAX_MISALIGNMENT, min((float(end.fun) for end in found), default=math.inf) + TOLERANCE)
    return np.array([float(end.x) for end in found if end.fun <= limit])
