"""SDF, the format of Gazebo: the first model of a file as a tree of links with geometry."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, join
from kinmo.io.readers import solids
from kinmo.io.readers.dae_reader import read_dae_scene
from kinmo.io.readers.robot_file import FIXED, JointElement, Matrix, RobotFile, RobotPiece, ordered_links
from kinmo.io.readers.robot_meshes import RobotMeshes, mesh_path
from kinmo.io.readers.robot_numbers import read_numbers
from kinmo.io.readers.scene import Scene, placed
from kinmo.io.readers.untrusted_files import inside, read_bytes
from kinmo.io.readers.xml_files import MAX_XML_BYTES, parse_xml

ROOT = "_root"
"""Name of the empty link that holds the links without a joint above them, if there are several."""
_ROOTS = ("sdf", "gazebo")
"""The root element, now and in old files."""
_NO_LIMIT = 1000.0
"""Files write limits from here on for joints without limits."""
_AXES_OF_MODEL = (1, 4)
"""Last version of SDF in which axes are in the frame of the model, not in that of the joint."""


def read_sdf_robot(path: Path, report: Callable[[InputError], None], home: Path) -> RobotFile:
    """Read an SDF file with its meshes. All links are in the frame of the model. Only visual elements are used.

    A joint whose limits are equal is fixed. Of several joints above a link, the last one counts. Nested and included models are
    not read, nor are frames that elements name.

    Args:
        path: the file.
        report: receives the problem of each mesh that cannot be read.
        home: a folder at or above that of the file, which no path may lead out of.

    Raises:
        InputError: the file is no SDF, or a path leads out of `home`.
    """
    return _SdfModel(path, report, home).robot()


class _SdfModel:
    """Reads the first model of a file."""

    def __init__(self, path: Path, report: Callable[[InputError], None], home: Path) -> None:
        self.path, self.home, self.report = path, home, report
        root = parse_xml(read_bytes(path, path.parent, MAX_XML_BYTES), path)
        model = next(root.iter("model"), None)
        if root.tag not in _ROOTS or model is None:
            raise InputError(path, "expected SDF with a model")
        try:
            version = tuple(int(part) for part in root.get("version", "1.4").split("."))
        except ValueError:
            raise InputError(path, "expected a version such as 1.6", "sdf version") from None
        self.has_axes_of_model = version <= _AXES_OF_MODEL
        self.model = model
        self.files = RobotMeshes(path, home, report)
        self.poses = {link.get("name", ""): self._pose(link) for link in model.findall("link")}

    def robot(self) -> RobotFile:
        """The links, joints and meshes."""
        found = [self._joint(element) for element in self.model.findall("joint")]
        above = {joint.child: joint for joint in found if joint.parent in self.poses and joint.child in self.poses}
        joints = list(above.values())
        names = list(self.poses)
        below = {joint.child for joint in joints}
        tops = [name for name in names if name not in below]
        if len(tops) > 1:
            joints[:0] = [
                JointElement(FIXED, ROOT, top, np.eye(4), np.array([0.0, 0.0, 1.0]), None, f"rest_{top}") for top in tops
            ]
            names = [ROOT, *names]
        pieces: dict[str, list[RobotPiece]] = {ROOT: []}
        for link in self.model.findall("link"):
            own = (self._piece(visual, self.poses[link.get("name", "")]) for visual in link.findall("visual"))
            pieces[link.get("name", "")] = [piece for piece in own if piece is not None]
        links = ordered_links(self.path, names, joints)
        above = {joint.child: joint for joint in joints}
        return RobotFile(self.path, self.model.get("name", ""), links, above, pieces, tuple(self.files.files))

    def _pose(self, element: ET.Element) -> Matrix:
        """The pose [4, 4] of an element in what it is in."""
        numbers = self._numbers(element, "pose", (0.0,) * 6)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = Rotation.from_euler("xyz", numbers[3:]).as_matrix(), numbers[:3]
        return pose

    def _numbers(self, element: ET.Element, field: str, default: tuple[float, ...]) -> Matrix:
        """The numbers in the inner element `field`. The default if there is none."""
        text = (element.findtext(field) or "").strip()
        return read_numbers(self.path, {field: text} if text else {}, field, default)

    def _limit(self, joint: ET.Element, end: str) -> float:
        """A limit of a joint. Infinity if there is none."""
        text = (joint.findtext(f"axis/limit/{end}") or "").strip()
        return float(read_numbers(self.path, {end: text} if text else {}, end, (np.inf,), sys.float_info.max)[0])

    def _joint(self, element: ET.Element) -> JointElement:
        """A joint, with its axis in the frame of the model."""
        name, kind = element.get("name", ""), element.get("type", "")
        parent, child = (element.findtext(end, "").strip() for end in ("parent", "child"))
        place = self.poses.get(child, np.eye(4)) @ self._pose(element)
        axis = self._numbers(element, "axis/xyz", (0.0, 0.0, 1.0))
        in_model = element.findtext("axis/use_parent_model_frame", "").strip() in ("1", "true")
        if not (self.has_axes_of_model or in_model):
            axis = place[:3, :3] @ axis
        length = float(np.linalg.norm(axis))
        if not length > 0.0:
            raise InputError(self.path, "expected an axis that is not zero", f"joint {name}")
        lower, upper = (self._limit(element, end) for end in ("lower", "upper"))
        is_limited = max(abs(lower), abs(upper)) < _NO_LIMIT
        limits = (lower, upper) if is_limited and lower < upper else None
        kind = FIXED if is_limited and lower == upper else kind
        return JointElement(kind, parent, child, np.eye(4), axis / length, limits, name, place[:3, 3])

    def _piece(self, visual: ET.Element, link: Matrix) -> RobotPiece | None:
        """The piece of a visual element in the frame of the model. None if it has no mesh."""
        shape = next(iter(visual.findall("geometry/*")), None)
        if shape is None:
            return None
        name, pose = "", link @ self._pose(visual)
        mesh: Mesh | None = None
        if shape.tag == "mesh":
            file = mesh_path(shape.findtext("uri", "").strip(), self.path, self.home)
            name, part = file.stem, shape.findtext("submesh/name", "").strip()
            mesh = self._submesh(file, part, shape) if part else self.files.read(file)
            pose[:3, :3] *= self._numbers(shape, "scale", (1.0, 1.0, 1.0))
        elif shape.tag == "box":
            mesh = solids.box(self._numbers(shape, "size", (1.0, 1.0, 1.0)))
        elif shape.tag == "sphere":
            mesh = solids.ellipsoid(np.full(3, self._numbers(shape, "radius", (1.0,))[0]))
        elif shape.tag == "cylinder":
            radius, length = (float(self._numbers(shape, field, (1.0,))[0]) for field in ("radius", "length"))
            mesh = solids.cylinder(radius, length)
        return None if mesh is None else RobotPiece(placed(mesh, pose, self.path), visual.get("name", ""), name)

    def _submesh(self, file: Path, part: str, shape: ET.Element) -> Mesh | None:
        """The node `part` of a DAE file, with all below it. None if it cannot be read."""
        try:
            scene = read_dae_scene(inside(file, self.home))
        except InputError as problem:
            self.report(problem)
            return None
        own = [node.mesh for index, node in enumerate(scene.nodes) if node.mesh is not None and part in _names(scene, index)]
        if not own:
            self.report(InputError(file, f"has no node {part}"))
            return None
        mesh = self.files.counted(join(*own))
        vertices = mesh.vertices * (scene.metres_per_unit or 1.0)
        if shape.findtext("submesh/center", "").strip() in ("1", "true"):
            vertices = vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        return Mesh(vertices, mesh.faces)


def _names(scene: Scene, index: int) -> set[str]:
    """Names of a node and of those above it."""
    names: set[str] = set()
    place: int | None = index
    while place is not None:
        names.add(scene.nodes[place].name)
        place = scene.nodes[place].parent
    return names
