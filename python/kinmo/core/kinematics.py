"""Forward kinematics of a mobility tree."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility

Pose = NDArray[np.float64]
"""A rigid transform [4, 4]: x' = pose[:3, :3] @ x + pose[:3, 3]."""


def rotation_about(joint: Joint, angle: float) -> Pose:
    """Rotation by `angle` (radians) about the joint's axis line."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(angle * joint.direction).as_matrix()
    pose[:3, 3] = joint.pivot - pose[:3, :3] @ joint.pivot
    return pose


def translation_along(joint: Joint, distance: float) -> Pose:
    """Translation by `distance` along the joint's direction."""
    pose = np.eye(4)
    pose[:3, 3] = distance * joint.direction
    return pose


def joint_motion(joint: Joint, value: float, turn: float = 0.0) -> Pose:
    """How the joint moves its body from the pose of the file to the value `value`.

    `value` is an angle (REVOLUTE) or a length (PRISMATIC, SCREW), and the file shows the body at `joint.rest`. `turn` is the
    angle of a SCREW, which turns freely while it slides; other kinds have no use for it.
    """
    if joint.kind is JointKind.REVOLUTE:
        return rotation_about(joint, value - joint.rest)
    slide = translation_along(joint, value - joint.rest)
    return slide @ rotation_about(joint, turn) if joint.kind is JointKind.SCREW else slide


def forward(mobility: Mobility, values: Mapping[int, float], turns: Mapping[int, float] | None = None) -> Pose:
    """Poses [B, 4, 4] that take every body from the pose of the file to the given joint values, in the frame of the shape.

    `values` and `turns` are by index of the body, as in `joint_motion`; a joint without a value rests. A body moves along with
    its parent.
    """
    angles = turns or {}
    poses: dict[int, Pose] = {}

    def pose_of(index: int) -> Pose:
        if index not in poses:
            body = mobility.bodies[index]
            above = np.eye(4) if body.parent is None else pose_of(body.parent)
            if body.joint is not None:
                above = above @ joint_motion(body.joint, values.get(index, body.joint.rest), angles.get(index, 0.0))
            poses[index] = above
        return poses[index]

    return np.array([pose_of(index) for index in range(len(mobility.bodies))]).reshape(-1, 4, 4)
