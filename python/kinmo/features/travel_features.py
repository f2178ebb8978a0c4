"""Features that tell how far a body can travel along a joint, for each of its two senses.

All numbers are in the normalised frame (lengths in diagonals of the object) and do not change when the object turns about `up`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import joint_motion
from kinmo.features.group_geometry import GroupGeometry
from kinmo.features.shape_geometry import ShapeGeometry

F64 = NDArray[np.float64]

HINGE_SCALE = np.pi / 2
"""Travel of a hinge that counts as 1, in radians."""
MIN_LENGTH = 1e-3
"""Least length of a slider along its axis that counts, in diagonals."""
SMALL_TURN = np.radians(20.0)
"""Angle of a hinge after which the growth of the object's box is measured, in radians."""
SMALL_SLIDE = 0.3
"""Travel of a slider after which the growth of the object's box is measured, as a share of its length along the axis."""
DIRECTED_FEATURES = 10
"""Number of features of one sense of a joint."""
FREE = 0
"""Index of the free travel among the features of one sense."""
SHARED_FEATURES = 8
"""Number of features of a joint that are the same for both senses."""


@dataclass(frozen=True, eq=False)
class TravelFeatures:
    """Features of J joints.

    Attributes:
        directed ([J, 2, 10] float32): Features of the sense along the joint's direction, and of the opposite one.
        shared ([J, 8] float32): Features of the joint.
        scales ([J] float64): Travel that counts as 1: a right angle for hinges, in radians, and the body's length along the
            axis for sliders and screws.
    """

    directed: NDArray[np.float32]
    shared: NDArray[np.float32]
    scales: F64


def travel_features(
    shape: ShapeGeometry, group: GroupGeometry, moving: Sequence[int], joints: Sequence[Joint]
) -> TravelFeatures:
    """Features of joints of one body.

    Args:
        shape: Geometry of the shape.
        group: The body relative to the other leaves.
        moving: Positions of all leaves that move with the body, with those of bodies attached to it.
        joints: At least one joint, in the normalised frame; limits are not used.
    """
    obstacles = sorted(set(range(len(shape.areas))) - set(moving))
    slides = np.array([joint.kind is not JointKind.REVOLUTE for joint in joints])
    directions, pivots = (np.array([getattr(joint, name) for joint in joints]) for name in ("direction", "pivot"))
    lengths = np.maximum(np.ptp(group.points @ directions.T, axis=0), MIN_LENGTH)
    scales = np.where(slides, lengths, HINGE_SCALE)
    reach = np.where(slides, lengths, np.pi)
    lower, upper = -reach, reach
    if obstacles:  # screws are swept as sliders
        kinds = np.where(slides, JointKind.PRISMATIC.code, JointKind.REVOLUTE.code).astype(np.uint8)
        lower, upper, _ = _core.sweep(shape.meshes, list(moving), obstacles, kinds, directions, pivots, lower, upper)
    free = np.column_stack([upper, -lower]) / scales[:, None]
    directed = np.empty((len(joints), 2, DIRECTED_FEATURES), np.float32)
    shared = np.empty((len(joints), SHARED_FEATURES), np.float32)
    for row, (joint, is_slider) in enumerate(zip(joints, slides.tolist(), strict=True)):
        velocity = _velocity(joint, group.points, is_slider)
        at_contact = _velocity(joint, group.contact, is_slider)
        at_tip = _velocity(joint, group.protrusion[None], is_slider)[0]
        from_axis = np.zeros(3) if is_slider else group.aligned.center - joint.pivot
        from_axis = from_axis - (from_axis @ joint.direction) * joint.direction
        signed = np.array(  # speeds along the joint's direction: up, outwards, and away from the leaves that stay
            [
                (velocity @ shape.up).mean(),
                at_tip @ shape.up,
                _outward(shape, group.points, velocity),
                _outward(shape, group.protrusion[None], at_tip[None]),
                np.einsum("ni,ni->n", at_contact, group.toward) @ group.contact_weights,
            ]
        )
        for sense, sign in enumerate((1.0, -1.0)):
            step = sign * (SMALL_SLIDE * lengths[row] if is_slider else SMALL_TURN)
            directed[row, sense] = (
                free[row, sense],
                free[row, 1 - sense],
                free[row, sense] - free[row, 1 - sense],
                *(sign * signed),
                *_growth(shape, joint, group.points, step),
            )
        shared[row] = (
            *np.eye(3)[joint.kind.code],
            abs(joint.direction @ shape.up),
            np.log(lengths[row]),
            np.linalg.norm(from_axis) / group.half_diagonal,
            float(not obstacles),
            free[row].min(),
        )
    return TravelFeatures(directed, shared, scales)


def _velocity(joint: Joint, points: F64, is_slider: bool) -> F64:
    """Velocity [n, 3] of points, at most 1."""
    if is_slider:
        return np.broadcast_to(joint.direction, points.shape)
    turning = np.cross(joint.direction, points - joint.pivot)
    return np.asarray(turning / max(float(np.linalg.norm(turning, axis=1).max()), 1e-6))


def _outward(shape: ShapeGeometry, points: F64, velocity: F64) -> float:
    """Mean speed away from the upright line through the object's middle."""
    outward = points - shape.middle
    outward = outward - (outward @ shape.up)[:, None] * shape.up
    outward /= np.maximum(np.linalg.norm(outward, axis=1), 1e-6)[:, None]
    return float(np.einsum("ni,ni->n", velocity, outward).mean())


def _growth(shape: ShapeGeometry, joint: Joint, points: F64, step: float) -> tuple[float, float]:
    """Lengths by which a body reaches out of the object's box to the sides, and above or below it, after a small motion."""
    pose = joint_motion(joint, joint.rest + step)
    placed = (points @ pose[:3, :3].T + pose[:3, 3]) @ shape.frame.T
    over = np.maximum(np.maximum(shape.extents[0] - placed, placed - shape.extents[1]), 0.0)
    return float(np.linalg.norm(over[:, :2], axis=1).mean()), float(over[:, 2].mean())
