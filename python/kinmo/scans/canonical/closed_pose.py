"""Closed pose of an object with known joint limits; files show doors open and shut, networks need one of the two."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import Pose, forward, joint_motion
from kinmo.core.mobility import Mobility, path_to_root
from kinmo.core.shape import Mesh

F64 = NDArray[np.float64]
Parts = tuple[Mobility, tuple[Mesh, ...]]
"""Joints of an object and the meshes of its bodies."""

EQUAL_SHARE = 0.01
"""Relative difference up to which two volumes, or two openings, count as equal."""
MIN_SWING, MAX_INNER_VOLUME = math.radians(40.0), 0.75
"""A swing door is closed between its ends. Such a hinge opens by at least `MIN_SWING` rad to either side, and the object's
box is smaller there than `MAX_INNER_VOLUME` times the box at either end."""
ANGLE_STEP = math.radians(3.0)
"""Step of the search for axis-aligned angles, rad."""
MAX_MISALIGNMENT = 1.12
"""Largest misalignment (`axis_aligned_values`) of an axis-aligned part; an axis-aligned box has 1."""
MISALIGNMENT_TOLERANCE = 0.03
"""Excess over the least misalignment up to which another angle is axis-aligned too."""


def close_joints(mobility: Mobility, meshes: Sequence[Mesh], base_is_visible: bool = True) -> Parts:
    """Move an object to its closed pose.

    The closed end of a joint is chosen by these rules, in this order:

    1. A joint without limits stays.
    2. A hinge that swings both ways (`MIN_SWING`) closes where its part is axis-aligned between the ends.
    3. The end with the smaller axis-aligned box of the object is the closed one; the other joints stay as they are.
    4. If both boxes are equal because another part is open as far, the box of the part and its ancestors decides, given that
       the base is visible.
    5. A joint half way between equal ends stays there, given that the base is visible.
    6. Otherwise the end nearer to the file's state is the closed one.

    Rest values describe `meshes`, one per body. In the result, joint directions point from closed to open. The direction of a
    joint that opens equally to both sides has its largest coordinate positive.
    """
    clouds = [mesh.corners for mesh in meshes]
    joints = {index: body.joint for index, body in mobility.movable() if body.joint is not None}
    closed = {i: _closed_end(i, joint, mobility, meshes[i], clouds, base_is_visible) for i, joint in joints.items()}
    mobility = _with_joints(mobility, {index: joint for index, (joint, _) in closed.items()})
    poses = forward(mobility, {index: value for index, (_, value) in closed.items()})
    placed = {}
    for index, (joint, value) in closed.items():
        parent = mobility.bodies[index].parent
        above = np.eye(4) if parent is None else poses[parent]
        pivot = above[:3, :3] @ joint.pivot + above[:3, 3]
        placed[index] = replace(joint, direction=above[:3, :3] @ joint.direction, pivot=pivot, rest=value)
    moved = (Mesh(transform_points(pose, mesh.vertices), mesh.faces) for pose, mesh in zip(poses, meshes, strict=True))
    return _with_joints(mobility, placed), tuple(moved)


def _closed_end(
    index: int, joint: Joint, mobility: Mobility, mesh: Mesh, clouds: Sequence[F64], base_is_visible: bool
) -> tuple[Joint, float]:
    """The joint, directed from closed to open, and its value where it is closed."""
    if joint.lower is None or joint.upper is None:
        return with_positive_direction(joint), joint.rest

    def volume(value: float, bodies: Iterable[int] = range(len(clouds))) -> float:
        poses = forward(mobility, {index: value})
        return box_volume(np.concatenate([transform_points(poses[body], clouds[body]) for body in bodies]))

    low, high = volume(joint.lower), volume(joint.upper)
    if joint.kind is JointKind.REVOLUTE:
        aligned = axis_aligned_values(joint, mesh, joint.lower + MIN_SWING, joint.upper - MIN_SWING)
        inside = min(aligned, key=volume, default=None)
        if inside is not None and volume(inside) < MAX_INNER_VOLUME * min(low, high):
            return _closed_inside(joint, float(inside), inside - joint.lower, joint.upper - inside)
    if base_is_visible and are_equal_volumes(low, high):
        parents = {i: body.parent for i, body in enumerate(mobility.bodies) if body.parent is not None}
        own = tuple(path_to_root(parents, index))
        low, high = volume(joint.lower, own), volume(joint.upper, own)
    if not are_equal_volumes(low, high):
        return _closed_at(joint, joint.upper if high < low else joint.lower)
    if base_is_visible and rests_midway(joint):
        return _closed_inside(joint, joint.rest, joint.rest - joint.lower, joint.upper - joint.rest)
    return _closed_at(joint, joint.upper if joint.rest - joint.lower > joint.upper - joint.rest else joint.lower)


def _closed_at(joint: Joint, value: float) -> tuple[Joint, float]:
    """A joint that is closed at one of its ends, directed to the other."""
    return (joint.reversed(), -value) if value == joint.upper != joint.lower else (joint, value)


def _closed_inside(joint: Joint, value: float, to_lower: float, to_upper: float) -> tuple[Joint, float]:
    """A joint that is closed inside its range, directed to the farther end, or positively if both are equally far."""
    is_reversed = with_positive_direction(joint) is not joint if _equally_far(to_lower, to_upper) else to_lower > to_upper
    return (joint.reversed(), -value) if is_reversed else (joint, value)


def rests_midway(joint: Joint) -> bool:
    """True for a joint that rests half way between its limits, so that neither end is the open one."""
    if joint.lower is None or joint.upper is None:
        return False
    return _equally_far(joint.rest - joint.lower, joint.upper - joint.rest)


def _equally_far(to_lower: float, to_upper: float) -> bool:
    return abs(to_upper - to_lower) <= EQUAL_SHARE * (to_upper + to_lower)


def with_positive_direction(joint: Joint) -> Joint:
    """The joint or its reverse, whichever has the largest coordinate of its direction positive."""
    return joint if joint.direction[np.argmax(np.abs(joint.direction))] > 0.0 else joint.reversed()


def axis_aligned_values(joint: Joint, mesh: Mesh, low: float, high: float) -> F64:
    """Values [n] of a hinge, strictly between `low` and `high`, at which its part is axis-aligned.

    The misalignment of a part is the mean of |nx| + |ny| + |nz| over its surface, for unit normals n. The result holds its
    least local minima. A part without flat sides has none. A part that is equally aligned at any angle has none either, such
    as a lid that turns in its plane. `mesh` shows the part at the joint's rest value.
    """
    if low >= high:
        return np.zeros(0)
    normals = area_normals(mesh)
    area = float(np.linalg.norm(normals, axis=1).sum())

    def misalignment(value: float) -> float:
        turned = normals @ joint_motion(joint, value)[:3, :3].T
        return float(np.abs(turned).sum()) / max(area, np.finfo(float).tiny)

    values = np.arange(low, high + ANGLE_STEP, ANGLE_STEP)
    sampled = np.array([misalignment(value) for value in values])
    if np.ptp(sampled) <= MISALIGNMENT_TOLERANCE:
        return np.zeros(0)
    minima = 1 + np.flatnonzero((sampled[1:-1] <= sampled[:-2]) & (sampled[1:-1] <= sampled[2:]))
    found = [
        minimize_scalar(misalignment, bounds=(value - ANGLE_STEP, min(value + ANGLE_STEP, high)), method="bounded")
        for value in values[minima]
    ]
    limit = min(MAX_MISALIGNMENT, min((float(end.fun) for end in found), default=math.inf) + MISALIGNMENT_TOLERANCE)
    return np.array([float(end.x) for end in found if end.fun <= limit])


def area_normals(mesh: Mesh) -> F64:
    """Normals [F, 3] of a mesh's faces; their lengths are twice the areas."""
    corners = mesh.triangles
    return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def are_equal_volumes(one: float, other: float) -> bool:
    """True for volumes that differ by `EQUAL_SHARE` at most."""
    return abs(one - other) <= EQUAL_SHARE * max(one, other)


def box_volume(points: F64) -> float:
    """Volume of the axis-aligned box of points [n, 3]; each side counts 1e-9 at least."""
    return float(np.prod(np.maximum(np.ptp(points, axis=0), 1e-9)))


def box_middle(points: F64) -> F64:
    """Middle [3] of the axis-aligned box of points [n, 3]."""
    return np.asarray(0.5 * (points.min(axis=0) + points.max(axis=0)))


def transform_points(pose: Pose, points: F64) -> F64:
    """Points [n, 3] moved by a pose [4, 4]."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _with_joints(mobility: Mobility, joints: dict[int, Joint]) -> Mobility:
    bodies = (replace(body, joint=joints.get(index)) for index, body in enumerate(mobility.bodies))
    return replace(mobility, bodies=tuple(bodies))
