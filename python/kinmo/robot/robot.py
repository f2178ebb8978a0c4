"""A robot: links with geometry and inertia, and the joints between them. Export formats differ only in how they write it.

The frame of a robot is z-up, in metres. All geometry is given in it, with every joint at its value 0, the pose of the file.
The frame of a link is parallel to it then, with the origin on the axis of the link's joint.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.robot.collision_shapes import CollisionShape

Matrix = NDArray[np.float64]


class RobotJointKind(Enum):
    """Kinds of joints with one degree of freedom. The values are URDF's words."""

    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """A joint with one degree of freedom.

    Attributes:
        name: unique name among all links and joints.
        kind: kind of the joint.
        parent: index of the link that it is attached to.
        child: index of the link that it moves. Its origin is that of the joint.
        axis: [3] unit vector.
        lower: least value, in radians or metres. None for a continuous joint.
        upper: largest value. None for a continuous joint.
        damping: force per speed, in N s/m or N m s/rad.
        friction: force of dry friction, in N or N m.
        effort: largest force of a motor, in N or N m.
        velocity: largest speed, in m/s or rad/s.
    """

    name: str
    kind: RobotJointKind
    parent: int
    child: int
    axis: Vector
    lower: float | None
    upper: float | None
    damping: float
    friction: float
    effort: float
    velocity: float


@dataclass(frozen=True, eq=False)
class Inertial:
    """Mass of a link.

    Attributes:
        mass: mass in kg.
        center: [3] centre of mass.
        inertia: [3, 3] inertia about the centre of mass in kg m2.
    """

    mass: float
    center: Vector
    inertia: Matrix


@dataclass(frozen=True, eq=False)
class Visual:
    """A part of a link, as it looks.

    Attributes:
        name: unique name of the part, an identifier.
        leaf: index of the part in `Shape.parts`.
        mesh: its surface.
    """

    name: str
    leaf: int
    mesh: Mesh


@dataclass(frozen=True, eq=False)
class Collision:
    """A shape that a link collides with.

    Attributes:
        name: unique name, the name of the part with a number.
        leaf: index of the part in `Shape.parts`.
        shape: its geometry.
    """

    name: str
    leaf: int
    shape: CollisionShape


@dataclass(frozen=True, eq=False)
class RobotLink:
    """A rigid link.

    Attributes:
        name: unique name among all links and joints.
        origin: [3] origin of its frame.
        visuals: its parts as they look.
        collisions: its collision geometry.
        inertial: its mass.
    """

    name: str
    origin: Vector
    visuals: tuple[Visual, ...]
    collisions: tuple[Collision, ...]
    inertial: Inertial

    @property
    def geometry(self) -> tuple[Visual | Collision, ...]:
        """All parts as they look, then the collision geometry."""
        return (*self.visuals, *self.collisions)


@dataclass(frozen=True, eq=False)
class Robot:
    """An articulated object. The first link is its fixed base, and every link but that has one joint, in the same order.

    Attributes:
        name: name of the object, an identifier.
        links: the links, the base first, every link after its parent.
        joints: the joint of every link but the base.
        diagonal: diagonal of the object's bounding box.
        gltf_rotation: [3, 3] rotation from the frame of the robot, where z is up, to that of glTF, where y is up.
        notes: a line for each thing about the robot that a user should know.
    """

    name: str
    links: tuple[RobotLink, ...]
    joints: tuple[RobotJoint, ...]
    diagonal: float
    gltf_rotation: NDArray[np.float64]
    notes: tuple[str, ...] = ()

    def links_below(self, link: int) -> list[int]:
        """A link, then all links that move along with it."""
        found = [link]
        for joint in self.joints:  # parents come first
            if joint.parent in found:
                found.append(joint.child)
        return found

    def joint_of(self, link: int) -> RobotJoint | None:
        """The joint that moves a link. None for the base."""
        return None if link == 0 else self.joints[link - 1]
