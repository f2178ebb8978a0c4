"""Limits of joints that stop before a link hits a part that it does not touch at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinmo import _core
from kinmo.core.shape import Mesh
from kinmo.robot.robot import Robot, RobotJoint, RobotJointKind

TOUCH = 0.005
"""Largest distance of parts that touch at rest, in diagonals of the object."""
SAMPLES = 500
"""Points on each moving part that its distance from others is measured at."""
STEPS = 32
"""Steps from the pose of the file to each limit. Paths are straight within a step."""
MIN_TRAVEL = 0.2
"""Least share of the travel to a limit that is left. Otherwise the limit stays, since the axis may be wrong."""


def with_safe_limits(robot: Robot) -> Robot:
    """The robot with limits moved to where its parts, as they look, would hit others.

    Parts that touch at rest do not count: they rub at hinges and rails. Links that are below the moving one move along.
    """
    visuals = [visual for link in robot.links for visual in link.visuals]
    links = np.repeat(np.arange(len(robot.links)), [len(link.visuals) for link in robot.links])
    if not visuals:
        return robot
    meshes = [visual.mesh for visual in visuals]
    every = _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])
    joints = []
    for joint in robot.joints:
        is_moving = np.isin(links, robot.links_below(joint.child))
        moving, still = (np.flatnonzero(own).tolist() for own in (is_moving, ~is_moving))
        obstacles = _apart(every, meshes, moving, still, TOUCH * robot.diagonal)
        origin = robot.links[joint.child].origin
        joints.append(_stopped(joint, origin, every, moving, obstacles) if moving and obstacles else joint)
    return replace(robot, joints=tuple(joints))


def stop_notes(before: Sequence[RobotJoint], after: Sequence[RobotJoint]) -> tuple[str, ...]:
    """A note for each joint that got other limits."""
    found = []
    for old, new in zip(before, after, strict=True):
        if (old.lower, old.upper) != (new.lower, new.upper) and new.lower is not None and new.upper is not None:
            unit, scale = ("mm", 1000.0) if new.kind is RobotJointKind.PRISMATIC else ("degrees", math.degrees(1.0))
            ends = f"{scale * new.lower:.0f} and {scale * new.upper:.0f} {unit}"
            found.append(f"{new.name} stops at {ends}, where it hits another part")
    return tuple(found)


def _apart(every: _core.Meshes, meshes: Sequence[Mesh], moving: Sequence[int], still: Sequence[int], touch: float) -> list[int]:
    """Those of the parts that stay which do not touch a moving one."""
    if not moving or not still:
        return []
    own = _core.Meshes([meshes[index].vertices for index in moving], [meshes[index].faces for index in moving])
    points = np.concatenate([each.astype(np.float64) for each in _core.sample_surface(own, SAMPLES)[0]])
    return [index for index in still if float(_core.closest_points(every, [index], points)[0].min()) > touch]


def _stopped(
    joint: RobotJoint, origin: np.ndarray, every: _core.Meshes, moving: Sequence[int], obstacles: Sequence[int]
) -> RobotJoint:
    if joint.lower is None or joint.upper is None:
        return joint
    kind = np.array([1 if joint.kind is RobotJointKind.PRISMATIC else 0], np.uint8)
    ends = np.array([min(joint.lower, 0.0)]), np.array([max(joint.upper, 0.0)])
    axis = np.asarray(joint.axis, np.float64)[None], np.asarray(origin, np.float64)[None]
    low, high, _ = _core.sweep(every, list(moving), list(obstacles), kind, *axis, *ends, steps=STEPS)
    lower = float(low[0]) if float(low[0]) <= MIN_TRAVEL * joint.lower else joint.lower
    upper = float(high[0]) if float(high[0]) >= MIN_TRAVEL * joint.upper else joint.upper
    return replace(joint, lower=max(lower, joint.lower), upper=min(upper, joint.upper))
