"""URDF: the links are the parts, and their joints are the annotation."""

from __future__ import annotations

import re
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers import solids
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.obj_reader import material_files
from kinmo.io.readers.reader import Reader, SourceFiles
from kinmo.io.readers.robot_file import FIXED, MAX_NUMBER, JointElement, Matrix, RobotFile, RobotPiece, about, ordered_links
from kinmo.io.readers.robot_meshes import RobotMeshes, mesh_path, missing_mesh, refuse, with_their_files
from kinmo.io.readers.robot_numbers import read_numbers
from kinmo.io.readers.robot_shape import robot_files, robot_id, shape_of_robot
from kinmo.io.readers.scene import ignored, placed
from kinmo.io.readers.untrusted_files import plain_path, read_bytes, those_inside
from kinmo.io.readers.urdf_materials import UrdfMaterials
from kinmo.io.readers.xml_files import MAX_XML_BYTES, parse_xml

URDF = "urdf"
_ENDING = ".urdf"
_PACKAGE_FILE = "package.xml"
"""File by which a package of ROS is recognised."""
_PACKAGE = re.compile(rb"""["'](?:package|model)://([^/"']+)/""")
"""Name of a package of ROS, or of a model of Gazebo, in the path of a file."""
_READ_ELEMENTS = (
    "link", "joint", "parent", "child", "origin", "axis", "limit", "mesh", "box", "cylinder", "capsule", "sphere", "color"
)  # fmt: skip
"""Elements whose attributes count."""
_ROUND = {"radius": 1, "length": 1}
_SIZES = {"box": {"size": 3}, "cylinder": _ROUND, "capsule": _ROUND, "sphere": {"radius": 1}}
"""Attributes that give the size of each solid, and how many numbers they have."""


def read_urdf(path: Path) -> Shape:
    """Read a URDF file as a shape (see `shape_of_robot`). Meshes that cannot be read are skipped with a note."""
    path = Path(path)
    problems: list[InputError] = []
    unread: Counter[str] = Counter()
    materials = MtlMaterials(_home(path), lambda what: unread.update([what]))
    robot = read_robot_file(path, _home(path), problems.append, materials)
    shape = shape_of_robot(robot, URDF, "URDF", problems)
    return replace(shape, repairs=(*shape.repairs, *ignored(unread)))


def read_robot_file(
    path: Path, home: Path, report: Callable[[InputError], None] = refuse, materials: MtlMaterials | None = None
) -> RobotFile:
    """Read a URDF file with its meshes. Collision shapes are used if no link has visual ones.

    Meshes in a `package://` or `model://` are searched beside the file and in the folders above it, up to `home`.

    Args:
        path: the file.
        home: a folder at or above that of the file. No path of a mesh may lead out of it.
        report: receives the problem of each mesh that cannot be read. By default it is raised.
        materials: reads MTL files and images, and receives what is not read. None to read shapes alone.

    Raises:
        InputError: the file is no URDF, its links form no tree, or a path leads out of `home`.
    """
    root = parse_xml(read_bytes(path, path.parent, MAX_XML_BYTES), path)
    _check_no_template(path, root)
    elements = _named_links(path, root)
    joints = [_joint_element(path, element) for element in root.findall("joint")]
    links = ordered_links(path, list(elements), joints)
    role = "visual" if root.find("link/visual") is not None else "collision"
    meshes = RobotMeshes(path, home, report, materials)
    looks = None if materials is None else UrdfMaterials(path, root, home, materials)
    repairs: list[str] = []
    pieces: dict[str, list[RobotPiece]] = {}
    for name, element in elements.items():
        title = f"link {clean_text(name)}"
        with about(path, title):
            found = [_piece(path, meshes, each, looks, title, repairs) for each in element.findall(role)]
        pieces[name] = [piece for piece in found if piece is not None]
    above = {joint.child: joint for joint in joints}
    title = clean_text(root.get("name") or "")
    return RobotFile(path, title, links, above, pieces, tuple(_mesh_files(path, root, home)), tuple(repairs))


def _mesh_files(path: Path, root: ET.Element, home: Path) -> list[Path]:
    """The mesh files that the element `<robot>` of a file names, each once."""
    names = (mesh.get("filename") for mesh in root.findall("link/*/geometry/mesh"))
    return list(dict.fromkeys(mesh_path(name, path, home) for name in names if name))


def _named_links(path: Path, root: ET.Element) -> dict[str, ET.Element]:
    """The elements `<link>` by name. Raises InputError for those without a name, and for two of one name."""
    elements: dict[str, ET.Element] = {}
    for number, element in enumerate(root.findall("link"), start=1):
        name = element.get("name") or ""
        if not name:
            raise InputError(path, "expected a name", f"link {number}")
        if name in elements:
            raise InputError(path, f"expected links of different names, found {name} twice", f"link {number}")
        elements[name] = element
    return elements


def _check_no_template(path: Path, root: ET.Element) -> None:
    """Raise InputError for a template of xacro, from which ROS makes a URDF file."""
    for element in root.iter():
        space, _, name = element.tag.rpartition("}")
        found = f"xacro:{name}" if "xacro" in space else None
        if element.tag in _READ_ELEMENTS:
            found = next((text for text in element.attrib.values() if "${" in text or "$(" in text), found)
        if found is not None:
            remedy = f"run `xacro {path.name} > robot.urdf`, and use its output"
            raise InputError(path, f"is a template, found {clean_text(found)}: {remedy}")


