"""A robot file, URDF or MJCF: a tree of links with geometry, and the joints between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.core.wording import printable

Matrix = NDArray[np.float64]
"""An array of numbers, or a rigid transform [4, 4]."""

MAX_NUMBER = 1e30
"""Largest number in a robot file."""
FIXED = "fixed"
"""Type of a joint that does not move."""
MAX_LINKS = 10_000
"""Most links of a robot."""
_MAX_LISTED = 5
"""Most links that a message names."""


@dataclass(frozen=True, eq=False)
class JointElement:
    """A joint between the links `parent` and `child`.

    Attributes:
        type: the type as URDF names it, such as "revolute".
        pose: [4, 4], transform from the child link to the parent link at joint value 0.
        axis: [3], unit vector in the frame of the child link.
        limits: lower and upper limit, in radians or metres. None without limits.
        name: name of the joint. Empty if it has none.
        pivot: [3], a point of the axis in the frame of the child link.
    """

    type: str
    parent: str
    child: str
    pose: Matrix
    axis: Matrix
    limits: tuple[float, float] | None
    name: str = ""
    pivot: Matrix = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, eq=False)
class RobotPiece:
    """A visual element of URDF or a geom of MJCF.

    Attributes:
        mesh: its triangles in the frame of its link.
        name: its name in the file. Empty if it has none.
        mesh_name: name of the mesh asset, or of the mesh file without its ending. Empty for solids.
    """

    mesh: Mesh
    name: str = ""
    mesh_name: str = ""


@dataclass(frozen=True, eq=False)
class RobotFile:
    """A tree of links.

    Attributes:
        path: the file.
        name: name of the robot. Empty if it has none.
        links: names of the links, the root first and every link after its parent.
        joint_above: the joint of each child link, by name of the link.
        pieces: the pieces of each link, by name of the link.
        mesh_files: the mesh files that the file names.
        repairs: one line for everything that was dropped.
    """

    path: Path
    name: str
    links: tuple[str, ...]
    joint_above: dict[str, JointElement]
    pieces: dict[str, list[RobotPiece]]
    mesh_files: tuple[Path, ...] = ()
    repairs: tuple[str, ...] = ()


def ordered_links(path: Path, names: Sequence[str], joints: Sequence[JointElement]) -> tuple[str, ...]:
    """Names of the links, each after its parent. Raises InputError unless they form one tree.

    Args:
        path: the file, for messages.
        names: names of all links.
        joints: the joints between them.
    """
    if not names:
        raise InputError(path, "expected at least one link")
    if len(names) > MAX_LINKS:
        raise InputError(path, f"more than {MAX_LINKS} links")
    children: dict[str, list[str]] = {name: [] for name in names}
    seen: set[str] = set()
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in children:
                raise InputError(path, f"expected a link of the name {end!r}", f"joint {joint.name}".strip())
        if joint.child in seen:
            raise InputError(path, f"expected one joint above link {joint.child!r}", f"joint {joint.name}".strip())
        seen.add(joint.child)
        children[joint.parent].append(joint.child)
    roots = [name for name in names if name not in seen]
    if len(roots) > 1:
        raise InputError(path, f"expected one root link, found {len(roots)} ({_listed(roots)}): join them with fixed joints")
    order = list(roots)
    for name in order:
        order += children[name]
    if len(order) < len(names):
        cycle = _cycle(set(names) - set(order), {joint.child: joint.parent for joint in joints})
        raise InputError(path, f"expected a tree, found a cycle of joints between the links {_listed(cycle)}")
    return tuple(order)


def _cycle(rest: set[str], above: dict[str, str]) -> list[str]:
    """The links of a cycle of joints. `rest` are links that no root is above, and `above` has the parent of each link."""
    link = min(rest)
    passed: dict[str, None] = {}
    while link not in passed:
        passed[link] = None
        link = above[link]
    chain = list(passed)
    return chain[chain.index(link) :]


def _listed(names: Sequence[str]) -> str:
    """Names with commas between, at most `_MAX_LISTED` of them."""
    return ", ".join([*names[:_MAX_LISTED], *["..."] * (len(names) > _MAX_LISTED)])


@contextmanager
def about(path: Path, element: str) -> Iterator[None]:
    """Put an element, such as "link door", in front of the field of an InputError about the robot file in the block."""
    try:
        yield
    except InputError as error:
        if error.where != printable(str(path)):
            raise
        raise InputError(path, error.problem, element if error.field is None else f"{element}: {error.field}") from None
