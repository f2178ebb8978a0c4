"""The rigid bodies of a URDF, at rest, in the frame of its root link."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.evaluation.metrics import axis_error
from kinmo.io.readers.urdf_meshes import NO_TRIANGLES, Triangles
from kinmo.io.readers.urdf_reader import JointElement, Matrix, RobotFile

FIXED = "fixed"
KINDS = {
    "revolute": JointKind.REVOLUTE,
    "continuous": JointKind.REVOLUTE,
    "prismatic": JointKind.PRISMATIC,
    "screw": JointKind.SCREW,
    "cylindrical": JointKind.SCREW,
}
SAME_AXIS_WITHIN = math.radians(5.0)
"""A slide and a turn in a row about axes closer than this are a screw."""


@dataclass(frozen=True, eq=False)
class RobotBody:
    """Links that move as one. `moves` without a `joint` is a motion that is none of kinmo's kinds.

    `parent` is the index of the body it moves against.
    """

    name: str
    triangles: Triangles
    parent: int | None = None
    joint: Joint | None = None
    moves: bool = False


def robot_bodies(robot: RobotFile) -> tuple[RobotBody, ...]:
    """The bodies that have geometry, each after its parent.

    Links that are fastened to each other are one body, and a chain of joints through bodies without geometry is one joint. A
    single top body is the base and does not move, even where a joint ties it to an empty world.
    """
    above = robot.above
    poses: dict[str, Matrix] = {}
    head: dict[str, str] = {}
    pieces: dict[str, list[Triangles]] = {}
    for name in robot.links:
        poses[name] = poses[above[name].parent] @ above[name].pose if name in above else np.eye(4)
        fastened = name in above and above[name].type == FIXED
        head[name] = head[above[name].parent] if fastened else name
        world = [_moved(poses[name] @ pose, triangles) for triangles, pose in robot.pieces[name]]
        pieces.setdefault(head[name], []).extend(world)
    soups = {name: np.concatenate([NO_TRIANGLES, *parts]) for name, parts in pieces.items()}

    bodies: list[RobotBody] = []
    index: dict[str, int] = {}
    for name in (name for name in soups if len(soups[name])):
        link, chain = name, []
        while link in above:
            chain.append((above[link], poses[link]))
            link = head[above[link].parent]
            if link in index:
                break
        index[name] = len(bodies)
        bodies.append(RobotBody(name, soups[name], index.get(link) if chain else None, _joint(chain), bool(chain)))
    tops = [place for place, body in enumerate(bodies) if body.parent is None]
    if len(tops) == 1:
        bodies[tops[0]] = replace(bodies[tops[0]], joint=None, moves=False)
    return tuple(bodies)


def _joint(chain: list[tuple[JointElement, Matrix]]) -> Joint | None:
    """The joint that a chain of joints amounts to, with the poses of their child links; None if it is none of kinmo's."""
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
    if axis_error(turn.direction, slide.direction) > SAME_AXIS_WITHIN:
        return None
    along = slide if np.dot(turn.direction, slide.direction) >= 0 else slide.reversed()
    return Joint(JointKind.SCREW, turn.direction, turn.pivot, along.lower, along.upper)


def _moved(pose: Matrix, triangles: Triangles) -> Triangles:
    return np.asarray(triangles @ pose[:3, :3].T + pose[:3, 3])
