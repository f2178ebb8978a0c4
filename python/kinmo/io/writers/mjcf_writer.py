"""MJCF, the format of MuJoCo: z up, metres, radians. It loads in MuJoCo 2.3 and all later versions.

Visual geometry is in group 2 and collides with nothing. Collision geometry is in group 3.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from kinmo.core.look import Material
from kinmo.core.names import unique_names
from kinmo.core.oriented_box import Box
from kinmo.io.writers.robot_meshes import (
    MESHES,
    collision_mesh,
    has_different_colors,
    mesh_file,
    shown_material,
    textures_of,
    with_single_materials,
    write_robot_meshes,
)
from kinmo.io.writers.texture_images import PNG, TextureImages
from kinmo.io.writers.writer import ExportedObject
from kinmo.io.writers.xml_files import numbers, write_xml
from kinmo.robot.collision_shapes import Cylinder
from kinmo.robot.robot import Collision, Inertial, Robot, RobotJoint, RobotJointKind, RobotLink

STIFF_LIMIT = (0.004, 1.0)
"""Time constant in seconds and damping of limits (solreflimit). By the default ones, a finger pushes buttons through theirs."""
STIFF = (0.9999, 0.9999, 0.001, 0.5, 2.0)
"""Impedance of the friction of joints (solimpfriction). By the default one, held parts creep by 1 cm a second."""


def write_mjcf(exported: ExportedObject, folder: Path) -> Path:
    """Write an MJCF file, and OBJ files for it (see `kinmo.io.writers.writer.Writer`)."""
    robot = with_single_materials(exported.robot)
    textures = textures_of(robot, folder, lambda line: exported.note(f"mjcf: {line}"))
    write_robot_meshes(robot, folder, textures)
    if any(has_different_colors(visual.mesh) for link in robot.links for visual in link.visuals):
        exported.note("mjcf: each part has the mean colour of its vertices, as MuJoCo knows no vertex colours")
    return write_xml(mjcf_element(robot, textures), folder / f"{exported.options.name}.xml")


def mjcf_element(robot: Robot, textures: TextureImages) -> ET.Element:
    """The `<mujoco>` element of a robot whose visuals have one material at most, with the images that `textures` writes."""
    root = ET.Element("mujoco", model=robot.name)
    compiler = ET.SubElement(root, "compiler", angle="radian", meshdir=MESHES, autolimits="true")
    compiler.attrib |= {"boundmass": "1e-9", "boundinertia": "1e-12", "texturedir": MESHES}
    classes = ET.SubElement(root, "default")
    visual = ET.SubElement(classes, "default", {"class": "visual"})
    ET.SubElement(visual, "geom", type="mesh", contype="0", conaffinity="0", group="2", mass="0")
    collision = ET.SubElement(classes, "default", {"class": "collision"})
    ET.SubElement(collision, "geom", group="3", mass="0")
    assets = ET.SubElement(root, "asset")
    materials = _materials(assets, robot, textures)
    world = ET.SubElement(root, "worldbody")
    bodies: list[ET.Element] = []
    for index, link in enumerate(robot.links):
        joint = robot.joint_of(index)
        above, origin = (world, np.zeros(3)) if joint is None else (bodies[joint.parent], robot.links[joint.parent].origin)
        bodies.append(_body(above, link, joint, link.origin - origin, materials))
        for item in link.geometry:
            if not isinstance(item, Collision) or collision_mesh(item) is not None:
                ET.SubElement(assets, "mesh", name=item.name, file=mesh_file(item))
    return root


def _materials(assets: ET.Element, robot: Robot, textures: TextureImages) -> dict[Material, str]:
    """Add the materials of all visuals, with their textures. Returns their names."""
    shown = (shown_material(visual.mesh) for link in robot.links for visual in link.visuals)
    found = list(dict.fromkeys(material for material in shown if material is not None))
    names = dict(zip(found, unique_names(material.name for material in found), strict=True))
    known: set[str] = set()
    for material, name in names.items():
        shine = 1.0 - material.roughness
        element = ET.SubElement(assets, "material", name=name, rgba=numbers(material.base_color))
        element.attrib |= {"specular": numbers([0.5 * shine]), "shininess": numbers([shine])}
        if any(material.emissive):
            element.attrib["emission"] = numbers([max(material.emissive)])
        file = None if material.image is None else textures.file(material.image, (PNG,))
        if file is not None:
            element.attrib["texture"] = Path(file).stem
            if file not in known:
                known.add(file)
                ET.SubElement(assets, "texture", name=Path(file).stem, type="2d", file=file)
    return names


def _body(
    above: ET.Element, link: RobotLink, joint: RobotJoint | None, offset: np.ndarray, materials: dict[Material, str]
) -> ET.Element:
    body = ET.SubElement(above, "body", name=link.name, pos=numbers(offset))
    _add_inertial(body, link.inertial, link.origin)  # MuJoCo before 3.2 wants a mass of fixed bodies too
    if joint is not None:
        _add_joint(body, joint)
    for visual in link.visuals:
        geom = ET.SubElement(body, "geom", {"class": "visual"}, name=f"{visual.name}_visual", mesh=visual.name)
        geom.attrib["pos"] = numbers(-link.origin)
        if (material := shown_material(visual.mesh)) is not None:
            geom.attrib["material"] = materials[material]
    for collision in link.collisions:
        geom = ET.SubElement(body, "geom", {"class": "collision"}, name=collision.name)
        if isinstance(collision.shape, Box):
            box = collision.shape
            geom.attrib |= {"type": "box", "size": numbers(box.half_extents), "pos": numbers(box.center - link.origin)}
            geom.attrib["xyaxes"] = numbers([*box.axes[0], *box.axes[1]])
        elif isinstance(collision.shape, Cylinder):
            cylinder = collision.shape
            geom.attrib |= {"type": "cylinder", "size": numbers([cylinder.radius, cylinder.half_length])}
            geom.attrib |= {"pos": numbers(cylinder.center - link.origin), "zaxis": numbers(cylinder.axis)}
        else:
            geom.attrib |= {"type": "mesh", "mesh": collision.name, "pos": numbers(-link.origin)}
    return body


def _add_inertial(body: ET.Element, inertial: Inertial, origin: np.ndarray) -> None:
    inertia = inertial.inertia
    entries = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    place = numbers(inertial.center - origin)
    ET.SubElement(body, "inertial", pos=place, mass=numbers([inertial.mass]), fullinertia=numbers(entries))


def _add_joint(body: ET.Element, joint: RobotJoint) -> None:
    kind = "slide" if joint.kind is RobotJointKind.PRISMATIC else "hinge"
    element = ET.SubElement(body, "joint", name=joint.name, type=kind, axis=numbers(joint.axis))
    element.attrib |= {"damping": numbers([joint.damping]), "frictionloss": numbers([joint.friction])}
    if joint.friction:
        element.attrib["solimpfriction"] = numbers(STIFF)
    if joint.lower is not None and joint.upper is not None:
        element.attrib |= {"range": numbers([joint.lower, joint.upper]), "solreflimit": numbers(STIFF_LIMIT)}
