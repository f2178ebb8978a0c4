"""Where a part that turns lies straight: where its sides face the axes of the frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from kinmo.core.joint import Joint
from kinmo.core.kinematics import joint_motion
from kinmo.core.shape import Mesh

STEP = math.radians(3.0)
MOST_CROOKED = 1.12
"""Mean sum of the coordinates of normals, 1 of a box along the axes, up to which a part is one that can lie straight."""
AS_STRAIGHT = 0.03
"""Within so much of the least such sum a part lies straight."""


def straight_values(joint: Joint, mesh: Mesh, low: float, high: float) -> NDArray[np.float64]:
    """Values [n] between `low` and `high` of a hinge at which the sides of its part, whose mesh is at rest, face the axes.

    None of a part that has no such sides, or that is as straight at any value, such as a lid that turns in its plane. `low` and
    `high` themselves are not among them.
    """
    if low >= high:
        return np.zeros(0)
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = float(np.linalg.norm(normals, axis=1).sum())

    def crooked(value: float) -> float:
        turned = normals @ joint_motion(joint, value)[:3, :3].T
        return float(np.abs(turned).sum()) / max(area, np.finfo(float).tiny)

    values = np.arange(low, high + STEP, STEP)
    tried = np.array([crooked(value) for value in values])
    if np.ptp(tried) <= AS_STRAIGHT:
        return np.zeros(0)
    least = 1 + np.flatnonzero((tried[1:-1] <= tried[:-2]) & (tried[1:-1] <= tried[2:]))
    found = [
        minimize_scalar(crooked, bounds=(value - STEP, min(value + STEP, high)), method="bounded") for value in values[least]
    ]
    most = min(MOST_CROOKED, min((float(end.fun) for end in found), default=math.inf) + AS_STRAIGHT)
    return np.array([float(end.x) for end in found if end.fun <= most])
