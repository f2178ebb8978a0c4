"""Choice of a visible base: objects such as scissors hang from a pin that no camera sees, so that one of their parts serves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import Pose
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh, join
from kinmo.scans.canonical.closed_pose import Parts, box_middle, transform_points
from kinmo.scans.canonical.part_order import reordered, spatial_order

F64 = NDArray[np.float64]

EQUAL_SIZE = 0.8
"""Share of the largest diagonal from which on parts are equally good bases."""
SAME_DIRECTION = math.cos(math.radians(2.0))
"""Cosine from which on two axes are parallel."""
SAME_AXIS = 0.01
"""Largest distance between two lines that are one axis, diagonals."""


def with_visible_base(
    mobility: Mobility, meshes: Sequence[Mesh], min_size: float, to_z_up: F64
) -> tuple[Mobility, tuple[Mesh, ...], Joint | None]:
    """Replace a base that is too small to be seen by one of its children.

    The new base is the first of the largest children (`spatial_order`); the old base is joined to it. The others move against
    the new base: about a shared axis as far as both did together, and otherwise as they moved against the old base. If the
    base has a single child, that child and its children are the candidates. An object with fewer than three bodies stays.

    Args:
        mobility: Joints; body 0 is the base, and each other body has a joint and follows its parent.
        meshes: Meshes of the bodies, one each, of an object with the diagonal 1.
        min_size: Smallest diagonal of a visible part.
        to_z_up: Matrix [3, 3] to a frame with z up and the front at -x.

    Returns:
        The mobility, the meshes, and the joint by which the new base hung from the old one; None if the base stays.
    """
    children, chosen = _children_of_base(mobility), None
    is_visible = len(meshes[0].faces) > 0 and _diagonal(meshes[0]) >= min_size
    if len(mobility.bodies) >= 3 and not is_visible:
        chosen = _first_of_largest(children, meshes, min_size, to_z_up) if len(children) > 1 else children[0]
    if chosen is None:
        return mobility, tuple(meshes), None
    base, base_joint = mobility.bodies[0], mobility.bodies[chosen].joint
    mobility, others = _without_base(mobility, meshes, chosen)
    if len(children) == 1:
        mobility, others = with_first_part_as_base(mobility, others, min_size, to_z_up)
    whole = replace(mobility.bodies[0], leaves=tuple(sorted(base.leaves + mobility.bodies[0].leaves)))
    return replace(mobility, bodies=(whole, *mobility.bodies[1:])), (join(meshes[0], others[0]), *others[1:]), base_joint


def transform_object(mobility: Mobility, meshes: Sequence[Mesh], pose: Pose) -> Parts:
    """Move parts and joints as a whole by a pose [4, 4]."""

    def moved(joint: Joint) -> Joint:
        return replace(joint, direction=pose[:3, :3] @ joint.direction, pivot=transform_points(pose, joint.pivot))

    return mobility.with_joints(moved), tuple(Mesh(transform_points(pose, mesh.vertices), mesh.faces) for mesh in meshes)


def with_first_part_as_base(mobility: Mobility, meshes: Sequence[Mesh], min_size: float, to_z_up: F64) -> Parts:
    """Make the first of the largest among the base and its children the base; arguments as in `with_visible_base`."""
    chosen = _first_of_largest([0, *_children_of_base(mobility)], meshes, min_size, to_z_up)
    if not chosen:
        return mobility, tuple(meshes)
    bodies, joint = list(mobility.bodies), mobility.bodies[chosen].joint
    back = None if joint is None else replace(joint, direction=-joint.direction)  # seen from the other part
    bodies[0], bodies[chosen] = replace(bodies[0], parent=chosen, joint=back), replace(bodies[chosen], parent=None, joint=None)
    order = [chosen, *(index for index in range(len(bodies)) if index != chosen)]
    return replace(mobility, bodies=reordered(bodies, order)), tuple(meshes[index] for index in order)


def _children_of_base(mobility: Mobility) -> list[int]:
    return [index for index, body in enumerate(mobility.bodies) if body.parent == 0]


def _first_of_largest(bodies: Sequence[int], meshes: Sequence[Mesh], min_size: float, to_z_up: F64) -> int | None:
    """The first in `spatial_order` of the largest bodies; None if all are smaller than `min_size`."""
    sizes = {index: _diagonal(meshes[index]) for index in bodies}
    largest = [index for index in bodies if sizes[index] >= max(EQUAL_SIZE * max(sizes.values()), min_size)]
    if not largest:
        return None
    middles = np.stack([box_middle(meshes[index].vertices) for index in largest])
    return largest[int(spatial_order(middles @ to_z_up.T)[0])]


def _without_base(mobility: Mobility, meshes: Sequence[Mesh], chosen: int) -> Parts:
    """The object without its base; a child of the base takes its place."""
    base_joint, bodies = mobility.bodies[chosen].joint, list(mobility.bodies)
    for index in _children_of_base(mobility):
        joint = bodies[index].joint
        if joint is not None and base_joint is not None:
            bodies[index] = replace(bodies[index], joint=relative_joint(joint, base_joint))
    bodies[chosen] = replace(bodies[chosen], parent=None, joint=None)
    order = [chosen, *(index for index in range(1, len(bodies)) if index != chosen)]
    return replace(mobility, bodies=reordered(bodies, order)), tuple(meshes[index] for index in order)


def relative_joint(joint: Joint, base_joint: Joint) -> Joint:
    """Joint of a part against another one, which becomes the base; both hang from the same thing.

    For two hinges about one axis, or two sliders along one direction, the limits are combined. Otherwise `joint` stays.
    """
    along = float(joint.direction @ base_joint.direction)
    if joint.kind is not base_joint.kind or joint.kind is JointKind.SCREW or abs(along) < SAME_DIRECTION:
        return joint
    offset = np.linalg.norm(np.cross(base_joint.pivot - joint.pivot, joint.direction))
    if joint.kind is JointKind.REVOLUTE and offset > SAME_AXIS:
        return joint
    base_joint = base_joint if along > 0.0 else base_joint.reversed()
    rest = joint.rest - base_joint.rest
    if joint.lower is None or joint.upper is None or base_joint.lower is None or base_joint.upper is None:
        return replace(joint, lower=None, upper=None, rest=rest)
    return replace(joint, lower=joint.lower - base_joint.upper, upper=joint.upper - base_joint.lower, rest=rest)


def _diagonal(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) if len(mesh.vertices) else 0.0
