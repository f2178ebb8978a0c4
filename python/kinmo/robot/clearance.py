"""Clearance between the links of a robot: collision shapes are cut back where they overlap at rest or on their way.

Predicted axes are off by a little, and real parts touch at hinges and stops. A simulator pushes overlapping shapes apart, and
the object moves by itself or jams. So shapes that nearly touch are cut by planes until a small gap is between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.kinematics import Pose
from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.robot.collision_shapes import CollisionShape, Cylinder, Hull
from kinmo.robot.convex_hulls import hull_of, simplest_shape
from kinmo.robot.robot import Collision, Robot, RobotJoint, RobotJointKind

F64 = NDArray[np.float64]

GAP = 0.002
"""Least gap between two links, in diagonals of the object."""
MARGINS = 0.002
"""Least gap between two links in metres: PyBullet adds a margin of a millimetre to each hull."""
MAX_GAP = 0.01
"""Largest gap for the sake of the margins, in diagonals of the object."""
MAX_CUT_AT_REST = 0.4
"""Largest share of its extent that a shape loses for the pose of the file. Otherwise the smaller shape is dropped."""
MAX_CUT_ON_THE_WAY = 0.25
"""Largest share of its extent there that a shape loses to all other joint values. Otherwise the joint stops before."""
MIN_TRAVEL = 0.5
"""Least share of the travel to a limit that is left if the joint stops before. Otherwise the smaller shape is dropped."""
STEP = 0.004
"""Longest path of a point between two joint values that are looked at, in diagonals of the object."""
MAX_STEPS = 500
"""Most joint values from the pose of the file to a limit that are looked at."""
FULL_TURN = (-np.pi, np.pi)
"""Range of a continuous joint."""
MIN_FLATNESS = 1e-3
"""Least thickness of a cut shape, as a share of its largest extent."""
MAX_NORMALS = 40
"""Most directions in which two shapes may be apart that are looked at for each of them."""


@dataclass(eq=False)
class _Piece:
    """A convex collision shape that may be cut.

    Attributes:
        link: index of its link.
        collision: its collision.
        shape: the shape; None after it is dropped.
        points: [V, 3] its corners.
        normals: [K, 3] normals of its faces, without opposite ones.
        whole: [W, 3] its corners before it was cut: at rest, and then before the ways of the joints.
        cuts: number of cuts.
    """

    link: int
    collision: Collision
    shape: CollisionShape | None
    points: F64
    normals: F64
    whole: F64
    cuts: int = 0

    @classmethod
    def of(cls, link: int, collision: Collision) -> _Piece:
        points, normals = _points_and_normals(collision.shape)
        return cls(link, collision, collision.shape, points, normals, points)

    @property
    def size(self) -> float:
        """Volume of its axis-aligned bounding box."""
        return float(np.prod(np.ptp(self.points, axis=0)))

    def cut(self, normal: Vector, level: float) -> None:
        """Keep what is at or above `level` along a unit vector."""
        self.cuts += 1
        heights = self.points @ normal - level
        above, below = self.points[heights >= 0.0], self.points[heights < 0.0]
        if not len(above):
            self.shape = None
            return
        high, low = heights[heights >= 0.0], -heights[heights < 0.0]
        share = (low[None, :] / np.maximum(high[:, None] + low[None, :], 1e-300))[..., None]
        between = (share * above[:, None] + (1.0 - share) * below[None, :]).reshape(-1, 3)
        points = np.concatenate([above, between])
        hull = hull_of(points, MIN_FLATNESS * float(np.ptp(points, axis=0).max()))
        shape = simplest_shape(hull, is_exact=True)  # a larger one would close the gap again
        self.shape = shape
        self.points, self.normals = _points_and_normals(shape)


class _Group:
    """Collision shapes that move together or stay together.

    Attributes:
        pieces: the shapes, at least one.
    """

    def __init__(self, pieces: Sequence[_Piece]) -> None:
        self.pieces = pieces
        self._update()

    def _update(self) -> None:
        self._cuts = [piece.cuts for piece in self.pieces]
        self._points = np.concatenate([piece.points for piece in self.pieces])
        self._starts = np.cumsum([0, *(len(piece.points) for piece in self.pieces[:-1])])
        self._at_rest = self._bounds(self._points)

    def _bounds(self, points: F64) -> tuple[F64, F64]:
        return np.minimum.reduceat(points, self._starts), np.maximum.reduceat(points, self._starts)

    def bounds(self, pose: Pose | None = None) -> tuple[F64, F64]:
        """Corners [P, 3] of the axis-aligned bounding boxes of the shapes, at rest or after a motion [4, 4]."""
        if self._cuts != [piece.cuts for piece in self.pieces]:
            self._update()
        return self._at_rest if pose is None else self._bounds(self._points @ pose[:3, :3].T + pose[:3, 3])

    def reach(self, axis: Vector, origin: Vector) -> float:
        """Distance of the farthest corner from an axis."""
        return float(np.linalg.norm(np.cross(self._points - origin, axis), axis=1).max())


def with_clearance(robot: Robot) -> Robot:
    """The robot with collision shapes that keep a small gap, at rest and where each joint moves alone.

    A limit is moved to where a shape hits another that cannot be cut enough. Shapes of links that are welded together do not
    count, nor do surfaces that are not convex.
    """
    pieces = [
        _Piece.of(index, collision)
        for index, link in enumerate(robot.links)
        for collision in link.collisions
        if isinstance(collision.shape, Box | Cylinder | Hull)
    ]
    if not pieces:
        return robot
    gap = max(GAP * robot.diagonal, min(MARGINS, MAX_GAP * robot.diagonal))
    below = [robot.links_below(index) for index in range(len(robot.links))]
    groups: dict[int, tuple[_Group, _Group]] = {}
    for joint in robot.joints:
        moving = [piece for piece in pieces if piece.link in below[joint.child]]
        others = [piece for piece in pieces if piece.link not in below[joint.child]]
        if not moving or not others:
            continue
        groups[joint.child] = _Group(moving), _Group(others)
        for piece, other in _uncut(*groups[joint.child], np.eye(4), gap, MAX_CUT_AT_REST):
            _drop_smaller(piece, other)
    for piece in pieces:
        piece.whole = piece.points
    joints = [
        _cleared(joint, robot.links[joint.child].origin, *groups[joint.child], robot.diagonal, gap)
        if joint.child in groups
        else joint
        for joint in robot.joints
    ]
    kept: dict[int, list[Collision]] = {index: [] for index in range(len(robot.links))}
    for piece in pieces:
        if piece.shape is not None:
            kept[piece.link].append(replace(piece.collision, shape=piece.shape))
    links = []
    for index, link in enumerate(robot.links):
        surfaces = [each for each in link.collisions if not isinstance(each.shape, Box | Cylinder | Hull)]
        links.append(replace(link, collisions=(*kept[index], *surfaces)))
    return replace(robot, links=tuple(links), joints=tuple(joints))


def _cleared(joint: RobotJoint, origin: Vector, moving: _Group, others: _Group, diagonal: float, gap: float) -> RobotJoint:
    """A joint with limits that it can reach, after its way to them is cleared."""
    is_endless = joint.lower is None or joint.upper is None
    ends = FULL_TURN if joint.lower is None or joint.upper is None else (joint.lower, joint.upper)
    reach = 1.0 if joint.kind is RobotJointKind.PRISMATIC else moving.reach(joint.axis, origin)
    found = []
    for end in ends:
        steps = min(MAX_STEPS, math.ceil(abs(end) * reach / (STEP * diagonal)))
        reached = 0.0
        for value in np.linspace(0.0, end, steps + 1)[1:].tolist():
            stuck = list(_uncut(moving, others, _motion(joint, origin, value), gap, MAX_CUT_ON_THE_WAY))
            if stuck and not is_endless and abs(reached) >= MIN_TRAVEL * abs(end):
                break
            for piece, other in stuck:
                _drop_smaller(piece, other)
            reached = value
        found.append(reached)
    return joint if is_endless else replace(joint, lower=found[0], upper=found[1])


def _drop_smaller(piece: _Piece, other: _Piece) -> None:
    if piece.shape is not None and other.shape is not None:
        (piece if piece.size <= other.size else other).shape = None


def _motion(joint: RobotJoint, origin: Vector, value: float) -> Pose:
    """Motion [4, 4] of a joint's child from value 0."""
    pose = np.eye(4)
    if joint.kind is RobotJointKind.PRISMATIC:
        pose[:3, 3] = value * joint.axis
    else:
        pose[:3, :3] = Rotation.from_rotvec(value * joint.axis).as_matrix()
        pose[:3, 3] = origin - pose[:3, :3] @ origin
    return pose


