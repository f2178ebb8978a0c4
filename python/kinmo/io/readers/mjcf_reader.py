"""MJCF, the format of MuJoCo: the bodies are the parts, and their joints are the annotation."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers import solids
from kinmo.io.readers.mesh_limits import checked
from kinmo.io.readers.mjcf_document import MAX_DEPTH, Attributes, MjcfDocument, rotation_of_z
from kinmo.io.readers.mjcf_materials import MjcfMaterials
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.reader import Reader, SourceFiles
from kinmo.io.readers.robot_file import FIXED, MAX_LINKS, JointElement, Matrix, RobotFile, RobotPiece, about, ordered_links
from kinmo.io.readers.robot_meshes import RobotMeshes, with_their_files
from kinmo.io.readers.robot_numbers import read_list, read_numbers
from kinmo.io.readers.robot_shape import robot_files, robot_id, shape_of_robot
from kinmo.io.readers.scene import ignored, placed
from kinmo.io.readers.untrusted_files import peek, those_inside

MJCF = "mjcf"
_ENDINGS = (".xml", ".mjcf")
_ROOT = re.compile(rb"<\s*mujoco[\s/>]")
_BEFORE_ROOT = re.compile(rb"<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>]*>|\s+|\xef\xbb\xbf", re.DOTALL)
_WORLD, _UNNAMED = "world", "body "
_JOINT_TYPES = {"hinge": "revolute", "slide": "prismatic"}
"""Types of URDF by those of MJCF. Others are none that kinmo knows."""
SHOWN_GROUPS = (0, 1, 2)
"""Groups of geoms that viewers show. By convention, the other groups have collision geoms."""
_IGNORED_BODIES = ("composite", "flexcomp", "replicate", "attach")
"""Elements that MuJoCo expands to bodies."""


def read_mjcf(path: Path) -> Shape:
    """Read an MJCF file as a shape (see `shape_of_robot`). Meshes that cannot be read are skipped with a note."""
    path = Path(path)
    problems: list[InputError] = []
    return shape_of_robot(read_mjcf_robot(path, problems.append), MJCF, "MJCF", problems)


def read_mjcf_robot(
    path: Path, report: Callable[[InputError], None], home: Path | None = None, groups: Collection[int] = SHOWN_GROUPS
) -> RobotFile:
    """Read an MJCF file with its meshes.

    A body becomes a link. Each of several joints of a body has a link of its own, without geometry. Geoms that viewers hide, by
    their group or because they are transparent, are used if there are no others.

    Args:
        path: the file.
        report: receives the problem of each mesh that cannot be read.
        home: a folder at or above that of the file, which no path may lead out of. By default that of the file.
        groups: the groups of geoms that are shown.

    Raises:
        InputError: the file is no MJCF, or a path leads out of `home`.
    """
    return _MjcfRobot(MjcfDocument(path, home), report, groups).robot()


class _MjcfRobot:
    """Collects the links of a document."""

    def __init__(self, document: MjcfDocument, report: Callable[[InputError], None], groups: Collection[int]) -> None:
        self.document = document
        self.groups = groups
        self.path = document.path
        self.report = report
        self.ignored: Counter[str] = Counter()
        materials = MtlMaterials(document.home, lambda what: self.ignored.update([what]), reads_files=False)
        self.files = RobotMeshes(self.path, document.home, report, materials)
        self.looks = MjcfMaterials(document, materials)
        self.assets = dict(document.assets("mesh"))
        self.names = [_WORLD]
        self.joints: list[JointElement] = []
        self.geoms: dict[str, list[tuple[Attributes, Matrix]]] = {_WORLD: []}

    def robot(self) -> RobotFile:
        """The links, joints and meshes."""
        for world in self.document.root.findall("worldbody"):
            self._read_content(world, _WORLD, np.eye(4), world.get("childclass"))
        shown = {name: [geom for geom in own if self._is_shown(name, geom[0])] for name, own in self.geoms.items()}
        used = shown if any(shown.values()) else self.geoms
        made = {name: [self._piece(name, attributes, pose) for attributes, pose in own] for name, own in used.items()}
        pieces = {name: [piece for piece in own if piece is not None] for name, own in made.items()}
        named = [self.document.mesh_path(asset["file"]) for asset in self.assets.values() if "file" in asset]
        links = ordered_links(self.path, self.names, self.joints)
        above = {joint.child: joint for joint in self.joints}
        title = clean_text(self.document.root.get("model", ""))
        return RobotFile(self.path, title, links, above, pieces, tuple(named), ignored(self.ignored))

    def _read_content(self, top: ET.Element, top_link: str, top_pose: Matrix, top_class: str | None) -> None:
        """Read the geoms, frames and bodies in the world."""
        pending: list[tuple[ET.Element, str, Matrix, str | None, int]] = [(top, top_link, top_pose, top_class, 0)]
        while pending:
            element, link, pose, inherited, depth = pending.pop()
            if depth > MAX_DEPTH:
                raise InputError(self.path, f"nested deeper than {MAX_DEPTH} levels")
            inner = []
            for child in element:
                own = child.get("childclass") or inherited
                if child.tag == "geom":
                    with about(self.path, _title(link)):
                        self.geoms[link].append((self.document.with_defaults(child, inherited), pose))
                elif child.tag == "frame":
                    with about(self.path, f"{_title(link)}: frame"):
                        inner.append((child, link, pose @ self.document.pose(child.attrib), own, depth + 1))
                elif child.tag == "body":
                    name = self._new_name(child.get("name") or f"{_UNNAMED}{len(self.names)}")
                    with about(self.path, _title(name)):
                        self._add_body(child, name, link, pose @ self.document.pose(child.attrib), own)
                    inner.append((child, name, np.eye(4), own, depth + 1))
                elif child.tag in _IGNORED_BODIES:
                    self.ignored[f"elements {child.tag}"] += 1
            pending += reversed(inner)

    def _add_body(self, body: ET.Element, name: str, parent: str, pose: Matrix, inherited: str | None) -> None:
        """Add a body with its joints, as a link of this name. `pose` leads to the link `parent`."""
        found = [child for child in body if child.tag in ("joint", "freejoint")]
        kinds = [self.document.with_defaults(child, inherited) for child in found]
        moving = [self._joint(child.tag, attributes) for child, attributes in zip(found, kinds, strict=True)]
        for number, (kind, title, axis, pivot, limits) in enumerate(moving or [_FIXED_JOINT], start=1):
            is_last = number >= len(moving)
            link = name if is_last else self._new_name(f"{name} {number}")
            self._add_link(link)
            self.joints.append(JointElement(kind, parent, link, pose, axis, limits, title, pivot))
            parent, pose = link, np.eye(4)

    def _joint(self, tag: str, attributes: Attributes) -> tuple[str, str, Matrix, Matrix, tuple[float, float] | None]:
        """Type, name, axis, pivot and limits of a joint."""
        kind = "free" if tag == "freejoint" else attributes.get("type", "hinge")
        name = clean_text(attributes.get("name", ""))
        if kind not in _JOINT_TYPES:
            return kind, name, np.array([0.0, 0.0, 1.0]), np.zeros(3), None
        with about(self.path, f"joint {name}".strip()):
            axis = self.document.direction(read_numbers(self.path, attributes, "axis", (0.0, 0.0, 1.0)), "axis")
            pivot = read_numbers(self.path, attributes, "pos", (0.0, 0.0, 0.0))
            return _JOINT_TYPES[kind], name, axis, pivot, self._limits(kind, attributes)

    def _limits(self, kind: str, attributes: Attributes) -> tuple[float, float] | None:
        """The limits of a joint in ascending order. None for an empty range."""
        is_limited = attributes.get("limited", "auto")
        if is_limited != "true" and not (is_limited == "auto" and self.document.has_automatic_limits and "range" in attributes):
            return None
        (rest,) = read_numbers(self.path, attributes, "ref", (0.0,))
        ends = sorted(read_numbers(self.path, attributes, "range", (0.0, 0.0)) - rest)
        lower, upper = (self.document.angle(float(end)) if kind == "hinge" else float(end) for end in ends)
        return (lower, upper) if lower < upper else None

    def _new_name(self, name: str) -> str:
        """`name`, with a number if another link has it."""
        taken, number = set(self.names), 2
        candidate = name
        while candidate in taken:
            candidate, number = f"{name} {number}", number + 1
        return candidate

    def _add_link(self, name: str) -> None:
        if len(self.names) >= MAX_LINKS:
            raise InputError(self.path, f"more than {MAX_LINKS} bodies")
        self.names.append(name)
        self.geoms[name] = []

    def _is_shown(self, link: str, attributes: Attributes) -> bool:
        """True for a geom of a shown group that is not wholly transparent."""
        with about(self.path, _title(link, attributes)):
            group = float(read_numbers(self.path, attributes, "group", (0.0,))[0])
            alpha = float(read_numbers(self.path, attributes, "rgba", (1.0, 1.0, 1.0, 1.0))[3])
        return group in self.groups and (alpha > 0.0 or "material" in attributes)

    def _piece(self, link: str, attributes: Attributes, pose: Matrix) -> RobotPiece | None:
        """The piece of a geom; `pose` leads from what it is in to its link. None if it has no mesh."""
        with about(self.path, _title(link, attributes)):
            mesh = self._mesh(attributes)
            if mesh is None:
                return None
            name, asset = (clean_text(attributes.get(key, "")) for key in ("name", "mesh"))
            return RobotPiece(placed(self.looks.on(mesh, attributes), pose, self.path), name, asset)

    def _mesh(self, attributes: Attributes) -> Mesh | None:
        """The mesh of a geom in its body. None if it has none."""
        kind = "mesh" if "mesh" in attributes else attributes.get("type", "sphere")
        pose = self.document.pose(attributes)
        if kind == "mesh":
            mesh = self._asset(attributes.get("mesh", ""))
            return None if mesh is None else placed(mesh, pose, self.path)
        if kind not in _SOLIDS:
            self.ignored[f"geoms of type {clean_text(kind)}"] += 1
            return None
        least = _SOLIDS[kind]
        if "fromto" in attributes and kind != "sphere":
            ends = read_list(self.path, attributes, "fromto", 6, 6).reshape(2, 3)
            along = ends[1] - ends[0]
            pose[:3, 3] = ends.mean(axis=0)
            pose[:3, :3] = rotation_of_z(self.document.direction(along, "fromto"))
            radii = read_list(self.path, attributes, "size", 1, 3)
            half = float(np.linalg.norm(along)) / 2.0
            size = np.array([radii[0], radii[0] if kind in ("box", "ellipsoid") else half, half])
        else:
            size = read_list(self.path, attributes, "size", least, 3)
        if np.any(size[:least] <= 0.0):
            raise InputError(self.path, "expected sizes above 0", "size")
        if kind == "box":
            mesh = solids.box(2.0 * size)
        elif kind == "ellipsoid":
            mesh = solids.ellipsoid(size)
        elif kind == "sphere":
            mesh = solids.ellipsoid(np.full(3, size[0]))
        else:
            make = solids.capsule if kind == "capsule" else solids.cylinder
            mesh = make(float(size[0]), 2.0 * float(size[1]))
        return placed(self.files.counted(mesh), pose, self.path)

    def _asset(self, name: str) -> Mesh | None:
        """The mesh asset of this name, moved and scaled. None if it cannot be read."""
        if name not in self.assets:
            raise InputError(self.path, f"there is no mesh asset {clean_text(name)}", "mesh")
        asset = self.assets[name]
        if "file" in asset:
            mesh = self.files.read(self.document.mesh_path(asset["file"]))
        elif "vertex" in asset:
            mesh = self.files.counted(self._inline(asset))
        else:
            self.ignored["meshes that MuJoCo computes"] += 1
            return None
        if mesh is None:
            return None
        turn = np.eye(4)
        turn[:3, :3] = self.document.orientation({"quat": asset["refquat"]} if "refquat" in asset else {}).T
        shift, scale = np.eye(4), np.eye(4)
        shift[:3, 3] = -read_numbers(self.path, asset, "refpos", (0.0, 0.0, 0.0))
        scale[:3, :3] *= read_numbers(self.path, asset, "scale", (1.0, 1.0, 1.0))
        return placed(mesh, scale @ turn @ shift, self.path)

    def _inline(self, asset: Attributes) -> Mesh:
        """A mesh asset whose vertices are in the file. Without faces it is their convex hull."""
        most = 3 * MAX_INLINE_VERTICES
        vertices = read_list(self.path, asset, "vertex", 9, most)
        if len(vertices) % 3:
            raise InputError(self.path, "expected 3 numbers for each vertex", "mesh vertex")
        vertices = vertices.reshape(-1, 3)
        checked(Mesh(vertices, np.zeros((0, 3), np.uint32)), self.path)
        if "face" not in asset:
            if np.linalg.matrix_rank(vertices - vertices[0]) < 3:
                raise InputError(self.path, "expected vertices around a volume", "mesh vertex")
            from trimesh.convex import convex_hull  # trimesh takes long to import, and few files need it

            hull = convex_hull(vertices)
            return Mesh(np.array(hull.vertices, np.float64), np.array(hull.faces, np.uint32))
        faces = read_list(self.path, asset, "face", 3, 2 * most)
        if len(faces) % 3 or np.any((faces < 0) | (faces >= len(vertices)) | (faces % 1 != 0)):
            raise InputError(self.path, f"expected triangles of vertices 0..{len(vertices) - 1}", "mesh face")
        return Mesh(vertices, faces.reshape(-1, 3).astype(np.uint32)).compact


MAX_INLINE_VERTICES = 1_000_000
_SOLIDS = {"box": 3, "ellipsoid": 3, "sphere": 1, "capsule": 2, "cylinder": 2}
"""Solids, and the least number of their sizes."""
_FIXED_JOINT = (FIXED, "", np.array([0.0, 0.0, 1.0]), np.zeros(3), None)


def _title(link: str, geom: Attributes | None = None) -> str:
    """Name for messages of the body of a link, or of a geom in it."""
    body = link if link.startswith(_UNNAMED) else f"body {clean_text(link)}"
    return body if geom is None else f"{body}: geom {clean_text(geom.get('name', ''))}".strip()


def _id_of_file(path: Path) -> str | None:
    if path.suffix.lower() not in _ENDINGS:
        return None
    begin = peek(path, path.parent)
    place = 0
    while match := _BEFORE_ROOT.match(begin, place):
        place = match.end()
    return robot_id(path) if _ROOT.match(begin, place) else None


def _source_files(path: Path) -> SourceFiles:
    return robot_files(path, lambda: _named_files(MjcfDocument(path)))


def _named_files(document: MjcfDocument) -> list[Path]:
    """The files that a document includes, its meshes with their files, and its images. MuJoCo reads no MTL files."""
    meshes = [document.mesh_path(asset["file"]) for _, asset in document.assets("mesh") if "file" in asset]
    images = [document.texture_path(asset["file"]) for _, asset in document.assets("texture") if "file" in asset]
    named = with_their_files(those_inside(meshes, document.home))
    return those_inside([*document.included, *named, *images], document.home)


READER = Reader(MJCF, read_mjcf, _source_files, id_of_file=_id_of_file, endings=(".xml (MJCF)",), is_robot=True)
