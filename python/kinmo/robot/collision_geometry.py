"""Collision geometry of robots, by the mode that a user chooses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from kinmo.core.shape import Mesh
from kinmo.core.wording import counted
from kinmo.robot.coacd_pieces import is_installed
from kinmo.robot.collision_shapes import CollisionShape, Surface
from kinmo.robot.convex_decomposition import convex_shapes, hull_shape

CollisionMode = Literal["convex", "hull", "mesh", "none"]
"""A way in which parts collide: as convex pieces, as the convex hull of each part, as their surfaces, or not at all."""

COLLISION_MODES: tuple[CollisionMode, ...] = get_args(CollisionMode)
"""All modes."""
DEFAULT_MODE: CollisionMode = "convex"
MESH_NOTE = "most simulators take the convex hull of each surface, so that links may overlap: use --collision convex for those"
"""Note for users of the mode "mesh"."""


def collision_shapes(
    meshes: Sequence[Mesh], diagonal: float, mode: CollisionMode
) -> tuple[list[list[CollisionShape]], tuple[str, ...]]:
    """Collision shapes of parts.

    Args:
        meshes: The surfaces of the parts, in the frame of the robot.
        diagonal: Diagonal of the object.
        mode: The mode.

    Returns:
        The shapes of each part, and a line for each thing that a user should know.
    """
    if mode == "convex":
        shapes, undivided = convex_shapes(meshes, diagonal)
        return shapes, () if not undivided else (_undivided(undivided),)
    if mode == "hull":
        return [[hull_shape(mesh, diagonal)] for mesh in meshes], ()
    if mode == "mesh":
        return [[Surface(mesh)] for mesh in meshes], (MESH_NOTE,)
    return [[] for _ in meshes], ()


def _undivided(count: int) -> str:
    what = f"{counted(count, 'concave piece')} coarsely bisected for collisions"
    return what if is_installed() else f"{what}: CoACD divides better, pip install 'kinmo[sim]'"
