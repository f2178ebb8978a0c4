"""What other parts move against in a scan: not a pin that nobody sees, as scissors have, but a part that hangs by it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import Pose
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, join
from kinmo.scans.closed_pose import moved_by
from kinmo.scans.part_order import in_a_row

F64 = NDArray[np.float64]

AS_LARGE = 0.8
"""Parts whose diagonals are at least this share of the largest one's are as good a base as that."""
SAME_DIRECTION = math.cos(math.radians(2.0))
SAME_AXIS = 0.01
"""Diagonals between two axes that are one."""


def with_visible_base(
    mobility: Mobility, meshes: Sequence[Mesh], smallest: float, to_z_up: F64
) -> tuple[Mobility, tuple[Mesh, ...], Joint | None]:
    """The object with another base, where that is smaller than `smallest` (or nothing) and several parts move.

    Body 0 is the base, every other one has a joint and comes after its parent; `meshes` are theirs, those of an object with the
    diagonal 1, and `to_z_up` [3, 3] turns their frame to one with z up and the front at -x. Of the largest parts below the base
    the one that comes first in a row (`part_order`) takes its place, and the base goes with it. The others move against that:
    about the same axis, or along the same line, as far as both do together; else as they do against the old base. Where a
    single part hangs by the base, it is chosen of that one and of the parts below it.

    With it comes the joint by which the part that took its place hung by it; None where the base stays.
    """
    below, base = _below(mobility, 0), mobility.bodies[0]
    is_visible = len(meshes[0].faces) > 0 and _diagonal(meshes[0]) >= smallest
    if len(mobility.bodies) < 3 or is_visible:
        return mobility, tuple(meshes), None
    chosen = _first_of_the_largest(below, meshes, smallest, to_z_up) if len(below) > 1 else below[0]
    if chosen is None:
        return mobility, tuple(meshes), None
    hung_by = mobility.bodies[chosen].joint
    mobility, others = _without_base(mobility, meshes, chosen)
    if len(below) == 1:
        mobility, others = with_first_base(mobility, others, smallest, to_z_up)
    whole = replace(mobility.bodies[0], leaves=tuple(sorted(base.leaves + mobility.bodies[0].leaves)))
    return replace(mobility, bodies=(whole, *mobility.bodies[1:])), (join(meshes[0], others[0]), *others[1:]), hung_by


def moved_as_a_whole(mobility: Mobility, meshes: Sequence[Mesh], pose: Pose) -> tuple[Mobility, tuple[Mesh, ...]]:
    """Parts and joints where a pose takes them."""
    moved = tuple(Mesh(moved_by(pose, mesh.vertices), mesh.faces) for mesh in meshes)
    return replace(mobility, bodies=tuple(_moved(body, pose) for body in mobility.bodies)), moved


def _moved(body: Body, pose: Pose) -> Body:
    joint = body.joint
    if joint is None:
        return body
    direction, pivot = pose[:3, :3] @ joint.direction, moved_by(pose, joint.pivot)
    return replace(body, joint=replace(joint, direction=direction, pivot=pivot))


def with_first_base(
    mobility: Mobility, meshes: Sequence[Mesh], smallest: float, to_z_up: F64
) -> tuple[Mobility, tuple[Mesh, ...]]:
    """The object with that for its base which, of the base and the parts below it that are as large, comes first in a row."""
    chosen = _first_of_the_largest([0, *_below(mobility, 0)], meshes, smallest, to_z_up)
    return _exchanged(mobility, meshes, chosen) if chosen else (mobility, tuple(meshes))


def _below(mobility: Mobility, parent: int) -> list[int]:
    return [index for index, body in enumerate(mobility.bodies) if body.parent == parent]


def _first_of_the_largest(those: Sequence[int], meshes: Sequence[Mesh], smallest: float, to_z_up: F64) -> int | None:
    """Of the largest of some bodies, the first in a row; None if all are smaller than `smallest`."""
    sizes = {index: _diagonal(meshes[index]) for index in those}
    fit = [index for index in those if sizes[index] >= max(AS_LARGE * max(sizes.values()), smallest)]
    if not fit:
        return None
    boxes = ((meshes[index].vertices.min(axis=0), meshes[index].vertices.max(axis=0)) for index in fit)
    centers = np.stack([0.5 * (low + high) for low, high in boxes])
    return fit[int(in_a_row(centers @ to_z_up.T)[0])]


def _without_base(mobility: Mobility, meshes: Sequence[Mesh], chosen: int) -> tuple[Mobility, tuple[Mesh, ...]]:
    """The object without its base, in whose place is a body that hung by it."""
    bodies = mobility.bodies
    order = [chosen, *(index for index in range(1, len(bodies)) if index != chosen)]
    place = {index: position for position, index in enumerate(order)} | {0: 0}
    found = [replace(bodies[chosen], id=0, parent=None, joint=None)]
    for body in (bodies[index] for index in order[1:]):
        joint, base = body.joint, bodies[chosen].joint
        if body.parent == 0 and joint is not None and base is not None:
            joint = against(joint, base)
        found.append(replace(body, id=place[body.id], parent=None if body.parent is None else place[body.parent], joint=joint))
    return replace(mobility, bodies=tuple(found)), tuple(meshes[index] for index in order)


def _exchanged(mobility: Mobility, meshes: Sequence[Mesh], chosen: int) -> tuple[Mobility, tuple[Mesh, ...]]:
    """The same object, with a body below the base for its base."""
    bodies = mobility.bodies
    joint = bodies[chosen].joint
    back = None if joint is None else replace(joint, direction=-joint.direction)  # seen from the other side
    order = [chosen, 0, *(index for index in range(1, len(bodies)) if index != chosen)]
    place = {index: position for position, index in enumerate(order)}
    found = [replace(bodies[chosen], id=0, parent=None, joint=None), replace(bodies[0], id=1, parent=0, joint=back)]
    for body in (bodies[index] for index in order[2:]):
        found.append(replace(body, id=place[body.id], parent=None if body.parent is None else place[body.parent]))
    return replace(mobility, bodies=tuple(found)), tuple(meshes[index] for index in order)


def against(mine: Joint, other: Joint) -> Joint:
    """How a part moves against another, both of which hang by the same thing, the one by `mine`, the other by `other`."""
    along = float(mine.direction @ other.direction)
    if mine.kind is not other.kind or mine.kind is JointKind.SCREW or abs(along) < SAME_DIRECTION:
        return mine
    if mine.kind is JointKind.REVOLUTE and np.linalg.norm(np.cross(other.pivot - mine.pivot, mine.direction)) > SAME_AXIS:
        return mine
    other = other if along > 0.0 else other.reversed()
    rest = mine.rest - other.rest
    if mine.lower is None or mine.upper is None or other.lower is None or other.upper is None:
        return replace(mine, lower=None, upper=None, rest=rest)
    return replace(mine, lower=mine.lower - other.upper, upper=mine.upper - other.lower, rest=rest)


def _diagonal(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) if len(mesh.vertices) else 0.0
