"""Mesh files of a robot, which several formats share: one OBJ for each part as it looks, and for each hull it collides with.

Simulators show one material per mesh: a part with several materials becomes several visuals. MuJoCo refuses flat meshes. A flat
part is therefore written as two sheets with a small distance.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from kinmo.core.look import Material
from kinmo.core.names import unique_names
from kinmo.core.shape import Mesh, join
from kinmo.io.writers.obj_writer import write_obj
from kinmo.io.writers.texture_images import Note, TextureImages, materials_of
from kinmo.robot.collision_shapes import Hull, Surface
from kinmo.robot.convex_hulls import box_of
from kinmo.robot.robot import Collision, Robot, RobotLink, Visual

MESHES = "meshes"
"""Folder of the files, beside the file of the robot."""
FLATNESS = 1e-5
"""Largest thickness of a flat part, in diagonals of the object."""
SHEET_DISTANCE = 1e-4
"""Distance of its two sheets, in diagonals of the object."""


def mesh_file(item: Visual | Collision) -> str:
    """Name of the file of a part or a collision shape."""
    return f"{item.name}.obj"


def with_single_materials(robot: Robot) -> Robot:
    """The robot with one visual for each material of a part, named after the part and the material."""
    pieces: list[tuple[int, str, Visual]] = []
    for index, link in enumerate(robot.links):
        for visual in link.visuals:
            groups = [] if visual.mesh.look is None else visual.mesh.look.used()
            for material, faces in groups if len(groups) > 1 else []:
                name = f"{visual.name}_{'plain' if material is None else material.name}"
                pieces.append((index, name, replace(visual, mesh=visual.mesh.part(faces))))
            if len(groups) <= 1:
                pieces.append((index, visual.name, visual))
    if len(pieces) == sum(len(link.visuals) for link in robot.links):
        return robot
    taken = [visual.name for link in robot.links for visual in link.visuals]
    taken += [collision.name for link in robot.links for collision in link.collisions]
    names = iter(unique_names([*taken, *(name for _, name, visual in pieces if name != visual.name)])[len(taken) :])
    visuals: list[list[Visual]] = [[] for _ in robot.links]
    for index, name, visual in pieces:
        visuals[index].append(visual if name == visual.name else replace(visual, name=next(names)))
    links: list[RobotLink] = [replace(link, visuals=tuple(own)) for link, own in zip(robot.links, visuals, strict=True)]
    return replace(robot, links=tuple(links))


def shown_material(mesh: Mesh) -> Material | None:
    """The material of a mesh that has one at most, with the mean of its vertex colours as part of the base colour."""
    if mesh.look is None:
        return None
    material, colors = next(iter(mesh.look.materials), None), mesh.look.colors
    if colors is None or not np.any(colors != 1.0):  # white changes nothing
        return material
    weights = mesh.face_areas if mesh.face_areas.sum() > 0.0 else np.ones(len(mesh.faces))
    mean = np.average(colors.astype(np.float64).mean(axis=1), axis=0, weights=weights)
    plain = material or Material("vertex_colors")
    red, green, blue, opacity = np.round(mean * plain.base_color, 6).tolist()
    return replace(plain, base_color=(red, green, blue, opacity))


def has_different_colors(mesh: Mesh) -> bool:
    """True if the vertex colours of a mesh differ from each other."""
    colors = None if mesh.look is None else mesh.look.colors
    return colors is not None and bool(np.any(colors != colors[:1, :1]))


def textures_of(robot: Robot, folder: Path, note: Note) -> TextureImages:
    """The image files of a robot, in the folder `MESHES` below `folder`."""
    return TextureImages(folder / MESHES, materials_of(visual.mesh for link in robot.links for visual in link.visuals), note)


def write_robot_meshes(robot: Robot, folder: Path, textures: TextureImages) -> None:
    """Write all mesh files of a robot into the folder `MESHES` below `folder`, in the frame of the robot."""
    place = folder / MESHES
    place.mkdir(parents=True, exist_ok=True)
    for link in robot.links:
        for visual in link.visuals:
            write_obj(place / mesh_file(visual), solid_enough(visual.mesh, robot.diagonal), textures)
        for collision in link.collisions:
            if (mesh := collision_mesh(collision)) is not None:
                write_obj(place / mesh_file(collision), mesh)


def collision_mesh(collision: Collision) -> Mesh | None:
    """The mesh of a collision shape. None for a box or a cylinder."""
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
