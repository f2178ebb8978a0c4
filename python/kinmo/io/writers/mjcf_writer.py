"""MJCF, the format of MuJoCo: z up, metres, radians. It loads in MuJoCo 2.3 and all later versions.

Visual geometry is in group 2 and collides with nothing. Collision geometry is in group 3.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from kinmo.core.oriented_box import Box
from kinmo.io.writers.robot_meshes import MESHES, mesh_file, write_robot_meshes
from kinmo.io.writers.writer import ExportedObject
from kinmo.io.writers.xml_files import numbers, write_xml
from kinmo.robot.robot import Collision, Inertial, Robot, RobotJoint, RobotJointKind, RobotLink

QUATERNION_ORDER = [3, 0, 1, 2]
"""MuJoCo writes the real part of a quaternion first."""


def write_mjcf(exported: ExportedObject, folder: Path) -> Path:
    """Write an MJCF file, and OBJ files for it (see `kinmo.io.writers.writer.Writer`)."""
    write_robot_meshes(exported.robot, folder)
    return write_xml(mjcf_element(exported.robot), folder / f"{exported.options.name}.xml")


def mjcf_element(robot: Robot) -> ET.Element:
    """The `<mujoco>` element of a robot."""
    root = ET.Element("mujoco", model=robot.name)
    ET.SubElement(root, "compiler", angle="radian", meshdir=MESHES, autolimits="true", boundmass="1e-9", boundinertia="1e-12")
    classes = ET.SubElement(root, "default")
    visual = ET.SubElement(classes, "default", {"class": "visual"})
    ET.SubElement(visual, "geom", type="mesh", contype="0", conaffinity="0", group="2", mass="0")
    collision = ET.SubElement(classes, "default", {"class": "collision"})
    ET.SubElement(collision, "geom", group="3", mass="0")
    assets = ET.SubElement(root, "asset")
    world = ET.SubElement(root, "worldbody")
    bodies: list[ET.Element] = []
    for index, link in enumerate(robot.links):
        joint = robot.joint_of(index)
        above, origin = (world, np.zeros(3)) if joint is None else (bodies[joint.parent], robot.links[joint.parent].origin)
        bodies.append(_body(above, link, joint, link.origin - origin))
        for item in (*link.visuals, *link.collisions):
            if not (isinstance(item, Collision) and isinstance(item.shape, Box)):
                ET.SubElement(assets, "mesh", name=item.name, file=mesh_file(item))
    return root


def _body(above: ET.Element, link: RobotLink, joint: RobotJoint | None, offset: np.ndarray) -> ET.Element:
    body = ET.SubElement(above, "body", name=link.name, pos=numbers(offset))
    _add_inertial(body, link.inertial, link.origin)  # MuJoCo before 3.2 wants a mass of fixed bodies too
    if joint is not None:
        _add_joint(body, joint)
    for visual in link.visuals:
        ET.SubElement(body, "geom", {"class": "visual"}, name=f"{visual.name}_visual", mesh=visual.name, pos=numbers(-link.origin))
    for collision in link.collisions:
        geom = ET.SubElement(body, "geom", {"class": "collision"}, name=collision.name)
        if isinstance(collision.shape, Box):
            box = collision.shape
            geom.attrib |= {"type": "box", "size": numbers(box.half_extents), "pos": numbers(box.center - link.origin)}
            geom.attrib["xyaxes"] = numbers([*box.axes[0], *box.axes[1]])
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
    if joint.lower is not None and joint.upper is not None:
        element.attrib["range"] = numbers([joint.lower, joint.upper])
