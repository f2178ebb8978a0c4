"""Rigid bodies of a URDF at rest (all joints at zero), in the frame of its root link."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.evaluation.metrics import axis_error
from kinmo.io.readers.urdf_meshes import NO_TRIANGLES, Triangles
from kinmo.io.readers.urdf_reader import JointElement, Matrix, RobotFile

FIXED = "fixed"  # type of a URDF joint that does not move
KINDS = {
    "revolute": JointKind.REVOLUTE,
    "continuous": JointKind.REVOLUTE,
    "prismatic": JointKind.PRISMATIC,
    "screw": JointKind.SCREW,
    "cylindrical": JointKind.SCREW,
}
"""Kinds of joints by the type of the URDF joint. Other types move, but are none of kinmo's kinds."""
SAME_AXIS_ANGLE = math.radians(5.0)
"""A slider and a hinge in a row are a screw if their axes are at most this far apart, in radians."""


@dataclass(frozen=True, eq=False)
class RobotBody:
    """Links that move as one rigid body, named after the topmost one, with triangles [T, 3, 3] in the frame of the root link.

    `parent` is the index of the body that this one moves against, None for a top body. A body that `moves` by none of kinmo's
    kinds has no `joint`.
    """

    name: str
    triangles: Triangles
    parent: int | None = None
    joint: Joint | None = None
    moves: bool = False


def link_poses(robot: RobotFile) -> dict[str, Matrix]:
    """Transforms [4, 4] from each link to the root link, by name."""
    poses: dict[str, Matrix] = {}
    for name in robot.links:
        joint = robot.joint_above.get(name)
        poses[name] = np.eye(4) if joint is None else poses[joint.parent] @ joint.pose
    return poses


def rigid_heads(robot: RobotFile) -> dict[str, str]:
    """Name of the topmost link of the rigid body that each link belongs to."""
    head: dict[str, str] = {}
    for name in robot.links:
        joint = robot.joint_above.get(name)
        head[name] = name if joint is None or joint.type != FIXED else head[joint.parent]
    return head


def robot_bodies(robot: RobotFile) -> tuple[RobotBody, ...]:
    """The bodies of a robot that have geometry, each after its parent.

    Links with a fixed joint between them are one body. A chain of joints through bodies without geometry is one joint. A single
    top body is the base and does not move, even if a joint connects it to an empty world.
    """
    above, head = robot.joint_above, rigid_heads(robot)
    poses = link_poses(robot)
    pieces: dict[str, list[Triangles]] = {}
    for name in robot.links:
        pieces.setdefault(head[name], []).extend(piece.moved(poses[name]) for piece in robot.pieces[name])
    triangles_of_head = {name: np.concatenate([NO_TRIANGLES, *parts]) for name, parts in pieces.items()}

    bodies: list[RobotBody] = []
    index: dict[str, int] = {}
    for name, triangles in triangles_of_head.items():
        if not len(triangles):
            continue
        link, chain = name, []
        while link in above:
            chain.append((above[link], poses[link]))
            link = head[above[link].parent]
            if link in index:
                break
        index[name] = len(bodies)
        bodies.append(RobotBody(name, triangles, index.get(link) if chain else None, _joint(chain), bool(chain)))
    tops = [number for number, body in enumerate(bodies) if body.parent is None]
    if len(tops) == 1:
        bodies[tops[0]] = replace(bodies[tops[0]], joint=None, moves=False)
    return tuple(bodies)


def _joint(chain: list[tuple[JointElement, Matrix]]) -> Joint | None:
    """The joint equal to a chain of joints, each with the pose of its child link; None if it is none of kinmo's kinds."""
    joints = [
        Joint(KINDS[element.type], pose[:3, :3] @ element.axis, pose[:3, 3], *(element.limits or (None, None)))
        for element, pose in chain
        if element.type in KINDS
    ]
    if len(joints) < len(chain) or not joints:
        return None
    if len(joints) == 1:
        return joints[0]
    by_kind = {joint.kind: joint for joint in joints}
    if len(joints) > 2 or set(by_kind) != {JointKind.REVOLUTE, JointKind.PRISMATIC}:
        return None
    turn, slide = by_kind[JointKind.REVOLUTE], by_kind[JointKind.PRISMATIC]
    if axis_error(turn.direction, slide.direction) > SAME_AXIS_ANGLE:
        return None
    along = slide if np.dot(turn.direction, slide.direction) >= 0 else slide.reversed()
    return Joint(JointKind.SCREW, turn.direction, turn.pivot, along.lower, along.upper)
