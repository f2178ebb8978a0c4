"""Limits of joints that stop before a link hits a part that it does not touch at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.shape import Mesh, bounds_of
from kinmo.robot.robot import Robot, RobotJoint, RobotJointKind

TOUCH = 0.005
"""Largest distance of parts that touch at rest, in diagonals of the object."""
SAMPLES = 500
"""Points on each moving part that its distance from others is measured at."""
STEPS = 32
"""Steps from the pose of the file to each limit. Paths are straight within a step."""
MIN_TRAVEL = 0.2
"""Least share of the travel to a limit that is left. Otherwise the limit stays, since the axis may be wrong."""


MIN_OVERLAP = 0.1
"""Share of its length in its parent that a drawer keeps there."""
MIN_LENGTH = 0.05
"""Least length of a drawer, in diagonals of the object. Shorter links are buttons and plates."""
INSIDE = 0.02
"""Largest distance that a drawer sticks out of its parent's box to the sides, in diagonals of the object."""


def with_safe_limits(robot: Robot) -> Robot:
    """The robot with limits moved to where its parts, as they look, would hit others, and where drawers would fall out.

    Parts that touch at rest do not count: they rub at hinges and rails. Links that are below the moving one move along.
    """
    visuals = [visual for link in robot.links for visual in link.visuals]
    links = np.repeat(np.arange(len(robot.links)), [len(link.visuals) for link in robot.links])
    if not visuals:
        return robot
    meshes = [visual.mesh for visual in visuals]
    every = _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])
    boxes = np.array([(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for mesh in meshes])
    joints = []
    for joint in robot.joints:
        is_moving = np.isin(links, robot.links_below(joint.child))
        moving, still = (np.flatnonzero(own).tolist() for own in (is_moving, ~is_moving))
        obstacles = _apart(every, meshes, boxes, moving, still, TOUCH * robot.diagonal)
        origin = robot.links[joint.child].origin
        stopped = _stopped(joint, origin, every, moving, obstacles) if moving and obstacles else joint
        joints.append(_kept_inside(stopped, robot))
    return replace(robot, joints=tuple(joints))


def stop_notes(before: Sequence[RobotJoint], after: Sequence[RobotJoint]) -> tuple[str, ...]:
    """A note for each joint that got other limits."""
    found = []
    for old, new in zip(before, after, strict=True):
        limits = new.lower, new.upper, old.lower, old.upper
        if limits[:2] == limits[2:] or None in limits:
            continue
        unit, scale = ("mm", 1000.0) if new.kind is RobotJointKind.PRISMATIC else ("degrees", math.degrees(1.0))
        low, high, least, most = (f"{scale * limit:.0f}" for limit in limits if limit is not None)
        ends = f"{low} and {high} {unit} instead of {least} and {most}"
        found.append(f"{new.name} stops at {ends}: it hits a part or leaves its place beyond")
    return tuple(found)


def _apart(
    every: _core.Meshes,
    meshes: Sequence[Mesh],
    boxes: NDArray[np.float64],
    moving: Sequence[int],
    still: Sequence[int],
    touch: float,
) -> list[int]:
    """Those of the parts that stay which do not touch a moving one; `boxes` [N, 2, 3] has corners around all parts."""
    if not moving or not still:
        return []
    low, high = bounds_of(meshes[index] for index in moving)
    around = boxes[list(still)]
    is_near = np.all((around[:, 0] <= high + touch) & (around[:, 1] >= low - touch), axis=1)
    near = np.asarray(still)[is_near].tolist()
    if not near:
        return list(still)
    own = _core.Meshes([meshes[index].vertices for index in moving], [meshes[index].faces for index in moving])
    points = np.concatenate([each.astype(np.float64) for each in _core.sample_surface(own, SAMPLES)[0]])
    touching = {index for index in near if _is_within(touch, points, every, index, boxes[index])}
    return [index for index in still if index not in touching]


def _is_within(reach: float, points: NDArray[np.float64], every: _core.Meshes, index: int, box: NDArray[np.float64]) -> bool:
    """True if one of `points` [N, 3] is at most `reach` from the mesh at `index`, which is inside `box` [2, 3]."""
    wide = reach * (1.0 + 1e-9)  # rounding must not lose a point
    low, high = box[0] - wide, box[1] + wide
    close = points[np.all((points >= low) & (points <= high), axis=1)]
    return bool(len(close)) and float(_core.closest_points(every, [index], close)[0].min()) <= reach


def _kept_inside(joint: RobotJoint, robot: Robot) -> RobotJoint:
    """A sliding joint that keeps an overlap with its parent, if its link is a drawer: long, and mostly inside its parent."""
    own, around = (
        np.concatenate([np.zeros((0, 3)), *(visual.mesh.corners for visual in robot.links[link].visuals)])
        for link in (joint.child, joint.parent)
    )
    is_limited = joint.lower is not None and joint.upper is not None
    if joint.kind is not RobotJointKind.PRISMATIC or not is_limited or not len(own) or not len(around):
        return joint
    frame = np.linalg.svd(np.asarray(joint.axis, float)[None])[2]  # the axis, and two directions across it
    frame[0] = joint.axis
    (low, high), (least, most) = ((points.min(axis=0), points.max(axis=0)) for points in (own @ frame.T, around @ frame.T))
    slack = INSIDE * robot.diagonal
    inside = float(min(high[0], most[0]) - max(low[0], least[0]))
    length = float(high[0] - low[0])
    if length < MIN_LENGTH * robot.diagonal or inside < 0.5 * length:
        return joint
    if np.any(low[1:] < least[1:] - slack) or np.any(high[1:] > most[1:] + slack):
        return joint
    lower, upper = float(least[0] - high[0]) + MIN_OVERLAP * inside, float(most[0] - low[0]) - MIN_OVERLAP * inside
    return replace(joint, lower=max(joint.lower or 0.0, min(lower, 0.0)), upper=min(joint.upper or 0.0, max(upper, 0.0)))


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
