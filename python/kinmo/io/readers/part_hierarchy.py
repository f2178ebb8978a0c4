"""Conversion of the nested nodes of a file to the parts of a shape."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Part
from kinmo.io.readers.json_field import JsonField

MAX_PARTS = 1000
MAX_DEPTH = 64


@dataclass(frozen=True)
class Node:
    """A node of a file.

    Attributes:
        field: the JSON object of the node.
        id: number of the node.
        name: name of the node.
        parent: index into the list of nodes, which is in preorder. None for the root.
        is_leaf: True if the node has no children.
    """

    field: JsonField
    id: int
    name: str
    parent: int | None
    is_leaf: bool

    def __str__(self) -> str:
        return f"part {self.id} ({self.name})"


@dataclass(frozen=True, eq=False)
class Hierarchy:
    """The parts that have geometry.

    Attributes:
        parts: the parts in preorder.
        leaves_of: for the id of every node, included or not, the indices of the leaf parts at or below it.
        repairs: one line for each node that was skipped.
    """

    parts: tuple[Part, ...]
    leaves_of: Mapping[int, tuple[int, ...]]
    repairs: tuple[str, ...]


def read_nodes(root: JsonField, name: str) -> list[Node]:
    """All nodes of a nested JSON hierarchy.

    Args:
        root: the JSON object of the root, with fields `id` and `children`.
        name: the field that holds the name of a node.

    Returns:
        The nodes in preorder.

    Raises:
        InputError: an id occurs twice, or there are too many nodes or levels.
    """
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


def build_hierarchy(nodes: Sequence[Node], meshes: Mapping[int, Mesh]) -> Hierarchy:
    """Build the parts of a shape. Nodes without a mesh at or below them are skipped.

    Args:
        nodes: the nodes in preorder.
        meshes: meshes of leaf nodes by index of the node.

    Returns:
        The hierarchy of the other nodes.

    Raises:
        InputError: no node has a mesh.
    """
    has_mesh = [index in meshes for index in range(len(nodes))]
    for index in reversed(range(len(nodes))):
        parent = nodes[index].parent
        if parent is not None and has_mesh[index]:
            has_mesh[parent] = True
    kept = [index for index in range(len(nodes)) if has_mesh[index]]
    if not kept:
        raise InputError(nodes[0].field.where, "no part has geometry")
    place = {index: position for position, index in enumerate(kept)}
    children: list[list[int]] = [[] for _ in kept]
    leaves_of: dict[int, list[int]] = {node.id: [] for node in nodes}
    for index in kept:
        parent = nodes[index].parent
        if parent is not None:
            children[place[parent]].append(place[index])
        if index in meshes:
            above: int | None = index
            while above is not None:
                leaves_of[nodes[above].id].append(place[index])
                above = nodes[above].parent
    parts = []
    for position, index in enumerate(kept):
        node = nodes[index]
        parent_place = None if node.parent is None else place[node.parent]
        parts.append(Part(node.id, node.name, parent_place, tuple(children[position]), meshes.get(index)))
    repairs = tuple(f"{node} has no surface: skipped" for index, node in enumerate(nodes) if not has_mesh[index])
    return Hierarchy(tuple(parts), {node: tuple(leaves) for node, leaves in leaves_of.items()}, repairs)
