"""Clearance between the links of a robot: collision shapes are cut back where they overlap at rest or on their way.

Predicted axes are off by a little, and real parts touch at hinges and stops. A simulator pushes overlapping shapes apart, and
the object moves by itself or jams. So shapes that nearly touch are cut by planes until a small gap is between them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.kinematics import Pose
from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.robot.collision_shapes import CollisionShape, Hull
from kinmo.robot.convex_decomposition import hull_of, simplest_shape
from kinmo.robot.robot import Collision, Robot, RobotJoint, RobotJointKind

F64 = NDArray[np.float64]

GAP = 0.001
"""Least gap between two links, in diagonals of the object."""
MAX_CUT_AT_REST = 0.4
"""Largest share of a shape's extent that is cut off for the pose of the file. Otherwise the smaller shape is dropped."""
MAX_CUT_ON_THE_WAY = 0.25
"""Largest share of a shape's extent that is cut off for another joint value. Otherwise the shapes are left as they are."""
STEPS = 12
"""Joint values from the pose of the file to each limit that are looked at."""
FULL_TURN = (-np.pi, np.pi)
"""Range of a continuous joint."""
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
    """

    link: int
    collision: Collision
    shape: CollisionShape | None
    points: F64
    normals: F64

    @classmethod
    def of(cls, link: int, collision: Collision) -> _Piece:
        return cls(link, collision, collision.shape, *_points_and_normals(collision.shape))

    @property
    def size(self) -> float:
        """Volume of its axis-aligned bounding box."""
        return float(np.prod(np.ptp(self.points, axis=0)))

    def cut(self, normal: Vector, level: float) -> None:
        """Keep what is at or above `level` along a unit vector."""
        heights = self.points @ normal - level
        above, below = self.points[heights >= 0.0], self.points[heights < 0.0]
        if not len(above):
            self.shape = None
            return
        high, low = heights[heights >= 0.0], -heights[heights < 0.0]
        share = (low[None, :] / np.maximum(high[:, None] + low[None, :], 1e-300))[..., None]
        between = (share * above[:, None] + (1.0 - share) * below[None, :]).reshape(-1, 3)
        points = np.concatenate([above, between])
        shape = simplest_shape(hull_of(points, 1e-4 * float(np.ptp(points, axis=0).max())))
        self.shape = shape
        self.points, self.normals = _points_and_normals(shape)


def with_clearance(robot: Robot) -> Robot:
    """The robot with collision shapes that keep a gap of `GAP`, at rest and where each joint moves alone.

    Shapes of links that are welded together do not count, nor do surfaces that are not convex.
    """
    pieces = [
        _Piece.of(index, collision)
        for index, link in enumerate(robot.links)
        for collision in link.collisions
        if isinstance(collision.shape, Box | Hull)
    ]
    gap = GAP * robot.diagonal
    below = [_below(robot, index) for index in range(len(robot.links))]
    for joint in robot.joints:
        moving = [piece for piece in pieces if piece.link in below[joint.child]]
        others = [piece for piece in pieces if piece.link not in below[joint.child]]
        _clear(moving, others, np.eye(4), gap, MAX_CUT_AT_REST, drops=True)
        for pose in _way(joint, robot.links[joint.child].origin):
            _clear(moving, others, pose, gap, MAX_CUT_ON_THE_WAY, drops=False)
    kept: dict[int, list[Collision]] = {index: [] for index in range(len(robot.links))}
    for piece in pieces:
        if piece.shape is not None:
            kept[piece.link].append(replace(piece.collision, shape=piece.shape))
    links = []
    for index, link in enumerate(robot.links):
        surfaces = [each for each in link.collisions if not isinstance(each.shape, Box | Hull)]
        links.append(replace(link, collisions=(*kept[index], *surfaces)))
    return replace(robot, links=tuple(links))


def _below(robot: Robot, link: int) -> set[int]:
    """A link and all links that move along with it."""
    found = {link}
    for joint in robot.joints:  # parents come first
        if joint.parent in found:
            found.add(joint.child)
    return found


def _way(joint: RobotJoint, origin: Vector) -> Iterator[Pose]:
    """Motions [4, 4] of a joint's child at values from 0 outwards to both limits."""
    low, high = (joint.lower, joint.upper) if joint.lower is not None and joint.upper is not None else FULL_TURN
    for end in (low, high):
        for value in np.linspace(0.0, end, STEPS + 1)[1:] if abs(end) > 1e-9 else ():
            pose = np.eye(4)
            if joint.kind is RobotJointKind.PRISMATIC:
                pose[:3, 3] = value * joint.axis
            else:
                pose[:3, :3] = Rotation.from_rotvec(value * joint.axis).as_matrix()
                pose[:3, 3] = origin - pose[:3, :3] @ origin
            yield pose


