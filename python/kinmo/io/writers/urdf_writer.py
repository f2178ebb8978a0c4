"""URDF: z-up, metres, radians.

Every link's frame sits on its joint's axis and has the axes of the robot's frame; at zero all joints are where the file shows
them. A screw is two joints in a row about one axis, a slide and a turn, with a light link between them. A slider without a
limit may go the diagonal of the object either way: URDF knows no unlimited slider.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import roll_pitch_yaw, z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import Link, links_of
from kinmo.core.mobility import Mobility
from kinmo.core.names import unique_names
from kinmo.core.shape import Shape
from kinmo.core.vector import Vector
from kinmo.io.writers.obj_writer import write_obj
from kinmo.io.writers.whole_folder import whole_folder

DENSITY = 100.0
"""kg per m3 of a link's box: furniture is mostly air."""
LEAST_EXTENT = 1e-3
LEAST_MASS = 1e-3
EFFORT = 100.0
"""N or N m."""
VELOCITY = 10.0
"""m/s or rad/s."""
DAMPING = 0.1


def write_urdf(shape: Shape, mobility: Mobility, folder: Path, *, name: str = "model", metres_per_unit: float = 1.0) -> Path:
    """Write `folder`/`name`.urdf and one OBJ a leaf in `folder`/meshes; returns the path of the URDF.

    `mobility` is over the leaves of `shape`, in its frame and lengths, which `metres_per_unit` turns into metres. The meshes
    keep the vertices and faces of the shape, and its frame. The folder is replaced as a whole.
    """
    with whole_folder(folder) as draft:
        (draft / "meshes").mkdir()
        for leaf, file in leaf_files(shape).items():
            mesh = shape.parts[leaf].mesh
            assert mesh is not None, "a leaf carries a mesh: readers make sure of it"
            write_obj(draft / file, mesh)
        write_robot(robot(shape, mobility, metres_per_unit), draft / f"{name}.urdf")
    return folder / f"{name}.urdf"


def write_robot(robot: ET.Element, path: Path) -> None:
    """Write a <robot> element as a file, indented."""
    ET.indent(robot)
    ET.ElementTree(robot).write(path, encoding="utf-8", xml_declaration=True)


def leaf_files(shape: Shape) -> dict[int, str]:
    """The mesh file of every leaf, relative to the URDF."""
    names = unique_names(shape.parts[leaf].name for leaf in shape.leaves)
    return {leaf: f"meshes/{name}.obj" for leaf, name in zip(shape.leaves, names, strict=True)}


def robot(
    shape: Shape,
    mobility: Mobility,
    metres_per_unit: float = 1.0,
    *,
    files: Mapping[int, str] | None = None,
    files_rotation: NDArray[np.float64] | None = None,
) -> ET.Element:
    """The <robot> element of `write_urdf`.

    `files` are the mesh files of the leaves, whose vertices `files_rotation` [3, 3] turns into the robot's frame; if not given,
    they are those of `write_urdf`, in the frame of the shape.
    """
    rotation = z_up_rotation(np.asarray(shape.up, float))
    links = links_of(mobility)
    origins = [link_origin(shape, link, rotation, metres_per_unit) for link in links]
    drawn = _Drawn(files or leaf_files(shape), rotation if files_rotation is None else files_rotation)
    root = ET.Element("robot", name=unique_names([f"{shape.category}_{shape.id}"])[0])
    for link, names, origin in zip(links, _names(links), origins, strict=True):
        root.append(_link_element(shape, link, origin, rotation, metres_per_unit, drawn))
        if link.joint is not None and link.parent is not None:
            offset, parent = origin - origins[link.parent], links[link.parent].name
            root.extend(_joint_elements(link, names, parent, offset, rotation, metres_per_unit, shape.diagonal))
    return root


@dataclass(frozen=True)
class _Names:
    """What is called after a link: its joint, and of a screw the link `between` its two joints and the one that slides."""

    joint: str
    between: str
    slide: str


def _names(links: Sequence[Link]) -> list[_Names]:
    """Names for what belongs to each link, other ones than the links', which stay as they are, and all different."""
    endings = ("", "-joint", "-slide", "-slide-joint")
    names = unique_names(f"{link.name}{ending}" for ending in endings for link in links)
    count = len(links)
    return [_Names(*names[count + place :: count]) for place in range(count)]


@dataclass(frozen=True, eq=False)
class _Drawn:
    """Mesh files by leaf, and the rotation [3, 3] from their frame to the robot's."""

    files: Mapping[int, str]
    rotation: NDArray[np.float64]


