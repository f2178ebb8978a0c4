"""Articulated objects that people modelled by hand, as annotated shapes in the layout of PartNet-Mobility.

`handmade_objects.toml` names them, with the repositories on GitHub that have them, their commits and their licences. They are
URDF, SDF and MJCF files of simulators and robots. Each visual element is a leaf with its maker's name. Shapes are y-up with
their front at +z, as `mobility_from_urdf.py` writes them.

CLONES is a folder with clones, git folders or unpacked archives of the repositories, named OWNER+NAME, OWNER/NAME or NAME. The
others are reported and left out. Files of the repositories are read as data and none of them is changed or run. The objects are
not part of kinmo. Their licences, in the table that this script prints and in every meta.json, bind whoever uses them.

Usage:
    git clone https://github.com/vikashplus/furniture_sim CLONES/furniture_sim  # and so on, or any of them
    python bench/collect_handmade.py CLONES OUT [--objects NAME ...]
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from common import print_table
from kinmo.core.errors import InputError
from kinmo.core.toml_text import parse_toml
from kinmo.core.wording import counted
from kinmo.io.readers.mjcf_reader import SHOWN_GROUPS, read_mjcf_robot
from kinmo.io.readers.robot_bodies import link_poses
from kinmo.io.readers.robot_file import FIXED, RobotFile, RobotPiece
from kinmo.io.readers.scene import placed
from kinmo.io.readers.urdf_reader import read_robot_file
from mobility_from_urdf import write_truth
from repository_files import find_repository, unpack
from sdf_file import read_sdf_robot
from urdf_objects import Connection, Piece, UrdfObject, write_urdf_object

OBJECTS_FILE = Path(__file__).with_name("handmade_objects.toml")
_WRAPPER = "kinmo_wrapper.xml"
_NO_NAME = re.compile(r"(visuals?|vis|v|geom|mesh|collision|link|base_link|unnamed)?[\W_\d]*", re.IGNORECASE)
"""Names of visual elements that say nothing about what they are."""
_UNNAMED_BODY = re.compile(r"body \d+")
"""Names that kinmo gives to bodies of MJCF without a name."""

Report = Callable[[InputError], None]
Row = tuple[str, str, str, int, int]
"""Repository, commit, licence, objects and joints."""


@dataclass(frozen=True)
class Entry:
    """An object of `handmade_objects.toml`, which says what the fields are."""

    file: str
    category: str
    front: str
    up: str = "z"
    assets: str = ""
    groups: Sequence[int] = SHOWN_GROUPS
    link: str = ""
    without: Sequence[str] = ()
    held: Mapping[str, str] = field(default_factory=dict)
    licence: str = ""


@dataclass(frozen=True)
class Source:
    """A repository of `handmade_objects.toml`, which says what the fields are."""

    repository: str
    commit: str
    licence: str
    paths: Sequence[str]
    objects: Mapping[str, Entry]
    folder: str = ""
    angle: str = ""


def read_sources(path: Path = OBJECTS_FILE) -> dict[str, Source]:
    """The sources of a list of objects, by name."""
    table = parse_toml(path.read_bytes(), path)
    try:
        return {
            name: Source(**source | {"objects": {key: Entry(**entry) for key, entry in source["objects"].items()}})
            for name, source in table.items()
        }
    except (TypeError, KeyError, AttributeError) as error:
        raise InputError(path, f"expected sources with objects ({error})") from None


def make_object(tree: Path, source: Source, entry: Entry, commit: str, report: Report) -> UrdfObject:
    """Read one object.

    Args:
        tree: The unpacked files of the repository. The folder has the repository's name, as some of its paths need that.
        source: The repository.
        entry: The object.
        commit: The commit of the files.
        report: Receives the problem of each mesh that cannot be read.

    Returns:
        The object with all joints at zero. Links have the axes of the frame of its file, with their origin on the joint's axis.

    Raises:
        InputError: A file is missing or wrong, or a link or joint that the entry names is not in it.
    """
    path = tree / source.folder / entry.file
    robot = _read_robot(path, tree, source, entry, report)
    joints = [joint.name for joint in robot.joint_above.values()]
    for names, known in (((*entry.without, *filter(None, [entry.link])), robot.links), (entry.held, joints)):
        if lacking := [name for name in names if name not in known]:
            raise InputError(path, f"has no {', '.join(lacking)}")
    facts = {
        "category": entry.category, "asset": str(path.relative_to(tree).as_posix()),
        "generator": f"https://github.com/{source.repository}", "version": commit,
        "licence": entry.licence or source.licence, "up": entry.up, "front": entry.front,
    }  # fmt: skip
    return _urdf_object(robot, entry, facts)


def _read_robot(path: Path, tree: Path, source: Source, entry: Entry, report: Report) -> RobotFile:
    """The robot file of an object, with a file around it if it is no whole MJCF file."""
    home = tree.parent
    if path.suffix == ".urdf":
        return read_robot_file(path, home, report)
    if path.suffix == ".sdf":
        return read_sdf_robot(path, report, home)
    if entry.assets or source.angle:
        whole = tree / source.folder if entry.assets else path.parent
        inner, path = path, whole / _WRAPPER
        path.write_bytes(_wrapper(source, entry, inner))
    return read_mjcf_robot(path, report, home, entry.groups)


def _wrapper(source: Source, entry: Entry, inner: Path) -> bytes:
    """An MJCF file that includes that of an object."""
    root = ET.Element("mujoco")
    if source.angle:
        ET.SubElement(root, "compiler", angle=source.angle)
    if not entry.assets:
        ET.SubElement(root, "include", file=inner.name)
        return ET.tostring(root)
    ET.SubElement(root, "include", file=entry.assets)
    body = ET.SubElement(ET.SubElement(root, "worldbody"), "body", name=inner.stem)
    ET.SubElement(body, "include", file=entry.file)
    return ET.tostring(root)


def _urdf_object(robot: RobotFile, entry: Entry, facts: Mapping[str, str]) -> UrdfObject:
    """The parts of a robot that an entry takes, without links that hold nothing."""
    above, poses = robot.joint_above, link_poses(robot)
    top = entry.link or robot.links[0]
    taken: list[str] = []
    for name in robot.links:  # every link after its parent
        if name not in entry.without and (name == top or (name in above and above[name].parent in taken)):
            taken.append(name)
    kinds = {name: _kind(robot, entry, name) if name != top else FIXED for name in taken}
    parents = {above[name].parent for name in taken if name != top}
    kept = [name for name in robot.pieces if name in taken]  # in the order of the file
    taken = [name for name in kept if robot.pieces[name] or kinds[name] != FIXED or name in parents]
    names, titles = _link_names(robot, taken)
    origins = {
        name: poses[name][:3, :3] @ above[name].pivot + poses[name][:3, 3] if kinds[name] != FIXED else np.zeros(3)
        for name in taken
    }
    links = {}
    for name in taken:
        pose = poses[name].copy()
        pose[:3, 3] -= origins[name]
        own = robot.pieces[name]
        links[names[name]] = [
            _piece(piece, pose, robot, _title(piece, titles[name], len(own) > 1 or robot.path.suffix == ".xml"))
            for piece in own
        ]
    joints = []
    for name in taken:
        if name == top:
            continue
        joint, kind = above[name], kinds[name]
        title, origin = joint.name or f"joint_{names[name]}", (origins[name] - origins[joint.parent]).tolist()
        if kind == FIXED:
            joints.append(Connection(title, kind, names[joint.parent], names[name], origin))
            continue
        limits = None if kind == "continuous" else joint.limits
        axis = (poses[name][:3, :3] @ joint.axis).tolist()
        joints.append(Connection(title, kind, names[joint.parent], names[name], origin, axis=axis, limits=limits))
    return UrdfObject(links, joints, facts)


def _kind(robot: RobotFile, entry: Entry, name: str) -> str:
    """The type of the joint above a link. Hinges that can turn all round are continuous."""
    joint = robot.joint_above[name]
    if joint.name in entry.held:
        return FIXED
    is_round = joint.limits is None or joint.limits[1] - joint.limits[0] >= 2.0 * np.pi - 1e-3
    return "continuous" if joint.type == "revolute" and is_round else joint.type


def _link_names(robot: RobotFile, taken: Sequence[str]) -> tuple[dict[str, str], dict[str, str]]:
    """Names of links, all different, and what their unnamed pieces are called.

    Bodies without a name have that of their parent.
    """
    names: dict[str, str] = {}
    titles: dict[str, str] = {}
    used: Counter[str] = Counter()
    for name in robot.links:
        is_unnamed = _UNNAMED_BODY.fullmatch(name) and name in robot.joint_above
        titles[name] = titles[robot.joint_above[name].parent] if is_unnamed else name
        used[titles[name]] += 1
        names[name] = titles[name] if used[titles[name]] == 1 else f"{titles[name]} {used[titles[name]]}"
    return {name: names[name] for name in taken}, titles


def _title(piece: RobotPiece, link: str, takes_mesh: bool) -> str:
    """Name of a piece: its own, else that of its mesh if the piece `takes_mesh`, else that of its link."""
    if not _NO_NAME.fullmatch(piece.name):
        return piece.name
    return piece.mesh_name if piece.mesh_name and takes_mesh else link


def _piece(piece: RobotPiece, pose: np.ndarray, robot: RobotFile, name: str) -> Piece:
    mesh = placed(piece.mesh, pose, robot.path)
    return Piece(name, mesh.vertices, mesh.faces.astype(np.int64))


def collect(name: str, source: Source, clones: Path, out: Path) -> list[Row]:
    """Write the objects of a source, and print a line for everything that is missing.

    Args:
        name: Name of the source.
        source: The source.
        clones: Folder of clones, git folders or unpacked archives.
        out: Folder for one folder per object.

    Returns:
        Repository, commit, licence, objects and joints, for each licence.
    """
    place = find_repository(clones, source.repository)
    if place is None:
        print(f"{source.repository}: not in {clones}, {counted(len(source.objects), 'object')} left out", file=sys.stderr)
        return []
    objects: Counter[str] = Counter()
    joints: Counter[str] = Counter()
    told: set[str] = set()

    def tell(what: str, problem: InputError) -> None:
        line = f"{what}: {Path(problem.where).name}: {problem.problem}"
        if line not in told:
            print(line, file=sys.stderr)
        told.add(line)

    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "files" / source.repository.partition("/")[2]
        try:
            commit = unpack(place, source.commit, source.paths, tree)
        except InputError as problem:
            tell(source.repository, problem)
            return []
        if commit != source.commit:
            print(f"{source.repository}: {commit or 'files without git'} in place of commit {source.commit}", file=sys.stderr)
        for key, entry in source.objects.items():
            title = f"{name}-{key}"
            try:
                made = make_object(tree, source, entry, commit or "unknown", partial(tell, f"{source.repository}: left out"))
                write_urdf_object(Path(folder) / title, made)
                shape = write_truth(Path(folder) / title, out / title)
            except InputError as problem:
                tell(title, problem)
                continue
            assert shape.mobility is not None
            licence = entry.licence or source.licence
            objects[licence] += 1
            joints[licence] += sum(1 for _ in shape.mobility.movable())
    return [(source.repository, commit[:9] or "unknown", licence, objects[licence], joints[licence]) for licence in objects]


def main() -> int:
    """Write the objects, and print what there is of each licence."""
    sources = read_sources()
    names = [f"{name}-{key}" for name, source in sources.items() for key in source.objects]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clones", type=Path, help="folder of clones, git folders or unpacked archives")
    parser.add_argument("out", type=Path, help="folder for one folder per object")
    parser.add_argument("--objects", nargs="+", choices=names, default=names, metavar="NAME", help="of: " + ", ".join(names))
    args = parser.parse_args()
    rows: list[Row] = []
    for name, source in sources.items():
        wanted = {key: entry for key, entry in source.objects.items() if f"{name}-{key}" in args.objects}
        if wanted:
            rows += collect(name, replace(source, objects=wanted), args.clones, args.out)
    print_table(("repository", "commit", "licence", "objects", "joints"), rows)
    found = sum(count for *_, count, _ in rows)
    print(f"{found} of {len(args.objects)} objects in {args.out}")
    return 0 if found == len(args.objects) else 1


if __name__ == "__main__":
    sys.exit(main())
