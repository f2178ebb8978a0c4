"""Rigid bodies of a robot at rest (all joints at zero), in the frame of its root link."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.io.readers.robot_file import FIXED, JointElement, Matrix, RobotFile

Triangles = NDArray[np.float64]
"""A triangle soup [T, 3, 3]."""

NO_TRIANGLES: Triangles = np.zeros((0, 3, 3))
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
    kinds has no `joint`. `links` are the names of its links that have geometry.
    """

    name: str
    triangles: Triangles
    parent: int | None = None
    joint: Joint | None = None
    moves: bool = False
    links: tuple[str, ...] = ()


def link_poses(robot: RobotFile) -> dict[str, Matrix]:
    """Transforms [4, 4] from the links to the root link, by name."""
    poses: dict[str, Matrix] = {}
    for name in robot.links:
        joint = robot.joint_above.get(name)
        poses[name] = np.eye(4) if joint is None else poses[joint.parent] @ joint.pose
    return poses


def robot_bodies(robot: RobotFile) -> tuple[RobotBody, ...]:
    """The bodies of a robot that have geometry, each after its parent.

    Links with a fixed joint between them are one body. A chain of joints through bodies without geometry is one joint. A single
    top body is the base and does not move, even if a joint connects it to an empty world.
    """
    above = robot.joint_above
    poses = link_poses(robot)
    head: dict[str, str] = {}
    links: dict[str, list[str]] = {}
    for name in robot.links:
        is_fixed = name in above and above[name].type == FIXED
        head[name] = head[above[name].parent] if is_fixed else name
        own = links.setdefault(head[name], [])
        if any(len(piece.mesh.faces) for piece in robot.pieces[name]):
            own.append(name)

    bodies: list[RobotBody] = []
    index: dict[str, int] = {}
    for name, own in links.items():
        if not own:
            continue
        link, chain = name, []
        while link in above:
            chain.append((above[link], poses[link]))
            link = head[above[link].parent]
            if link in index:
                break
        index[name] = len(bodies)
        triangles = np.concatenate([_moved(poses[each], piece.mesh.triangles) for each in own for piece in robot.pieces[each]])
        bodies.append(RobotBody(name, triangles, index.get(link) if chain else None, _joint(chain), bool(chain), tuple(own)))
    tops = [number for number, body in enumerate(bodies) if body.parent is None]
    if len(tops) == 1:
        bodies[tops[0]] = replace(bodies[tops[0]], joint=None, moves=False)
    return tuple(bodies)


def _joint(chain: list[tuple[JointElement, Matrix]]) -> Joint | None:
    """The joint equal to a chain of joints, each with the pose of its child link; None if it is none of kinmo's kinds."""
    joints = [
        Joint(
            KINDS[element.type],
            pose[:3, :3] @ element.axis,
            pose[:3, :3] @ element.pivot + pose[:3, 3],
            *(element.limits or (None, None)),
        )
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
    cosine = float(np.dot(turn.direction, slide.direction))
    if abs(cosine) < math.cos(SAME_AXIS_ANGLE):
        return None
    along = slide if cosine >= 0 else slide.reversed()
    return Joint(JointKind.SCREW, turn.direction, turn.pivot, along.lower, along.upper)


def _moved(pose: Matrix, triangles: Triangles) -> Triangles:
    return np.asarray(triangles @ pose[:3, :3].T + pose[:3, 3])
