"""Collision geometry of robots, by the mode that a user chooses."""

from __future__ import annotations

from typing import Literal, get_args

from kinmo.core.shape import Mesh
from kinmo.robot.collision_shapes import CollisionShape, Surface
from kinmo.robot.convex_decomposition import convex_shapes, hull_shape

CollisionMode = Literal["convex", "hull", "mesh", "none"]
"""How parts collide: as convex pieces, as the convex hull of each part, as their surfaces, or not at all."""

COLLISION_MODES: tuple[CollisionMode, ...] = get_args(CollisionMode)
"""All modes."""
DEFAULT_MODE: CollisionMode = "convex"


def collision_shapes(mesh: Mesh, diagonal: float, mode: CollisionMode) -> list[CollisionShape]:
    """Collision shapes of a part.

    Args:
        mesh: The surface of the part, in the frame of the robot.
        diagonal: Diagonal of the object.
        mode: The mode.
    """
    if mode == "convex":
        return convex_shapes(mesh, diagonal)
    if mode == "hull":
        return [hull_shape(mesh, diagonal)]
    return [Surface(mesh)] if mode == "mesh" else []
