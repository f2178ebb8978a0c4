"""Conversion of the nested nodes of a file to the parts of a shape."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Part
from kinmo.io.readers.json_field import JsonField

MAX_PARTS = 1000
MAX_DEPTH = 64
MIN_AREA = 1e-12
"""Smallest area of a surface, relative to the squared largest extent. A smaller mesh is a point or a line."""


@dataclass(frozen=True)
class Node:
    """A node of a file. `parent` is an index into the list of nodes, which is in preorder, or None for the root."""

    field: JsonField
    id: int
    name: str
    parent: int | None
    is_leaf: bool

    def __str__(self) -> str:
        return f"part {self.id} ({self.name})"


@dataclass(frozen=True, eq=False)
class Hierarchy:
    """The parts that have geometry, in preorder, and one line for each node that was skipped.

    `leaves_of` has the indices of the leaf parts at or below each node by its id, also for skipped nodes.
    """

    parts: tuple[Part, ...]
    leaves_of: Mapping[int, tuple[int, ...]]
    repairs: tuple[str, ...]


def read_nodes(root: JsonField, name: str) -> list[Node]:
    """All nodes at or below a JSON object with fields `id`, `children` and `name`, in preorder."""
    nodes: list[Node] = []
    seen: dict[int, str] = {}
    pending: list[tuple[JsonField, int | None, int]] = [(root, None, 0)]
    while pending:
        field, parent, depth = pending.pop()
        check_depth(field, depth)
        check_part_count(field, len(nodes))
        identity = field["id"].integer()
        if identity in seen:
            raise field["id"].fail(f"part {identity} occurs twice, first at {seen[identity]}")
        seen[identity] = field.path
        children = field["children"].items()
        pending += [(child, len(nodes), depth + 1) for child in reversed(children)]
        nodes.append(Node(field, identity, field[name].text(""), parent, not children))
    return nodes


def check_depth(node: JsonField, depth: int) -> None:
    """Raise InputError if a node is more than `MAX_DEPTH` levels below the root."""
    if depth > MAX_DEPTH:
        raise node.fail(f"nested deeper than {MAX_DEPTH} levels")


def check_part_count(node: JsonField, before: int) -> None:
    """Raise InputError if `MAX_PARTS` parts come before a node."""
    if before >= MAX_PARTS:
        raise InputError(node.where, f"more than {MAX_PARTS} parts")


def build_hierarchy(
    nodes: Sequence[Node], meshes: Mapping[int, Mesh | None], notes: Sequence[str] = (), noted: Collection[int] = ()
) -> Hierarchy:
    """The parts of a shape from nodes in preorder. Nodes without a surface at or below them are skipped.

    Args:
        nodes: The nodes.
        meshes: Meshes of leaves by index of the node, in ascending order.
        notes: Repairs so far. They come first.
        noted: Indices of leaves that `notes` mention already.

    Raises:
        InputError: No mesh has a surface. The message has the first note.
    """
    surfaces = {index: mesh for index, mesh in meshes.items() if mesh is not None and has_surface(mesh)}
    below: list[list[int]] = [[] for _ in nodes]
    for leaf in surfaces:
        above: int | None = leaf
        while above is not None:
            below[above].append(leaf)
            above = nodes[above].parent
    place = {index: position for position, index in enumerate(index for index, leaves in enumerate(below) if leaves)}
    if not place:
        raise InputError(nodes[0].field.where, "no part has geometry" + "".join(f" ({note})" for note in notes[:1]))
    parents = {index: nodes[index].parent for index in place}
    children: dict[int | None, list[int]] = {index: [] for index in (None, *place)}
    for index, parent in parents.items():
        children[parent].append(place[index])
    parts = []
    for index, parent in parents.items():
        node, parent_place = nodes[index], None if parent is None else place[parent]
        parts.append(Part(node.id, node.name, parent_place, tuple(children[index]), surfaces.get(index)))
    leaves_of = {node.id: tuple(place[leaf] for leaf in leaves) for node, leaves in zip(nodes, below, strict=True)}
    empty = [node for index, node in enumerate(nodes) if not below[index] and index not in noted]
    return Hierarchy(tuple(parts), leaves_of, (*notes, *(f"{node} has no surface: skipped" for node in empty)))


def has_surface(mesh: Mesh) -> bool:
    """True if the faces of a mesh cover an area."""
    if not len(mesh.faces):
        return False
    extent = float(np.max(np.ptp(mesh.vertices, axis=0)))
    if extent == 0.0:
        return False
    a, b, c = np.moveaxis(((mesh.vertices - mesh.vertices[0]) / extent)[mesh.faces], 1, 0)
    return bool(0.5 * np.sum(np.linalg.norm(np.cross(b - a, c - a), axis=1)) > MIN_AREA)
