"""An object to look at: bodies with their parts in colours, and the ranked joints of each body.

The frame is that of GLB files: y up, in the length unit of the shape. The value of a joint is 0 in the pose of the file.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import gltf_rotation, y_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, Shape, bounds_of
from kinmo.core.vector import Vector
from kinmo.io.writers.glb_writer import glb_bytes
from kinmo.robot.robot import Robot
from kinmo.robot.robot_builder import build_robot
from kinmo.view.body_colors import Color
from kinmo.view.surface_colors import has_varied_looks

OVERHANG = 0.07
"""Length of an axis beyond its body, in diagonals of the object."""
FIRST_SHARE = 0.1
"""Share of their ranges by which joints open to tell where parts open to."""
MIN_AGREEMENT = 0.7
"""Least share of the ways of all parts that lead to the side where they open to."""


@dataclass(frozen=True, eq=False)
class SceneOption:
    """One way in which a body may move.

    Attributes:
        label: short text for people, such as "1. hinge, vertical, left edge 0.82", with the rank first. All of a body differ.
        joint: the joint in the frame of the scene. Its rest value is 0. None for a body that does not move.
        probability: score of the joint. None if nobody stated one.
        rank: rank among the predicted joints, as overrides.toml counts. None for a joint that was not predicted.
        is_by_hand: True if a person corrected it.
    """

    label: str
    joint: Joint | None
    probability: float | None = None
    rank: int | None = None
    is_by_hand: bool = False


@dataclass(frozen=True, eq=False)
class SceneBody:
    """A rigid body.

    Attributes:
        name: its name, for people. Bodies of the same name have their number in it.
        parent: index of the body that it is attached to.
        leaves: indices of its parts in `Shape.parts`.
        color: [3] colour of its parts, in 0..1.
        options: the ranked joints. Empty for a body whose joint nobody estimated.
        chosen: index of the present joint among them.
        key: reference to the body in overrides.toml. None if it cannot be corrected there.
    """

    name: str
    parent: int | None
    leaves: tuple[int, ...]
    color: Color
    options: tuple[SceneOption, ...] = ()
    chosen: int = 0
    key: str | None = None

    @property
    def option(self) -> SceneOption | None:
        """The present joint."""
        return self.options[self.chosen] if self.options else None

    @property
    def joint(self) -> Joint | None:
        """The present joint, or None for a body that does not move."""
        return None if self.option is None else self.option.joint


@dataclass(frozen=True, eq=False)
class ObjectScene:
    """An object with everything that a viewer shows.

    Attributes:
        name: name of the object.
        facts: one line about it.
        shape: the shape, in its own frame.
        bodies: its bodies.
        notes: repairs and guesses of the reader, and consequences of corrections.
    """

    name: str
    facts: str
    shape: Shape
    bodies: tuple[SceneBody, ...]
    notes: tuple[str, ...] = ()

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Rotation [3, 3] from the frame of the shape to that of the scene."""
        return gltf_rotation(np.asarray(self.shape.up, float), self._known_front)

    @property
    def front(self) -> Vector:
        """Unit vector [3] towards the viewer, in the frame of the scene: where the parts open to, or else the shape's front."""
        side = self._opening_side
        if side is not None:
            return side
        return np.asarray(self.rotation @ y_up_rotation(np.asarray(self.shape.up, float), self._known_front)[2])

    @cached_property
    def _opening_side(self) -> Vector | None:
        """Unit vector [3] along x or z, against which few parts open. None if there is none."""
        poses = self.poses(self.opened(FIRST_SHARE))
        ways = np.zeros((0, 3))
        for index, body in enumerate(self.bodies):
            if body.joint is not None and body.joint.is_limited and body.parent is not None and body.leaves:
                center = np.append(np.mean(bounds_of(self.meshes[leaf] for leaf in body.leaves), axis=0), 1.0)
                ways = np.concatenate([ways, [((poses[index] - poses[body.parent]) @ center)[:3]]])
        total = float(np.linalg.norm(ways, axis=1).sum())
        sides = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
        shares = sides @ ways.sum(axis=0)
        return sides[np.argmax(shares)] if total > 0.0 and shares.max() >= MIN_AGREEMENT * total else None

    @property
    def _known_front(self) -> Vector | None:
        return None if self.shape.front is None else np.asarray(self.shape.front, float)

    @property
    def unit(self) -> str:
        """Name of the length unit."""
        return "m" if self.shape.metres_per_unit == 1.0 else "units"

    @cached_property
    def robot(self) -> Robot:
        """The parts as GLB has them, below one link for each group of bodies that move as one."""
        return build_robot(self.shape, self.mobility.rotated(self.rotation.T))

    @cached_property
    def meshes(self) -> dict[int, Mesh]:
        """Meshes of the parts in the frame of the scene, in the pose of the file, by their indices in `Shape.parts`."""
        return {leaf: self.shape.leaf_mesh(leaf).rotated(self.rotation) for body in self.bodies for leaf in body.leaves}

    @cached_property
    def bounds(self) -> tuple[Vector, Vector]:
        """Smallest and largest corner [3] in the pose of the file."""
        return bounds_of(self.meshes.values())

    @property
    def mobility(self) -> Mobility:
        """The bodies with their present joints, in the frame of the scene."""
        return Mobility(
            tuple(
                Body(index, body.name, body.leaves, body.parent, None if body.parent is None else body.joint)
                for index, body in enumerate(self.bodies)
            )
        )

    def poses(self, values: Mapping[int, float]) -> NDArray[np.float64]:
        """Poses [B, 4, 4] of all bodies, as transforms from the pose of the file.

        Args:
            values: Joint values in radians or lengths, by index of the body. A joint without a value stays at 0.
        """
        return forward(self.mobility, values)

    def range_of(self, index: int) -> tuple[float, float]:
        """Smallest and largest value of the joint of a body. A joint without limits gets a turn, or the object's radius."""
        joint = self.bodies[index].joint
        assert joint is not None, "only moving bodies have a range"
        low, high = self.bounds
        largest = math.pi if joint.kind is JointKind.REVOLUTE else 0.5 * float(np.linalg.norm(high - low))
        return (-largest if joint.lower is None else joint.lower), (largest if joint.upper is None else joint.upper)

    def opened(self, share: float) -> dict[int, float]:
        """Values of all joints at a share of the way from the pose of the file to their farther limit.

        Joints without limits make a quarter of a turn, or move by a quarter of the object's size.
        """
        values = {}
        for index, body in enumerate(self.bodies):
            if body.joint is not None and body.parent is not None:
                lower, upper = self.range_of(index)
                lower, upper = (lower, upper) if body.joint.is_limited else (0.0, 0.5 * upper)
                values[index] = share * (upper if abs(upper) >= abs(lower) else lower)
        return values

    def axis_ends(self, index: int) -> NDArray[np.float64]:
        """Begin and end [2, 3] of an arrow that shows the joint of a body, in the pose of the file.

        It runs along the axis over the extent of the body. That of a slider runs through the middle of the body.
        """
        body, (low, high) = self.bodies[index], self.bounds
        joint = body.joint
        assert joint is not None, "only moving bodies have an axis"
        first, last = bounds_of(self.meshes[leaf] for leaf in body.leaves) if body.leaves else (low, high)
        through = joint.pivot if joint.has_pivot else 0.5 * (first + last)
        corners = np.array(list(product(*zip(first, last, strict=True))))
        along = (corners - through) @ joint.direction
        overhang = OVERHANG * float(np.linalg.norm(high - low))
        ends = np.array([along.min() - overhang, along.max() + overhang])
        return np.asarray(through + ends[:, None] * joint.direction)

    def glb(self) -> bytes:
        """The geometry with its looks, as GLB."""
        return glb_bytes(self.robot)

    @cached_property
    def has_looks(self) -> bool:
        """True if the file gives a part a colour or a texture."""
        return any(mesh.look is not None and not mesh.look.is_plain for mesh in self.meshes.values())

    @cached_property
    def has_varied_looks(self) -> bool:
        """True if the file gives the parts an image or more than one colour."""
        return has_varied_looks(self.meshes.values())
