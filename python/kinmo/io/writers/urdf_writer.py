"""URDF: z up, metres, radians.

Mesh files are in the frame of the robot. PyBullet, MuJoCo and ROS find them: MuJoCo takes the last part of their names only,
and the folder from the element `<mujoco>`, which others ignore. It keeps the base a body, too: MuJoCo 2.3 fails where the
world has many shapes, and the link keeps its name. MuJoCo's friction of joints creeps, unless its solver of slip follows.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

from kinmo.core.frames import roll_pitch_yaw
from kinmo.core.oriented_box import Box
from kinmo.core.vector import Vector
from kinmo.io.writers.robot_meshes import (
    MESHES,
    has_different_colors,
    mesh_file,
    shown_material,
    textures_of,
    with_single_materials,
    write_robot_meshes,
)
from kinmo.io.writers.texture_images import TextureImages
from kinmo.io.writers.writer import ExportedObject
from kinmo.io.writers.xml_files import numbers, write_xml
from kinmo.robot.collision_shapes import Cylinder
from kinmo.robot.robot import Collision, Inertial, Robot, RobotJoint, RobotLink, Visual

NOSLIP_ITERATIONS = 100
"""Most steps of MuJoCo's solver of slip. It mostly needs few, but more where joints with friction carry each other."""

MeshPath = Callable[[Visual | Collision], str]
"""The mesh file of a part or collision shape, relative to the URDF."""


def write_urdf(exported: ExportedObject, folder: Path) -> Path:
    """Write a URDF, and OBJ files for it (see `kinmo.io.writers.writer.Writer`)."""
    robot = with_single_materials(exported.robot)
    textures = textures_of(robot, folder, lambda line: exported.note(f"urdf: {line}"))
    write_robot_meshes(robot, folder, textures)
    place = f"package://{exported.options.package}/{MESHES}" if exported.options.package else MESHES
    root = robot_element(
        robot, lambda item: f"{place}/{mesh_file(item)}", material_of=lambda visual: material_element(visual, textures, place)
    )
    if any(has_different_colors(visual.mesh) for link in robot.links for visual in link.visuals):
        exported.note("urdf: the colours of vertices are in the OBJ files alone; the URDF has their mean for each part")
    extension = ET.Element("mujoco")
    ET.SubElement(extension, "compiler", meshdir=MESHES, strippath="true", fusestatic="false")
    if any(joint.friction for joint in robot.joints):
        ET.SubElement(extension, "option", noslip_iterations=str(NOSLIP_ITERATIONS))
    root.insert(0, extension)
    return write_xml(root, folder / f"{exported.options.name}.urdf")


def material_element(visual: Visual, textures: TextureImages, place: str = MESHES) -> ET.Element | None:
    """The `<material>` of a visual with one material at most. None if it has none. `place` is the folder of the images."""
    material = shown_material(visual.mesh)
    if material is None:
        return None
    element = ET.Element("material", name=f"{visual.name}_material")
    ET.SubElement(element, "color", rgba=numbers(material.base_color))
    if material.image is not None and (file := textures.file(material.image)) is not None:
        ET.SubElement(element, "texture", filename=f"{place}/{file}")
    return element


def robot_element(
    robot: Robot,
    path_of: MeshPath,
    files_rpy: Vector | None = None,
    material_of: Callable[[Visual], ET.Element | None] = lambda visual: None,
) -> ET.Element:
    """The `<robot>` element.

    Args:
        robot: The robot.
        path_of: Its mesh files.
        files_rpy: Roll, pitch and yaw [3] from the frame of the files to that of the robot. None if they are in that frame.
        material_of: The element `<material>` of each part, or None.
    """
    root = ET.Element("robot", name=robot.name)
    rpy = "0 0 0" if files_rpy is None else numbers(files_rpy)
    for index, link in enumerate(robot.links):
        root.append(_link(link, path_of, rpy, material_of))
        joint = robot.joint_of(index)
        if joint is not None:
            root.append(_joint(robot, joint))
    return root


def _link(link: RobotLink, path_of: MeshPath, rpy: str, material_of: Callable[[Visual], ET.Element | None]) -> ET.Element:
    element = ET.Element("link", name=link.name)
    element.append(_inertial(link.inertial, link.origin))
    for item in link.geometry:
        piece = ET.SubElement(element, "visual" if isinstance(item, Visual) else "collision", name=item.name)
        if isinstance(item, Collision) and isinstance(item.shape, Box):
            box = item.shape
            turn = numbers(roll_pitch_yaw(box.axes.T))
            ET.SubElement(piece, "origin", xyz=numbers(box.center - link.origin), rpy=turn)
            ET.SubElement(ET.SubElement(piece, "geometry"), "box", size=numbers(2.0 * box.half_extents))
        elif isinstance(item, Collision) and isinstance(item.shape, Cylinder):
            cylinder = item.shape
            turn = numbers(roll_pitch_yaw(cylinder.frame.T))
            ET.SubElement(piece, "origin", xyz=numbers(cylinder.center - link.origin), rpy=turn)
            size = {"radius": numbers([cylinder.radius]), "length": numbers([2.0 * cylinder.half_length])}
            ET.SubElement(ET.SubElement(piece, "geometry"), "cylinder", size)
        else:
            ET.SubElement(piece, "origin", xyz=numbers(-link.origin), rpy=rpy)
            ET.SubElement(ET.SubElement(piece, "geometry"), "mesh", filename=path_of(item))
        if isinstance(item, Visual) and (material := material_of(item)) is not None:
            piece.append(material)
    return element


def _inertial(inertial: Inertial, origin: Vector) -> ET.Element:
    element = ET.Element("inertial")
    ET.SubElement(element, "origin", xyz=numbers(inertial.center - origin), rpy="0 0 0")
    ET.SubElement(element, "mass", value=numbers([inertial.mass]))
    places = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
    ET.SubElement(element, "inertia", {name: numbers([inertial.inertia[place]]) for name, place in places.items()})
    return element


def _joint(robot: Robot, joint: RobotJoint) -> ET.Element:
    parent, child = robot.links[joint.parent], robot.links[joint.child]
    element = ET.Element("joint", name=joint.name, type=joint.kind.value)
    ET.SubElement(element, "origin", xyz=numbers(child.origin - parent.origin), rpy="0 0 0")
    ET.SubElement(element, "parent", link=parent.name)
    ET.SubElement(element, "child", link=child.name)
    ET.SubElement(element, "axis", xyz=numbers(joint.axis))
    ET.SubElement(element, "dynamics", damping=numbers([joint.damping]), friction=numbers([joint.friction]))
    limit = ET.SubElement(element, "limit", effort=numbers([joint.effort]), velocity=numbers([joint.velocity]))
    if joint.lower is not None and joint.upper is not None:
        limit.attrib |= {"lower": numbers([joint.lower]), "upper": numbers([joint.upper])}
    return element
