"""Collision geometry: boxes, cylinders and hulls that together fill a part, or its surface as it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector

SIDES = 24
"""Sides of the prism around a cylinder."""


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder.

    Attributes:
        center: [3].
        axis: [3], of unit length.
        radius: its radius.
        half_length: half of its length along the axis.
    """

    center: Vector
    axis: Vector
    radius: float
    half_length: float

    @property
    def volume(self) -> float:
        return 2.0 * np.pi * self.radius**2 * self.half_length

    @property
    def frame(self) -> NDArray[np.float64]:
        """Rows [3, 3] of a right-handed frame whose third row is the axis."""
        first = np.cross(self.axis, np.eye(3)[np.argmin(np.abs(self.axis))])
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(self.axis, first), self.axis])

    def corners(self) -> NDArray[np.float64]:
        """Corners [2 S, 3] of a prism with `SIDES` sides around the cylinder."""
        turns = 2.0 * np.pi * np.arange(SIDES) / SIDES
        wide = self.radius / np.cos(np.pi / SIDES)
        ring = wide * np.column_stack([np.cos(turns), np.sin(turns)]) @ self.frame[:2]
        along = self.half_length * self.axis
        return np.concatenate([self.center + ring - along, self.center + ring + along])

    def normals(self) -> NDArray[np.float64]:
        """Normals [S / 2 + 1, 3] of the faces of the prism, without opposite ones."""
        turns = 2.0 * np.pi * (np.arange(SIDES // 2) + 0.5) / SIDES
        return np.concatenate([self.axis[None], np.column_stack([np.cos(turns), np.sin(turns)]) @ self.frame[:2]])


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex polyhedron.

    Attributes:
        mesh: its surface. The triangles face outwards.
    """

    mesh: Mesh


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface of any form. Most simulators replace it by its convex hull.

    Attributes:
        mesh: the surface.
    """

    mesh: Mesh


CollisionShape: TypeAlias = Box | Cylinder | Hull | Surface
"""Geometry in the frame of the robot."""