def _uncut(moving: _Group, others: _Group, pose: Pose, gap: float, most: float) -> Iterator[tuple[_Piece, _Piece]]:
    """Cut shapes of two groups where they are nearer than `gap`, with the first group moved by `pose`.

    Yields the pairs of shapes that would lose more than the share `most` of their extent. They are not cut.
    """
    turn, shift = pose[:3, :3], pose[:3, 3]
    (low, high), (lowest, highest) = moving.bounds(pose), others.bounds()
    near = np.all((low[:, None] - gap <= highest) & (high[:, None] + gap >= lowest), axis=2)
    for row, column in np.argwhere(near):
        piece, other = moving.pieces[row], others.pieces[column]
        if piece.shape is None or other.shape is None:
            continue
        normals = np.concatenate([piece.normals @ turn.T, other.normals])
        here, there = (piece.points @ turn.T + shift) @ normals.T, other.points @ normals.T
        front, back = here.min(axis=0) - there.max(axis=0), there.min(axis=0) - here.max(axis=0)
        if max(front.max(), back.max()) >= gap:
            continue
        needs = 2.0 * gap - np.concatenate([front, back])  # twice the gap, for fewer cuts on the way
        whole = np.ptp((piece.whole @ turn.T) @ normals.T, axis=0), np.ptp(other.whole @ normals.T, axis=0)
        lost = [before - np.ptp(values, axis=0) for before, values in zip(whole, (here, there), strict=True)]
        shares = (needs + np.tile(lost, 2)) / np.maximum(np.tile(whole, 2), 1e-12)
        which, way = np.unravel_index(int(np.argmin(shares)), shares.shape)
        if shares[which, way] > most:
            yield piece, other
            continue
        away = normals[way % len(normals)] * (1.0 if way < len(normals) else -1.0)  # from the other to the moving one
        cut, inward = (piece, turn.T @ away) if which == 0 else (other, -away)
        cut.cut(inward, float((cut.points @ inward).min() + needs[way]))


def _points_and_normals(shape: CollisionShape) -> tuple[F64, F64]:
    """Corners [V, 3] and normals [K, 3] of the faces of a convex shape, at most `MAX_NORMALS`."""
    if isinstance(shape, Box):
        return shape.corners(), shape.axes
    if isinstance(shape, Cylinder):
        return shape.corners(), shape.normals()
    mesh: Mesh = shape.mesh
    a, b, c = np.moveaxis(mesh.triangles, 1, 0)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    order = np.argsort(-areas, kind="stable")
    normals = normals[order] / np.maximum(areas[order, None], 1e-300)
    found, count = np.zeros((MAX_NORMALS, 3)), 0
    for normal in normals[areas[order] > 0.0]:
        if np.abs(found[:count] @ normal).max(initial=0.0) < 0.9998:
            found[count] = normal
            count += 1
            if count == MAX_NORMALS:
                break
    return mesh.vertices, found[:count]
