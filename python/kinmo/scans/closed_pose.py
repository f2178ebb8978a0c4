"""The state in which all objects of a category are compared: files show doors open and shut, networks want one of the two."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import Pose, forward
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh
from kinmo.scans.axis_alignment import straight_values

ALIKE = 0.01
"""Two states take up as much room if they differ by no more than this share."""
SWINGS, INSIDE = math.radians(40.0), 0.75
"""A hinge that opens by so much to either side, as that of a door which swings both ways, is closed between, if the object
takes up less than this share of the room there that it does at either end."""


def closed(mobility: Mobility, meshes: Sequence[Mesh], base_is_seen: bool = True) -> tuple[Mobility, tuple[Mesh, ...]]:
    """The object with every joint closed, and with directions that point from there to the open end of its range.

    `meshes` are those of the bodies. Of the two ends that one is the closed one at which the object takes up less room, by the
    volume of its box along the axes of the frame, the other joints as they are; where both take up as much, since another part
    stands open as far, at which its part does with all that it hangs by, if its `base_is_seen`; and else the one that the
    file's state is nearer to. A hinge that swings both ways (`SWINGS`) is closed where its part lies straight between them, and
    what the file shows half way between ends that nothing tells apart stays there, again if its base is seen. A joint without
    limits stays, and the direction of what opens to neither side more has its largest coordinate positive.
    """
    clouds = [mesh.corners for mesh in meshes]
    joints = {index: body.joint for index, body in mobility.movable() if body.joint is not None}
    found = {index: _closed(index, joint, mobility, meshes[index], clouds, base_is_seen) for index, joint in joints.items()}
    mobility = _with_joints(mobility, {index: joint for index, (joint, _) in found.items()})
    poses = forward(mobility, {index: value for index, (_, value) in found.items()})
    placed = {}
    for index, (joint, value) in found.items():
        parent = mobility.bodies[index].parent
        above = np.eye(4) if parent is None else poses[parent]
        pivot = above[:3, :3] @ joint.pivot + above[:3, 3]
        placed[index] = replace(joint, direction=above[:3, :3] @ joint.direction, pivot=pivot, rest=value)
    moved = (Mesh(moved_by(pose, mesh.vertices), mesh.faces) for pose, mesh in zip(poses, meshes, strict=True))
    return _with_joints(mobility, placed), tuple(moved)


def _closed(
    index: int, joint: Joint, mobility: Mobility, mesh: Mesh, clouds: Sequence[NDArray[np.float64]], base_is_seen: bool
) -> tuple[Joint, float]:
    """The joint, pointed from closed to open, and its value where it is closed."""
    if joint.lower is None or joint.upper is None:
        return pointed_as_usual(joint), joint.rest

    def room(value: float, bodies: Iterable[int] = range(len(clouds))) -> float:
        return _room(forward(mobility, {index: value}), clouds, bodies)

    low, high = room(joint.lower), room(joint.upper)
    if joint.kind is JointKind.REVOLUTE:
        inside = min(straight_values(joint, mesh, joint.lower + SWINGS, joint.upper - SWINGS), key=room, default=None)
        if inside is not None and room(inside) < INSIDE * min(low, high):
            return _from_within(joint, float(inside), inside - joint.lower, joint.upper - inside)
    if base_is_seen and _alike(low, high):
        own = (index, *_above(index, mobility))
        low, high = room(joint.lower, own), room(joint.upper, own)
    if not _alike(low, high):
        return _from_end(joint, joint.upper if high < low else joint.lower)
    if base_is_seen and is_midway(joint):
        return _from_within(joint, joint.rest, joint.rest - joint.lower, joint.upper - joint.rest)
    return _from_end(joint, joint.upper if joint.rest - joint.lower > joint.upper - joint.rest else joint.lower)


def _from_end(joint: Joint, value: float) -> tuple[Joint, float]:
    """A joint that is closed at one of its ends, pointed to the other."""
    return (joint.reversed(), -value) if value == joint.upper != joint.lower else (joint, value)


def _from_within(joint: Joint, value: float, to_lower: float, to_upper: float) -> tuple[Joint, float]:
    """A joint that is closed at a value inside its range, pointed to the farther end, or as usual where both are as far."""
    is_reversed = pointed_as_usual(joint) is not joint if _alike_far(to_lower, to_upper) else to_lower > to_upper
    return (joint.reversed(), -value) if is_reversed else (joint, value)


def is_midway(joint: Joint) -> bool:
    """Whether a joint with limits rests half way between them, so that neither end is the open one."""
    if joint.lower is None or joint.upper is None:
        return False
    return _alike_far(joint.rest - joint.lower, joint.upper - joint.rest)


def _alike_far(to_lower: float, to_upper: float) -> bool:
    return abs(to_upper - to_lower) <= ALIKE * (to_upper + to_lower)


def pointed_as_usual(joint: Joint) -> Joint:
    """A joint that opens to neither side more, with that direction of the two whose largest coordinate is positive."""
    return joint if joint.direction[np.argmax(np.abs(joint.direction))] > 0.0 else joint.reversed()


def _above(index: int, mobility: Mobility) -> Iterator[int]:
    """What a body hangs by, and what that does, up to the base."""
    while (parent := mobility.bodies[index].parent) is not None:
        yield parent
        index = parent


def _alike(one: float, other: float) -> bool:
    return abs(one - other) <= ALIKE * max(one, other)


def _room(poses: Pose, clouds: Sequence[NDArray[np.float64]], bodies: Iterable[int]) -> float:
    return room_of(np.concatenate([moved_by(poses[body], clouds[body]) for body in bodies]))


def room_of(points: NDArray[np.float64]) -> float:
    """The volume of the box of some points along the axes."""
    return float(np.prod(np.maximum(np.ptp(points, axis=0), 1e-9)))


def moved_by(pose: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points [n, 3] where a pose takes them."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _with_joints(mobility: Mobility, joints: dict[int, Joint]) -> Mobility:
    bodies = (replace(body, joint=joints.get(index)) for index, body in enumerate(mobility.bodies))
    return replace(mobility, bodies=tuple(bodies))
