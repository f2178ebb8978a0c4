"""From the nested nodes of a file to the parts of a shape."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Part
from kinmo.io.readers.field import Field

MOST_PARTS = 1000
DEEPEST = 64


@dataclass(frozen=True)
class Node:
    """A node as the file has it. `parent` is an index into the list of nodes, which is in preorder."""

    field: Field
    id: int
    name: str
    parent: int | None
    is_leaf: bool

    def __str__(self) -> str:
        return f"part {self.id} ({self.name})"


@dataclass(frozen=True, eq=False)
class Hierarchy:
    """The parts with geometry.

    `leaves_of` gives for the id of every node, left out or not, the indices of the leaves at or below it. `repairs` says what
    was left out.
    """

    parts: tuple[Part, ...]
    leaves_of: Mapping[int, tuple[int, ...]]
    repairs: tuple[str, ...]


def walk(root: Field, name: str) -> list[Node]:
    """All nodes below `root` in preorder, named by their field `name`. Raises InputError for an id that occurs twice."""
    nodes: list[Node] = []
    seen: dict[int, str] = {}
    pending: list[tuple[Field, int | None, int]] = [(root, None, 0)]
    while pending:
        field, parent, depth = pending.pop()
        check_depth(field, depth)
        check_number(field, len(nodes))
        identity = field["id"].integer()
        if identity in seen:
            raise field["id"].fail(f"part {identity} occurs twice, first at {seen[identity]}")
        seen[identity] = field.path
        children = field["children"].items()
        pending += [(child, len(nodes), depth + 1) for child in reversed(children)]
        nodes.append(Node(field, identity, field[name].text(""), parent, not children))
    return nodes


def check_depth(node: Field, depth: int) -> None:
    """Raises InputError for a node that is nested too deeply."""
    if depth > DEEPEST:
        raise node.fail(f"nested deeper than {DEEPEST} levels")


def check_number(node: Field, before: int) -> None:
    """Raises InputError for a node that is a part, if there are too many `before` it."""
    if before >= MOST_PARTS:
        raise InputError(node.where, f"more than {MOST_PARTS} parts")


def build(nodes: Sequence[Node], meshes: Mapping[int, Mesh]) -> Hierarchy:
    """Parts from nodes and the meshes of leaf nodes, by index; what is left without a mesh is left out."""
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
    repairs = tuple(f"{node} has no surface: left out" for index, node in enumerate(nodes) if not has_mesh[index])
    return Hierarchy(tuple(parts), {node: tuple(leaves) for node, leaves in leaves_of.items()}, repairs)
