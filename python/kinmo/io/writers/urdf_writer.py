"""URDF: z up, metres, radians.

The frame of every link is on the axis of its joint and parallel to the frame of the robot. At joint value 0 all links are where
the file shows them. A screw becomes two joints with one axis, a prismatic and a continuous one, with a light link between them.
URDF has no prismatic joint without limits: such a joint may move by the diagonal of the object in both directions.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import roll_pitch_yaw, z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import Link, links_of
from kinmo.core.mobility import Mobility
from kinmo.core.names import unique_names
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.core.vector import Vector
from kinmo.io.writers.writer import DEFAULT_OPTIONS, ExportOptions, mobility_of, write_obj

DENSITY = 100.0
"""Density of a link's bounding box in kg/m3. Furniture is mostly hollow."""
MIN_EXTENT = 1e-3  # m
MIN_MASS = 1e-3  # kg
MAX_EFFORT = 100.0  # N or N m
MAX_VELOCITY = 10.0  # m/s or rad/s
DAMPING = 0.1


def write_urdf(shape: Shape, result: ShapeEstimate | Mobility, folder: Path, options: ExportOptions = DEFAULT_OPTIONS) -> Path:
    """Write a URDF and one OBJ per leaf in the subfolder `meshes` (see `kinmo.io.writers.writer.Writer`).

    The meshes have the vertices and faces of the shape, in its own frame. The settings `name` and `metres_per_unit` are used.
    """
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    for leaf, file in leaf_files(shape).items():
        write_obj(folder / file, shape.leaf_mesh(leaf))
    path = folder / f"{options.name}.urdf"
    write_robot(robot_element(shape, mobility_of(result), options.metres_per_unit), path)
    return path


def write_robot(robot: ET.Element, path: Path) -> None:
    """Write a `<robot>` element as an indented file."""
    ET.indent(robot)
    ET.ElementTree(robot).write(path, encoding="utf-8", xml_declaration=True)


def leaf_files(shape: Shape) -> dict[int, str]:
    """The mesh file of each leaf, relative to the URDF."""
    names = unique_names(shape.parts[leaf].name for leaf in shape.leaves)
    return {leaf: f"meshes/{name}.obj" for leaf, name in zip(shape.leaves, names, strict=True)}


def robot_element(
    shape: Shape,
    mobility: Mobility,
    metres_per_unit: float = 1.0,
    *,
    files: Mapping[int, str] | None = None,
    files_rotation: NDArray[np.float64] | None = None,
) -> ET.Element:
    """Build the `<robot>` element.

    `files` are the mesh files of the leaves, by default those of `leaf_files`. `files_rotation` [3, 3] leads from their frame
    to the frame of the robot. By default the files are in the frame of the shape.
    """
    rotation = z_up_rotation(np.asarray(shape.up, float))
    links = links_of(mobility)
    origins = [link_origin(shape, link, rotation, metres_per_unit) for link in links]
    files = files or leaf_files(shape)
    rpy = _numbers(roll_pitch_yaw(rotation if files_rotation is None else files_rotation))
    root = ET.Element("robot", name=unique_names([f"{shape.category}_{shape.id}"])[0])
    for link, names, origin in zip(links, _joint_names(links), origins, strict=True):
        bounds = _bounds(shape, link, rotation, metres_per_unit)
        root.append(_link_element(link, bounds, origin, files, rpy, metres_per_unit))
        if link.joint is not None and link.parent is not None:
            offset, parent = origin - origins[link.parent], links[link.parent].name
            root.extend(_joint_elements(link, names, parent, offset, rotation, metres_per_unit, shape.diagonal))
    return root


def _joint_names(links: Sequence[Link]) -> list[list[str]]:
    """Three names for each link: of its joint, and of the extra link and the prismatic joint that a screw needs.

    They differ from each other and from the names of the links.
    """
    endings = ("", "-joint", "-slide", "-slide-joint")
    names = unique_names(f"{link.name}{ending}" for ending in endings for link in links)
    count = len(links)
    return [names[count + place :: count] for place in range(count)]


def link_origin(shape: Shape, link: Link, rotation: NDArray[np.float64], metres_per_unit: float) -> Vector:
    """Origin [3] of a link's frame: a point of its axis, or the centre of the link for a slider.

    It is in the frame of the robot, in metres. `rotation` [3, 3] leads there from the frame of the shape.
    """
    if link.joint is None:
        return np.zeros(3)
    if link.joint.has_pivot:
        return np.asarray(metres_per_unit * (rotation @ link.joint.pivot))
    low, high = _bounds(shape, link, rotation, metres_per_unit)
    return 0.5 * (low + high)