def _home(path: Path) -> Path:
    """The folder of a file, or that of the package of ROS around it.

    A package is a folder with package.xml, or the nearest one with the name of a package in the file.
    """
    folder = plain_path(path).parent
    above = (folder, *folder.parents)
    homes = [folder, *(each for each in above if (each / _PACKAGE_FILE).is_file())][:2]
    data = read_bytes(path, path.parent, MAX_XML_BYTES)
    for name in {match.decode("utf-8", "replace") for match in _PACKAGE.findall(data)}:
        homes += [each for each in above if each.name == name and not _is_private(each)][:1]
    return min(homes, key=lambda home: len(home.parts))


def _is_private(folder: Path) -> bool:
    """True for the home folder of the user and what is above it. They are no package, and a file must not open them."""
    try:
        return Path.home().is_relative_to(folder)
    except RuntimeError:  # the user has none
        return False


def _pose(path: Path, element: ET.Element | None) -> Matrix:
    attributes = {} if element is None else element.attrib
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", read_numbers(path, attributes, "rpy", (0.0, 0.0, 0.0))).as_matrix()
    pose[:3, 3] = read_numbers(path, attributes, "xyz", (0.0, 0.0, 0.0))
    return pose


def _joint_element(path: Path, element: ET.Element) -> JointElement:
    kind = (element.get("type") or "").strip().lower()
    name = clean_text(element.get("name") or "")
    with about(path, f"joint {name}".strip()):
        return _joint(path, element, kind, name)


def _joint(path: Path, element: ET.Element, kind: str, name: str) -> JointElement:
    ends = [end.get("link") if (end := element.find(role)) is not None else None for role in ("parent", "child")]
    if ends[0] is None or ends[1] is None:
        raise InputError(path, "expected a parent and a child link")
    along = element.find("axis")
    if kind == FIXED:
        along = None  # files write an axis of zero for a fixed joint
    axis = read_numbers(path, {} if along is None else along.attrib, "xyz", (1.0, 0.0, 0.0))
    length = float(np.linalg.norm(axis))
    if length < 1.0 / MAX_NUMBER:
        raise InputError(path, "expected an axis that is not zero")
    limits = None if kind == "continuous" else _limits(path, element.find("limit"))
    return JointElement(kind, ends[0], ends[1], _pose(path, element.find("origin")), axis / length, limits, name)


def _limits(path: Path, element: ET.Element | None) -> tuple[float, float] | None:
    """The limits in ascending order. None for an empty range, and for the largest floats, which mean no limit in some files."""
    attributes = {} if element is None else element.attrib
    ends = (float(read_numbers(path, attributes, field, (0.0,), sys.float_info.max)[0]) for field in ("lower", "upper"))
    lower, upper = sorted(ends)
    return (lower, upper) if -MAX_NUMBER <= lower < upper <= MAX_NUMBER else None


def _piece(
    path: Path, meshes: RobotMeshes, element: ET.Element, looks: UrdfMaterials | None, link: str, repairs: list[str]
) -> RobotPiece | None:
    """The piece of a visual or collision element of a link. None if it has no mesh, which the repairs say."""
    pose = _pose(path, element.find("origin"))
    shape = next(iter(element.findall("geometry/*")), None)
    if shape is None:
        repairs.append(f"{link}: {element.tag} without geometry: skipped")
        return None

    def number(field: str) -> float:
        return float(read_numbers(path, shape.attrib, field, (1.0,))[0])

    for field, count in _SIZES.get(shape.tag, {}).items():
        if np.any(read_numbers(path, shape.attrib, field, (1.0,) * count) < 0.0):
            repairs.append(f"{link}: {shape.tag} with the {field} {clean_text(shape.attrib[field])}, below 0: skipped")
            return None
    mesh: Mesh | None
    if shape.tag == "mesh":
        file = shape.get("filename") or ""
        if not file:
            repairs.append(f"{link}: mesh without filename: skipped")
            return None
        mesh = meshes.read(mesh_path(file, path, meshes.home), lambda: missing_mesh(file, path, meshes.home))
        pose[:3, :3] *= read_numbers(path, shape.attrib, "scale", (1.0, 1.0, 1.0))
    elif shape.tag == "box":
        mesh = meshes.counted(solids.box(read_numbers(path, shape.attrib, "size", (1.0, 1.0, 1.0))))
    elif shape.tag == "cylinder":
        mesh = meshes.counted(solids.cylinder(number("radius"), number("length")))
    elif shape.tag == "capsule":
        mesh = meshes.counted(solids.capsule(number("radius"), number("length")))
    elif shape.tag == "sphere":
        mesh = meshes.counted(solids.ellipsoid(np.full(3, number("radius"))))
    else:
        raise InputError(path, f"expected mesh, box, cylinder or sphere, found {shape.tag[:40]!r}", "geometry")
    if mesh is None:
        return None
    if looks is not None:
        mesh = looks.on(mesh, element)
    file = (shape.get("filename") or "") if shape.tag == "mesh" else ""
    return RobotPiece(placed(mesh, pose, path), clean_text(element.get("name") or ""), clean_text(Path(file).stem))


def _id_of_file(path: Path) -> str | None:
    return robot_id(path) if path.suffix.lower() == _ENDING else None


def _source_files(path: Path) -> SourceFiles:
    return robot_files(path, lambda: _named_files(path))


def _named_files(path: Path) -> list[Path]:
    """The meshes of a URDF file with their files, and its images."""
    root, home = parse_xml(read_bytes(path, path.parent, MAX_XML_BYTES), path), _home(path)
    meshes = those_inside(_mesh_files(path, root, home), home)
    names = dict.fromkeys(texture.get("filename") for texture in root.iter("texture"))
    images = [mesh_path(name, path, home) for name in names if name]
    return those_inside([*with_their_files(meshes), *material_files(meshes, home), *images], home)


READER = Reader(URDF, read_urdf, _source_files, id_of_file=_id_of_file, endings=(_ENDING,), is_robot=True)
