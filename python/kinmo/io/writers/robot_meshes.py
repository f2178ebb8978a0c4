"""Mesh files of a robot, which several formats share: one OBJ for each part as it looks, and for each hull it collides with.

MuJoCo refuses flat meshes. A flat part is therefore written as two sheets with a small distance.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinmo.core.shape import Mesh, join
from kinmo.io.writers.obj_writer import write_obj
from kinmo.robot.collision_shapes import Hull, Surface
from kinmo.robot.convex_decomposition import box_of
from kinmo.robot.robot import Collision, Robot, Visual

MESHES = "meshes"
"""Folder of the files, beside the file of the robot."""


FLATNESS = 1e-5
"""Largest thickness of a flat part, in diagonals of the object."""
SHEET_DISTANCE = 1e-4
"""Distance of its two sheets, in diagonals of the object."""


def mesh_file(item: Visual | Collision) -> str:
    """Name of the file of a part or a collision shape."""
    return f"{item.name}.obj"


def write_robot_meshes(robot: Robot, folder: Path) -> None:
    """Write all mesh files of a robot into the folder `MESHES` below `folder`, in the frame of the robot."""
    place = folder / MESHES
    place.mkdir(parents=True, exist_ok=True)
    for link in robot.links:
        for visual in link.visuals:
            write_obj(place / mesh_file(visual), solid_enough(visual.mesh, robot.diagonal))
        for collision in link.collisions:
            if (mesh := collision_mesh(collision)) is not None:
                write_obj(place / mesh_file(collision), mesh)


def collision_mesh(collision: Collision) -> Mesh | None:
    """The mesh of a collision shape. None for a box."""
    shape = collision.shape
    return shape.mesh if isinstance(shape, Hull | Surface) else None


def solid_enough(mesh: Mesh, diagonal: float) -> Mesh:
    """The mesh, or two sheets of it if it is flat. `diagonal` is that of the object."""
    _, axes, half_extents = box_of(mesh.corners)
    if 2.0 * half_extents[2] > FLATNESS * diagonal:
        return mesh
    aside = 0.5 * SHEET_DISTANCE * diagonal * axes[2]
    front = np.einsum("fx,x->f", np.cross(*np.moveaxis(np.diff(mesh.triangles, axis=1), 1, 0)), axes[2]).sum() >= 0.0
    above, below = (aside, -aside) if front else (-aside, aside)
    return join(mesh.moved(np.eye(3), above), mesh.moved(np.eye(3), below).flipped)
