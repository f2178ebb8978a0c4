"""URDF files: links with their geometry, and joints."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.io.readers.urdf_meshes import MAX_NUMBER, NO_TRIANGLES, Triangles, is_file, read_triangles

Matrix = NDArray[np.float64]
"""An array of numbers, or a rigid transform [4, 4]."""


@dataclass(frozen=True, eq=False)
class JointElement:
    """A `<joint>` element between the links `parent` and `child`.

    Attributes:
        type: the type as URDF names it, such as "revolute".
        pose: [4, 4], transform from the child link to the parent link at joint value 0.
        axis: [3], unit vector in the frame of the child link.
        limits: lower and upper limit, in radians or metres. None without limits.
    """

    type: str
    parent: str
    child: str
    pose: Matrix
    axis: Matrix
    limits: tuple[float, float] | None


class LinkPiece(NamedTuple):
    """A visual or collision element: its triangle soup, the transform [4, 4] of that to the link, and its name or ""."""

    triangles: Triangles
    pose: Matrix
    name: str

    def moved(self, link_pose: Matrix) -> Triangles:
        """The triangles in the frame that `link_pose` [4, 4] takes the link to."""
        pose = link_pose @ self.pose
        return np.asarray(self.triangles @ pose[:3, :3].T + pose[:3, 3])


@dataclass(frozen=True, eq=False)
class RobotFile:
    """A tree of links.

    Attributes:
        links: names of the links, the root first and every link after its parent.
        joint_above: the joint of each child link, by name of the link.
        pieces: the geometry of each link.
    """

    links: tuple[str, ...]
    joint_above: dict[str, JointElement]
    pieces: dict[str, list[LinkPiece]]


def read_robot_file(path: Path, packages: Path) -> RobotFile:
    """Read a URDF file with its meshes. Collision shapes are used if no link has visual ones.

    `package://` meshes are searched beside the file and in the folders above it, up to `packages`.
    """
    root = _parse(path)
    elements = {element.get("name") or "": element for element in root.findall("link")}
    if len(elements) < len(root.findall("link")):
        raise InputError(path, "expected links of different names")
    joints = [_joint_element(path, element) for element in root.findall("joint")]
    links = _checked_order(path, list(elements), joints)
    role = "visual" if root.find("link/visual") is not None else "collision"
    pieces = {name: [_piece(path, packages, piece) for piece in element.findall(role)] for name, element in elements.items()}
    return RobotFile(links, {joint.child: joint for joint in joints}, pieces)


def _parse(path: Path) -> ET.Element:
    data = path.read_bytes()
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise InputError(path, "expected a URDF without document type or entities")
    try:
        return ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise InputError(path, f"expected XML: {error}") from error


def _numbers(
    path: Path, element: ET.Element | None, field: str, default: tuple[float, ...], largest: float = MAX_NUMBER
) -> Matrix:
    text = None if element is None else element.get(field)
    if text is None:
        return np.array(default)
    try:
        values = np.array(text.split(), float)
    except ValueError:
        values = np.array([np.nan])
    if len(values) != len(default) or not np.all(np.abs(values) <= largest):
        raise InputError(path, f"expected {len(default)} finite numbers, of at most {largest:g}, found {text[:40]!r}", field)
    return values


def _pose(path: Path, element: ET.Element | None) -> Matrix:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", _numbers(path, element, "rpy", (0.0, 0.0, 0.0))).as_matrix()
    pose[:3, 3] = _numbers(path, element, "xyz", (0.0, 0.0, 0.0))
    return pose


def _joint_element(path: Path, element: ET.Element) -> JointElement:
    kind = (element.get("type") or "").strip().lower()
    ends = [end.get("link") if (end := element.find(role)) is not None else None for role in ("parent", "child")]
    if ends[0] is None or ends[1] is None:
        raise InputError(path, "expected a parent and a child link", f"joint {element.get('name')}")
    axis = _numbers(path, element.find("axis"), "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length < 1.0 / MAX_NUMBER:
        raise InputError(path, "expected an axis that is not zero", f"joint {element.get('name')}")
    limits = _limits(path, element.find("limit"))
    pose = _pose(path, element.find("origin"))
    return JointElement(kind, ends[0], ends[1], pose, axis / length, None if kind == "continuous" else limits)


def _limits(path: Path, element: ET.Element | None) -> tuple[float, float] | None:
    """The limits in ascending order. None for an empty range, and for the largest floats, which mean no limit in some files."""
    ends = (float(_numbers(path, element, field, (0.0,), sys.float_info.max)[0]) for field in ("lower", "upper"))
    lower, upper = sorted(ends)
    return (lower, upper) if -MAX_NUMBER <= lower < upper <= MAX_NUMBER else None


def _checked_order(path: Path, names: list[str], joints: list[JointElement]) -> tuple[str, ...]:
    """Names of the links, each after its parent. Raises InputError unless they form one tree."""
    if not names:
        raise InputError(path, "expected at least one link")
    children: dict[str, list[str]] = {name: [] for name in names}
    seen: set[str] = set()
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in children:
                raise InputError(path, f"expected a link of the name {end!r}", "joint")
        if joint.child in seen:
            raise InputError(path, f"expected one joint above link {joint.child!r}", "joint")
        seen.add(joint.child)
        children[joint.parent].append(joint.child)
    roots = [name for name in names if name not in seen]
    if len(roots) != 1:
        raise InputError(path, f"expected one root link, found {len(roots)}")
    order = [roots[0]]
    for name in order:
        order += children[name]
    if len(order) < len(names):
        raise InputError(path, "expected a tree, found a cycle of joints")
    return tuple(order)


def _piece(path: Path, packages: Path, element: ET.Element) -> LinkPiece:
    """A visual or collision element."""
    shape = next(iter(element.findall("geometry/*")), None)
    triangles = NO_TRIANGLES if shape is None else _triangles(path, packages, shape)
    return LinkPiece(triangles, _pose(path, element.find("origin")), element.get("name") or "")


def _triangles(path: Path, packages: Path, shape: ET.Element) -> Triangles:
    """Triangles of a geometry in its own frame."""
    if shape.tag == "mesh":
        file = _mesh_path(shape.get("filename") or "", path, packages)
        return read_triangles(file) * _numbers(path, shape, "scale", (1.0, 1.0, 1.0))
    if shape.tag == "box":
        mesh = trimesh.creation.box(_numbers(path, shape, "size", (1.0, 1.0, 1.0)))
    elif shape.tag in ("cylinder", "capsule"):
        radius, length = (float(_numbers(path, shape, field, (1.0,))[0]) for field in ("radius", "length"))
        is_capsule = shape.tag == "capsule"
        mesh = trimesh.creation.capsule(length, radius) if is_capsule else trimesh.creation.cylinder(radius, length)
    elif shape.tag == "sphere":
        mesh = trimesh.creation.icosphere()
        mesh.apply_scale(float(_numbers(path, shape, "radius", (1.0,))[0]))  # trimesh has no sphere of radius 0
    else:
        raise InputError(path, f"expected mesh, box, cylinder or sphere, found {shape.tag[:40]!r}", "geometry")
    return np.asarray(mesh.triangles, float)


def _mesh_path(name: str, urdf: Path, packages: Path) -> Path:
    """The file of a mesh."""
    if not name.startswith("package://"):
        return urdf.parent / name.removeprefix("file://")
    inside = name.removeprefix("package://")
    folders = [folder for folder in urdf.parents if folder == urdf.parent or folder == packages or packages in folder.parents]
    places = [folder / tail for folder in folders for tail in (inside, inside.partition("/")[2])]
    return next((place for place in places if is_file(place)), places[0])