def _clear(moving: Sequence[_Piece], others: Sequence[_Piece], pose: Pose, gap: float, most: float, *, drops: bool) -> None:
    """Cut shapes of two groups where they are nearer than `gap`, with the first group moved by `pose`."""
    turn, shift = pose[:3, :3], pose[:3, 3]
    for piece, other in _near_pairs(moving, others, pose, gap):
        if piece.shape is None or other.shape is None:
            continue
        normals = np.concatenate([piece.normals @ turn.T, other.normals])
        here, there = (piece.points @ turn.T + shift) @ normals.T, other.points @ normals.T
        front, back = here.min(axis=0) - there.max(axis=0), there.min(axis=0) - here.max(axis=0)
        if max(front.max(), back.max()) >= gap:
            continue
        needs = np.concatenate([gap - front, gap - back])
        extents = np.stack([np.tile(np.ptp(values, axis=0), 2) for values in (here, there)])
        shares = needs / np.maximum(extents, 1e-12)
        which, way = np.unravel_index(int(np.argmin(shares)), shares.shape)
        away = normals[way % len(normals)] * (1.0 if way < len(normals) else -1.0)  # from the other to the moving one
        if shares[which, way] <= most:
            cut, inward = (piece, turn.T @ away) if which == 0 else (other, -away)
            cut.cut(inward, float((cut.points @ inward).min() + needs[way]))
        elif drops:
            (piece if piece.size <= other.size else other).shape = None


def _near_pairs(
    moving: Sequence[_Piece], others: Sequence[_Piece], pose: Pose, gap: float
) -> Iterator[tuple[_Piece, _Piece]]:
    """Pairs of shapes whose axis-aligned bounding boxes are nearer than `gap`, with the first group moved by `pose`."""
    if not moving or not others:
        return
    here = [piece.points @ pose[:3, :3].T + pose[:3, 3] for piece in moving]
    (low, high), (least, most) = (
        (np.array([points.min(axis=0) for points in group]), np.array([points.max(axis=0) for points in group]))
        for group in (here, [other.points for other in others])
    )
    near = np.all((low[:, None] - gap <= most) & (high[:, None] + gap >= least), axis=2)
    for row, column in np.argwhere(near):
        yield moving[row], others[column]


def _points_and_normals(shape: CollisionShape) -> tuple[F64, F64]:
    """Corners [V, 3] and normals [K, 3] of the faces of a convex shape, at most `MAX_NORMALS`."""
    if isinstance(shape, Box):
        return shape.corners(), shape.axes
    mesh: Mesh = shape.mesh
    a, b, c = np.moveaxis(mesh.triangles, 1, 0)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    order = np.argsort(-areas, kind="stable")
    normals = normals[order] / np.maximum(areas[order, None], 1e-300)
    found: list[Vector] = []
    for normal in normals[areas[order] > 0.0]:
        if all(abs(float(normal @ known)) < 0.9998 for known in found):
            found.append(normal)
            if len(found) == MAX_NORMALS:
                break
    return mesh.vertices, np.array(found).reshape(-1, 3)
