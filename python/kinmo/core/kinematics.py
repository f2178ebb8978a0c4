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
    """Rotation [4, 4] by `angle` (radians) about the axis of the joint."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(angle * joint.direction).as_matrix()
    pose[:3, 3] = joint.pivot - pose[:3, :3] @ joint.pivot
    return pose


def joint_motion(joint: Joint, value: float, screw_angle: float = 0.0) -> Pose:
    """Motion [4, 4] of a joint from the pose of the file (`joint.rest`) to a joint value, in the frame of the joint.

    Args:
        joint: the joint.
        value: the joint value, an angle in radians (REVOLUTE) or a length (PRISMATIC, SCREW).
        screw_angle: rotation of a SCREW in radians, which is independent of its translation. Other kinds ignore it.
    """
    if joint.kind is JointKind.REVOLUTE:
        return rotation_about(joint, value - joint.rest)
    slide = np.eye(4)
    slide[:3, 3] = (value - joint.rest) * joint.direction
    return slide @ rotation_about(joint, screw_angle) if joint.kind is JointKind.SCREW else slide


def forward(mobility: Mobility, values: Mapping[int, float], screw_angles: Mapping[int, float] | None = None) -> Pose:
    """Poses [B, 4, 4] of all bodies at given joint values, as transforms from the pose of the file in the shape's frame.

    Every body moves along with its parent.

    Args:
        mobility: B bodies.
        values: joint values by index of the body (see `joint_motion`). A joint without a value stays at rest.
        screw_angles: rotations of screws in radians, by index of the body.
    """
    angles = screw_angles or {}
    poses: dict[int, Pose] = {}

    def pose_of(index: int) -> Pose:
        if index not in poses:
            body = mobility.bodies[index]
            pose = np.eye(4) if body.parent is None else pose_of(body.parent)
            if body.joint is not None:
                pose = pose @ joint_motion(body.joint, values.get(index, body.joint.rest), angles.get(index, 0.0))
            poses[index] = pose
        return poses[index]

    return np.array([pose_of(index) for index in range(len(mobility.bodies))]).reshape(-1, 4, 4)