def link_origin(shape: Shape, link: Link, rotation: NDArray[np.float64], metres_per_unit: float) -> Vector:
    """Origin [3] of the link's frame in the robot's, metres: on the axis, for a slider in the middle of the link."""
    if link.joint is None:
        return np.zeros(3)
    if link.joint.has_pivot:
        return np.asarray(metres_per_unit * (rotation @ link.joint.pivot))
    low, high = _bounds(shape, link, rotation, metres_per_unit)
    return 0.5 * (low + high)


def _bounds(shape: Shape, link: Link, rotation: NDArray[np.float64], scale: float) -> tuple[Vector, Vector]:
    """Corners of the link's box along the axes of the robot's frame, metres; a point at the origin for an empty link."""
    meshes = [mesh for leaf in link.leaves if (mesh := shape.parts[leaf].mesh) is not None]
    points = np.concatenate([np.zeros((0, 3)), *(mesh.corners for mesh in meshes)])
    if not len(points):
        return np.zeros(3), np.zeros(3)
    placed = scale * points @ rotation.T
    return placed.min(axis=0), placed.max(axis=0)


def _link_element(
    shape: Shape, link: Link, origin: Vector, rotation: NDArray[np.float64], scale: float, drawn: _Drawn
) -> ET.Element:
    element = ET.Element("link", name=link.name)
    low, high = _bounds(shape, link, rotation, scale)
    element.append(_inertial(0.5 * (low + high) - origin, high - low))
    for leaf in link.leaves:
        for role in ("visual", "collision"):
            piece = ET.SubElement(element, role)
            ET.SubElement(piece, "origin", xyz=_numbers(-origin), rpy=_numbers(roll_pitch_yaw(drawn.rotation)))
            ET.SubElement(ET.SubElement(piece, "geometry"), "mesh", filename=drawn.files[leaf], scale=_numbers([scale] * 3))
    return element


def _inertial(center: Vector, extents: Vector) -> ET.Element:
    """Mass and inertia of a solid box."""
    size = np.maximum(extents, LEAST_EXTENT)
    mass = max(DENSITY * float(np.prod(size)), LEAST_MASS)
    moments = mass / 12.0 * (np.sum(size**2) - size**2)
    element = ET.Element("inertial")
    ET.SubElement(element, "origin", xyz=_numbers(center), rpy="0 0 0")
    ET.SubElement(element, "mass", value=_numbers([mass]))
    ixx, iyy, izz = (_numbers([moment]) for moment in moments)
    ET.SubElement(element, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    return element


def _joint_elements(
    link: Link, names: _Names, parent: str, offset: Vector, rotation: NDArray[np.float64], scale: float, diagonal: float
) -> list[ET.Element]:
    """The joint of a link, and for a screw the link between its two joints."""
    joint = link.joint
    assert joint is not None
    axis = rotation @ joint.direction
    if joint.kind is JointKind.REVOLUTE:
        kind = "revolute" if joint.is_limited else "continuous"
        return [_joint_element(names.joint, kind, parent, link.name, offset, axis, _hinge_limits(joint))]
    slide = _slide_limits(joint, scale, diagonal)
    if joint.kind is JointKind.PRISMATIC:
        return [_joint_element(names.joint, "prismatic", parent, link.name, offset, axis, slide)]
    between = ET.Element("link", name=names.between)
    between.append(_inertial(np.zeros(3), np.zeros(3)))
    return [
        between,
        _joint_element(names.slide, "prismatic", parent, names.between, offset, axis, slide),
        _joint_element(names.joint, "continuous", names.between, link.name, np.zeros(3), axis, None),
    ]


def _hinge_limits(joint: Joint) -> tuple[float, float] | None:
    if joint.lower is None or joint.upper is None:
        return None
    return joint.lower - joint.rest, joint.upper - joint.rest


def _slide_limits(joint: Joint, scale: float, diagonal: float) -> tuple[float, float]:
    if joint.lower is None or joint.upper is None:
        return -scale * diagonal, scale * diagonal
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
    ET.SubElement(element, "limit", {**limit, "effort": _numbers([EFFORT]), "velocity": _numbers([VELOCITY])})
    return element


def _numbers(values: Vector | list[float]) -> str:
    """Numbers as URDF text, in full precision and without negative zeros."""
    return " ".join(repr(float(value) + 0.0) for value in values)