def _bounds(shape: Shape, link: Link, rotation: NDArray[np.float64], scale: float) -> tuple[Vector, Vector]:
    """Corners of a link's bounding box in the frame of the robot, in metres. Both are zero for an empty link."""
    meshes = [mesh for leaf in link.leaves if (mesh := shape.parts[leaf].mesh) is not None]
    points = np.concatenate([np.zeros((0, 3)), *(mesh.corners for mesh in meshes)])
    if not len(points):
        return np.zeros(3), np.zeros(3)
    placed = scale * points @ rotation.T
    return placed.min(axis=0), placed.max(axis=0)


def _link_element(
    link: Link, bounds: tuple[Vector, Vector], origin: Vector, files: Mapping[int, str], rpy: str, scale: float
) -> ET.Element:
    """A link. `bounds` and `origin` are in the frame of the robot. `rpy` rotates the frame of the files there."""
    element = ET.Element("link", name=link.name)
    low, high = bounds
    element.append(_inertial(0.5 * (low + high) - origin, high - low))
    for leaf in link.leaves:
        for role in ("visual", "collision"):
            piece = ET.SubElement(element, role)
            ET.SubElement(piece, "origin", xyz=_numbers(-origin), rpy=rpy)
            ET.SubElement(ET.SubElement(piece, "geometry"), "mesh", filename=files[leaf], scale=_numbers([scale] * 3))
    return element


def _inertial(center: Vector, extents: Vector) -> ET.Element:
    """Mass and inertia of a solid box."""
    size = np.maximum(extents, MIN_EXTENT)
    mass = max(DENSITY * float(np.prod(size)), MIN_MASS)
    moments = mass / 12.0 * (np.sum(size**2) - size**2)
    element = ET.Element("inertial")
    ET.SubElement(element, "origin", xyz=_numbers(center), rpy="0 0 0")
    ET.SubElement(element, "mass", value=_numbers([mass]))
    ixx, iyy, izz = (_numbers([moment]) for moment in moments)
    ET.SubElement(element, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    return element


def _joint_elements(
    link: Link, names: Sequence[str], parent: str, offset: Vector, rotation: NDArray[np.float64], scale: float, diagonal: float
) -> list[ET.Element]:
    """The joint of a link. For a screw also the extra link and the prismatic joint."""
    joint, (name, slide_link, slide_joint) = link.joint, names
    assert joint is not None
    axis = rotation @ joint.direction
    if joint.kind is JointKind.REVOLUTE:
        kind = "revolute" if joint.is_limited else "continuous"
        return [_joint_element(name, kind, parent, link.name, offset, axis, _limits(joint))]
    slide = _limits(joint, scale) or (-scale * diagonal, scale * diagonal)
    if joint.kind is JointKind.PRISMATIC:
        return [_joint_element(name, "prismatic", parent, link.name, offset, axis, slide)]
    extra_link = ET.Element("link", name=slide_link)
    extra_link.append(_inertial(np.zeros(3), np.zeros(3)))
    return [
        extra_link,
        _joint_element(slide_joint, "prismatic", parent, slide_link, offset, axis, slide),
        _joint_element(name, "continuous", slide_link, link.name, np.zeros(3), axis, None),
    ]


def _limits(joint: Joint, scale: float = 1.0) -> tuple[float, float] | None:
    """Limits from the pose of the file, times `scale`. None without limits."""
    if joint.lower is None or joint.upper is None:
        return None
    return scale * (joint.lower - joint.rest), scale * (joint.upper - joint.rest)


def _joint_element(
    name: str, kind: str, parent: str, child: str, offset: Vector, axis: Vector, limits: tuple[float, float] | None
) -> ET.Element:
    element = ET.Element("joint", name=name, type=kind)
    ET.SubElement(element, "origin", xyz=_numbers(offset), rpy="0 0 0")
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    ET.SubElement(element, "axis", xyz=_numbers(axis))
    ET.SubElement(element, "dynamics", damping=_numbers([DAMPING]))
    limit = {} if limits is None else {"lower": _numbers([limits[0]]), "upper": _numbers([limits[1]])}
    ET.SubElement(element, "limit", {**limit, "effort": _numbers([MAX_EFFORT]), "velocity": _numbers([MAX_VELOCITY])})
    return element


def _numbers(values: Vector | list[float]) -> str:
    """Numbers as URDF text, with all digits and without negative zeros."""
    return " ".join(repr(float(value) + 0.0) for value in values)
