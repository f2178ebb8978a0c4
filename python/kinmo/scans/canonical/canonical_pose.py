"""Canonical pose: the joint state and the base in which all objects of a category are compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import joint_motion, rotation_about
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh
from kinmo.scans.canonical.closed_pose import Parts, box_middle, close_joints, transform_points
from kinmo.scans.canonical.folding_joints import align_tips, find_folding_joints
from kinmo.scans.canonical.pseudo_label_closed_pose import estimate_closed_limits
from kinmo.scans.canonical.visible_base import transform_object, with_first_part_as_base, with_visible_base

F64 = NDArray[np.float64]

TEST_ANGLE = 0.5
"""Opening of a hinge at which its opening direction is measured, rad."""


def to_canonical_pose(mobility: Mobility, meshes: Sequence[Mesh], min_size: float, to_z_up: F64, closes: bool) -> Parts:
    """Bring an object with known limits to its canonical pose, with a visible base; arguments as in `with_visible_base`.

    If it `closes`, all joints are closed, and the object is turned so that it opens to the front. `to_z_up` may mirror left and
    right, to choose the base that the mirrored object will have.
    """
    open_parts, open_meshes, base_joint = with_visible_base(mobility, meshes, min_size, to_z_up)
    if not closes:
        return open_parts, open_meshes
    shut = close_joints(mobility, meshes, base_is_visible=base_joint is None)
    mobility, meshes, _ = with_visible_base(*shut, min_size, to_z_up)
    # Close again: the new base may be one of several parts that open the same way, and a base does not close.
    return open_to_the_front(*close_joints(mobility, meshes), to_z_up)


def to_estimated_canonical_pose(
    mobility: Mobility, meshes: Sequence[Mesh], min_size: float, to_z_up: F64, max_guessed_opening: float
) -> Parts:
    """Bring an object with guessed limits to its canonical pose; arguments as in `to_canonical_pose`.

    Joints close where `estimate_closed_limits` says, and hinges open by `max_guessed_opening` rad at most. If the base is
    invisible, folding joints close where their tips meet, and the object is turned so that the tips are axis-aligned
    (`folding_joints`).
    """
    mobility, meshes, base_joint = with_visible_base(mobility, meshes, min_size, to_z_up)
    foldings = {} if base_joint is None else find_folding_joints(mobility, meshes, base_joint)
    if base_joint is not None and foldings:
        # Before closing, because box volumes tell open from closed only along the axes.
        mobility, meshes = align_tips(mobility, meshes, base_joint, foldings)
    parts = close_joints(estimate_closed_limits(mobility, meshes, max_guessed_opening, foldings), meshes)
    if base_joint is not None:
        parts = with_first_part_as_base(*parts, min_size, to_z_up)
    return open_to_the_front(*parts, to_z_up)


def open_to_the_front(mobility: Mobility, meshes: Sequence[Mesh], to_z_up: F64) -> Parts:
    """Turn a closed object half round about up if its summed opening motion points to the back more than anywhere else.

    The front of a door that is the same from both sides is arbitrary in its file. `to_z_up` is as in `to_canonical_pose`.
    """
    motion = np.zeros(3)
    for index, body in mobility.movable():
        if body.joint is not None:
            motion += to_z_up @ _opening_motion(body.joint, box_middle(meshes[index].vertices))
    if motion[0] <= 0.0 or motion[0] < np.abs(motion).max():
        return mobility, tuple(meshes)
    return transform_object(mobility, meshes, rotation_about(Joint(JointKind.REVOLUTE, to_z_up[2], np.zeros(3)), np.pi))


def _opening_motion(joint: Joint, middle: F64) -> F64:
    """Displacement [3] of a closed part's middle when it opens; 0 without limits, or if it opens to both sides."""
    if joint.lower is None or joint.upper is None or joint.rest > joint.lower:
        return np.zeros(3)
    value = joint.lower + TEST_ANGLE if joint.kind is JointKind.REVOLUTE else joint.upper
    return transform_points(joint_motion(joint, min(value, joint.upper)), middle) - middle
