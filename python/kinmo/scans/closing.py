"""The state in which all objects of a category are compared: files show doors open and shut, networks want one of the two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.joint import Joint
from kinmo.kinematics import Pose, forward
from kinmo.mobility import Mobility
from kinmo.shape import Mesh

ALIKE = 0.01
"""Two states take up as much room if they differ by no more than this share."""


def closed(mobility: Mobility, meshes: Sequence[Mesh]) -> tuple[Mobility, tuple[Mesh, ...]]:
    """The object with every joint at the closed end of its range, and with directions that point from there to the open one.

    `meshes` are those of the bodies. Of the two ends that one is the closed one at which the object takes up less room, by the
    volume of its box along the axes of the frame, the other joints as they are; where both take up as much, the one that the
    file's state is nearer to. A joint without limits stays, and its direction has its largest coordinate positive.
    """
    clouds = [mesh.vertices[np.unique(mesh.faces)] for mesh in meshes]
    joints = {index: body.joint for index, body in mobility.movable() if body.joint is not None}
    oriented = {index: _oriented(index, joint, mobility, clouds) for index, joint in joints.items()}
    mobility = _with_joints(mobility, oriented)
    values = {index: joint.lower for index, joint in oriented.items() if joint.lower is not None}
    poses = forward(mobility, values)
    placed = {}
    for index, joint in oriented.items():
        parent = mobility.bodies[index].parent
        above = np.eye(4) if parent is None else poses[parent]
        pivot = above[:3, :3] @ joint.pivot + above[:3, 3]
        placed[index] = replace(
            joint, direction=above[:3, :3] @ joint.direction, pivot=pivot, rest=values.get(index, joint.rest)
        )
    moved = (Mesh(moved_by(pose, mesh.vertices), mesh.faces) for pose, mesh in zip(poses, meshes, strict=True))
    return _with_joints(mobility, placed), tuple(moved)


def _oriented(index: int, joint: Joint, mobility: Mobility, clouds: Sequence[NDArray[np.float64]]) -> Joint:
    """The joint with its closed end below."""
    if joint.lower is None or joint.upper is None:
        return pointed_as_usual(joint)
    low, high = (_room(forward(mobility, {index: end}), clouds) for end in (joint.lower, joint.upper))
    if abs(low - high) <= ALIKE * max(low, high):
        is_reversed = joint.rest - joint.lower > joint.upper - joint.rest
    else:
        is_reversed = high < low
    return joint.reversed() if is_reversed else joint


def pointed_as_usual(joint: Joint) -> Joint:
    """A joint without limits, with that direction of the two whose largest coordinate is positive."""
    return joint if joint.direction[np.argmax(np.abs(joint.direction))] > 0.0 else joint.reversed()


def _room(poses: Pose, clouds: Sequence[NDArray[np.float64]]) -> float:
    moved = np.concatenate([moved_by(pose, cloud) for pose, cloud in zip(poses, clouds, strict=True)])
    return room_of(moved)


def room_of(points: NDArray[np.float64]) -> float:
    """The volume of the box of some points along the axes."""
    return float(np.prod(np.maximum(np.ptp(points, axis=0), 1e-9)))


def moved_by(pose: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points [n, 3] where a pose takes them."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _with_joints(mobility: Mobility, joints: dict[int, Joint]) -> Mobility:
    bodies = (replace(body, joint=joints.get(index)) for index, body in enumerate(mobility.bodies))
    return replace(mobility, bodies=tuple(bodies))
