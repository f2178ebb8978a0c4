"""Articulated objects as folders with a URDF file, its meshes and the facts about their origin.

Collectors of objects write them (`collect_scene_synthesizer.py`, `collect_infinigen.py`, `collect_handmade.py`). Those of
generated objects run without kinmo, in the environment of the generator. `mobility_from_urdf.py` turns the folders into
annotated shapes.
"""

from __future__ import annotations

import argparse
import json
import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

URDF_FILE, FACTS_FILE, MESHES = "mobility.urdf", "object.json", "meshes"


@dataclass(frozen=True, eq=False)
class Piece:
    """A named mesh of a link: vertices [V, 3] in metres in the frame of the link, and triangles [F, 3]."""

    name: str
    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint between two links.

    Attributes:
        kind: "revolute", "continuous", "prismatic" or "fixed".
        origin: [3], position of the child link in the frame of the parent link, in metres.
        rpy: [3], its roll, pitch and yaw, in radians.
        axis: [3], unit vector in the frame of the child link.
        limits: lower and upper value, in radians or metres. None without limits.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Sequence[float] = (0.0, 0.0, 0.0)
    rpy: Sequence[float] = (0.0, 0.0, 0.0)
    axis: Sequence[float] = (1.0, 0.0, 0.0)
    limits: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class UrdfObject:
    """An articulated object: the pieces of each link by its name, its joints, and the facts about its origin.

    The facts need `category`, `up` and `front`: signed axes such as "z" and "-y" in the frame of the root link.
    """

    links: Mapping[str, Sequence[Piece]]
    joints: Sequence[Connection]
    facts: Mapping[str, Any] = field(default_factory=dict)


def collector_parser(description: str | None, assets: Sequence[str]) -> argparse.ArgumentParser:
    """A parser with the options of a collector that knows some `assets`."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=15, help="objects of each asset (default 15)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first object (default 0)")
    parser.add_argument("--out", type=Path, required=True, help="folder for one folder per object")
    parser.add_argument(
        "--assets", nargs="+", choices=assets, default=list(assets), metavar="NAME", help="of: " + ", ".join(assets)
    )
    return parser


def write_urdf_object(folder: Path, made: UrdfObject) -> Path:
    """Write an object.

    Args:
        folder: The folder to write mobility.urdf, object.json and meshes/*.obj into.
        made: The object.

    Returns:
        Path of the URDF file.
    """
    (folder / MESHES).mkdir(parents=True, exist_ok=True)
    robot = ET.Element("robot", name=folder.name)
    used: Counter[str] = Counter()
    for name, pieces in made.links.items():
        link = ET.SubElement(robot, "link", name=name)
        for piece in pieces:
            stem = f"{re.sub(r'[^A-Za-z0-9_-]+', '_', name)}-{re.sub(r'[^A-Za-z0-9_-]+', '_', piece.name)}"
            file = f"{MESHES}/{stem}-{used[stem]}.obj"
            used[stem] += 1
            _write_obj(folder / file, piece)
            visual = ET.SubElement(link, "visual", name=piece.name)
            ET.SubElement(ET.SubElement(visual, "geometry"), "mesh", filename=file)
    for joint in made.joints:
        _add_joint(robot, joint)
    ET.indent(robot)
    path = folder / URDF_FILE
    ET.ElementTree(robot).write(path, encoding="utf-8", xml_declaration=True)
    (folder / FACTS_FILE).write_text(json.dumps(dict(made.facts), indent=1, default=_plain) + "\n", encoding="utf-8")
    return path


def _add_joint(robot: ET.Element, joint: Connection) -> None:
    element = ET.SubElement(robot, "joint", name=joint.name, type=joint.kind)
    ET.SubElement(element, "origin", xyz=_text(joint.origin), rpy=_text(joint.rpy))
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    ET.SubElement(element, "axis", xyz=_text(joint.axis))
    if joint.limits is not None:
        lower, upper = map(float, joint.limits)
        ET.SubElement(element, "limit", lower=repr(lower), upper=repr(upper), effort="1000", velocity="1")


def _text(numbers: Sequence[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def _write_obj(path: Path, piece: Piece) -> None:
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in np.asarray(piece.vertices, float).tolist())
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (np.asarray(piece.faces, int) + 1).tolist())
    path.write_text(vertices + faces, encoding="ascii")


def _plain(value: Any) -> Any:
    """Plain data for the types of NumPy."""
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)
