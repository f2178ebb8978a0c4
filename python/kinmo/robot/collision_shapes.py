"""Collision geometry: boxes and hulls that together fill a part, or its surface as it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh


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


CollisionShape: TypeAlias = Box | Hull | Surface
"""Geometry in the frame of the robot."""
