"""Robots of shapes with joints: the one way from kinmo's results to all formats of simulators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import gltf_rotation, z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import links_of
from kinmo.core.mobility import Mobility
from kinmo.core.names import name_or_number, unique_names
from kinmo.core.shape import Mesh, Shape, bounds_of
from kinmo.core.vector import Vector
from kinmo.robot.clearance import with_clearance
from kinmo.robot.collision_geometry import CollisionMode, collision_shapes
from kinmo.robot.inertia import inertial_of
from kinmo.robot.physics import DEFAULT_PHYSICS, Physics, with_resistance
from kinmo.robot.robot import Collision, Robot, RobotJoint, RobotJointKind, RobotLink, Visual
from kinmo.robot.safe_limits import stop_notes, with_safe_limits

MAX_DISTANCE = 1000.0
"""Largest distance of an object from the origin without a note, in diagonals. Single precision then keeps 1e-4 diagonals."""
FAR_NOTE = "the object is far from the origin of its file: move it there, as formats with single precision lose detail"
"""Note about an object that is farther."""


def build_robot(
    shape: Shape,
    mobility: Mobility,
    metres_per_unit: float = 1.0,
    *,
    collision: CollisionMode = "none",
    physics: Physics = DEFAULT_PHYSICS,
) -> Robot:
    """The robot of a shape.

    A screw becomes a prismatic and a continuous joint with one axis and a light link between them. A slider without limits may
    move by the diagonal of the object in both directions. With convex collision geometry, joints stop before parts hit others.

    Args:
        shape: The shape.
        mobility: Its bodies and joints, in the frame of the shape.
        metres_per_unit: Length of a unit of the shape in metres.
        collision: How parts collide.
        physics: Density, and constants of the joints.
    """
    rotation = z_up_rotation(np.asarray(shape.up, float))
    diagonal = metres_per_unit * shape.diagonal
    part_names = (name_or_number(shape.parts[leaf].name, "part", shape.parts[leaf].id) for leaf in shape.leaves)
    names = dict(zip(shape.leaves, unique_names(part_names), strict=True))
    links: list[RobotLink] = []
    joints: list[RobotJoint] = []
    place: dict[int, int] = {}
    for index, link in enumerate(links_of(mobility)):
        meshes = {leaf: _placed(shape.leaf_mesh(leaf), rotation, metres_per_unit) for leaf in link.leaves}
        visuals = tuple(Visual(names[leaf], leaf, mesh) for leaf, mesh in meshes.items())
        origin = _origin(link.joint, list(meshes.values()), rotation, metres_per_unit)
        if link.joint is not None and link.parent is not None:
            parent, axis = place[link.parent], rotation @ link.joint.direction
            for kind, limits in _motions(link.joint, metres_per_unit, diagonal):
                is_last = kind is not RobotJointKind.PRISMATIC or link.joint.kind is JointKind.PRISMATIC
                own = link.joint_name if is_last else link.slide_joint_name
                joints.append(_joint(own, kind, parent, len(links), axis, limits, physics))
                if not is_last:
                    parent = len(links)
                    links.append(RobotLink(link.slide_link, origin, (), (), inertial_of([], center=origin)))
        place[index] = len(links)
        densities = [physics.density_of(shape.parts[leaf].name) for leaf in meshes]
        links.append(RobotLink(link.name, origin, visuals, (), inertial_of(list(meshes.values()), densities, origin)))
    colliding, notes = _with_collisions(links, diagonal, collision)
    if np.linalg.norm(shape.center) > MAX_DISTANCE * shape.diagonal:
        notes = (*notes, FAR_NOTE)
    title = unique_names([f"{shape.category}_{shape.id}"])[0]
    front = None if shape.front is None else np.asarray(shape.front, float)
    to_gltf = gltf_rotation(np.asarray(shape.up, float), front) @ rotation.T
    robot = with_resistance(Robot(title, colliding, tuple(joints), diagonal, to_gltf, notes), physics)
    if collision not in ("convex", "hull"):
        return robot
    safe = with_clearance(with_safe_limits(robot))
    return replace(safe, notes=(*safe.notes, *stop_notes(robot.joints, safe.joints)))


def _placed(mesh: Mesh, rotation: NDArray[np.float64], scale: float) -> Mesh:
    """A mesh in the frame of the robot."""
    return replace(mesh.rotated(rotation), vertices=scale * mesh.vertices @ rotation.T)


def _origin(joint: Joint | None, meshes: Sequence[Mesh], rotation: NDArray[np.float64], scale: float) -> Vector:
    """Origin [3] of a link's frame: a point of its axis, or the middle of the link for a slider."""
    if joint is None:
        return np.zeros(3)
    if joint.has_pivot:
        return np.asarray(scale * (rotation @ joint.pivot))
    low, high = bounds_of(meshes) if meshes else (np.zeros(3), np.zeros(3))
    return 0.5 * (low + high)


def _motions(joint: Joint, scale: float, diagonal: float) -> list[tuple[RobotJointKind, tuple[float, float] | None]]:
    """Kinds of the joints with one degree of freedom that make up a joint, and their limits from the pose of the file."""
    limits = None
    if joint.lower is not None and joint.upper is not None:
        limits = joint.lower - joint.rest, joint.upper - joint.rest
    if joint.kind is JointKind.REVOLUTE:
        return [(RobotJointKind.CONTINUOUS if limits is None else RobotJointKind.REVOLUTE, limits)]
    slide = (-diagonal, diagonal) if limits is None else (scale * limits[0], scale * limits[1])
    sliding = (RobotJointKind.PRISMATIC, slide)
    return [sliding] if joint.kind is JointKind.PRISMATIC else [sliding, (RobotJointKind.CONTINUOUS, None)]


def _joint(
    name: str,
    kind: RobotJointKind,
    parent: int,
    child: int,
    axis: Vector,
    limits: tuple[float, float] | None,
    physics: Physics,
) -> RobotJoint:
    low, high = limits or (None, None)
    return RobotJoint(name, kind, parent, child, axis, low, high, 0.0, 0.0, physics.effort, physics.velocity)


def _with_collisions(
    links: Sequence[RobotLink], diagonal: float, mode: CollisionMode
) -> tuple[tuple[RobotLink, ...], tuple[str, ...]]:
    """Links with collision geometry, named after its part but unlike any part, and notes about it."""
    meshes = [visual.mesh for link in links for visual in link.visuals]
    shapes, notes = collision_shapes(meshes, diagonal, mode)
    parts = [visual.name for link in links for visual in link.visuals]
    own = [f"{part}_collision_{number}" for part, found in zip(parts, shapes, strict=True) for number in range(len(found))]
    names = iter(unique_names([*parts, *own])[len(parts) :])  # both name mesh files
    found = iter(shapes)
    return tuple(
        replace(
            link,
            collisions=tuple(Collision(next(names), visual.leaf, shape) for visual in link.visuals for shape in next(found)),
        )
        for link in links
    ), notes
