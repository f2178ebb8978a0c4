"""What a family builds: a tree of named nodes, and the links that its leaves form.

Everything is in PartNet-Mobility's frame: y up, +z to the front, +x to the right of who looks at it. Lengths
are the family's own; `SynthObject.normalise` brings an object to the size that files have.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.synth.primitives.place import move, rotation_about, scale, transform

Point = Sequence[float] | Vector


@dataclass(eq=False)
class Node:
    """A node of the hierarchy: children, or the pieces (one OBJ file each) of a leaf."""

    name: str
    children: list[Node] = field(default_factory=list)
    pieces: list[Mesh] = field(default_factory=list)

    def add(self, name: str, *pieces: Mesh) -> Node:
        """Append and return a child; without pieces it is a group that waits for children of its own."""
        child = Node(name, pieces=list(pieces))
        self.children.append(child)
        return child

    def walk(self) -> Iterator[Node]:
        """The node itself and all below it, in preorder."""
        yield self
        for child in self.children:
            yield from child.walk()

    def leaves(self) -> Iterator[Node]:
        """Nodes without children at or below this one, in preorder."""
        return (node for node in self.walk() if not node.children)


class JointName(str, Enum):
    """What mobility_v2.json calls a joint. Bodies that do not move are free, heavy or static; junk does not belong."""

    HINGE = "hinge"
    SLIDER = "slider"
    FREE = "free"
    HEAVY = "heavy"
    STATIC = "static"
    JUNK = "junk"


@dataclass(frozen=True, eq=False)
class Motion:
    """A joint as mobility_v2.json has it: `a` and `b` in degrees for a hinge, in lengths for a slider.

    They count from the pose of the file. A slider that `rotates` is a screw; `rotation_limit` is in degrees. `rest` is where
    the joint stands in the file, counted in the pose that the family builds the part in.
    """

    joint: JointName
    origin: Vector
    direction: Vector
    a: float = 0.0
    b: float = 0.0
    no_limit: bool = False
    rotates: bool = False
    rotation_limit: float | None = None
    rest: float = 0.0

    @property
    def is_hinge(self) -> bool:
        return self.joint is JointName.HINGE

    @property
    def has_place(self) -> bool:
        """Whether the place of the axis means something."""
        return self.is_hinge or self.rotates

    def at(self, value: float) -> NDArray[np.float64]:
        """Rigid transform [4, 4] of the part at a joint value."""
        if self.is_hinge:
            return rotation_about(self.direction, value, self.origin)
        matrix = np.eye(4)
        matrix[:3, 3] = value * self.direction / np.linalg.norm(self.direction)
        return matrix

    def moved_by(self, matrix: NDArray[np.float64]) -> Motion:
        """The joint carried along by a rigid transform [4, 4]."""
        rotation, offset = matrix[:3, :3], matrix[:3, 3]
        return replace(self, origin=rotation @ self.origin + offset, direction=rotation @ self.direction)

    def scaled(self, factors: float | Point) -> Motion:
        """The joint of a part that is scaled about the origin, by one factor or one an axis.

        Where the factors differ the part goes on moving as it did only if its joint lies along one of the axes.
        """
        factors = np.broadcast_to(np.asarray(factors, float), 3)
        unit = self.direction / np.linalg.norm(self.direction)
        length = 1.0 if self.is_hinge else float(np.linalg.norm(factors * unit))
        return replace(self, origin=factors * self.origin, a=length * self.a, b=length * self.b, rest=length * self.rest)


def hinge(origin: Point, direction: Point, a: float, b: float, *, rest: float = 0.0) -> Motion:
    """A revolute joint with limits in degrees."""
    return Motion(JointName.HINGE, np.array(origin, float), np.array(direction, float), a, b, rest=rest)


def spinner(origin: Point, direction: Point) -> Motion:
    """A revolute joint without limits."""
    return Motion(JointName.HINGE, np.array(origin, float), np.array(direction, float), no_limit=True)


def slider(direction: Point, a: float, b: float, *, rest: float = 0.0) -> Motion:
    """A prismatic joint with limits in lengths. Its origin means nothing: files mostly have zeros."""
    return Motion(JointName.SLIDER, np.zeros(3), np.array(direction, float), a, b, rest=rest)


def screw(origin: Point, direction: Point, a: float, b: float, *, turns: float | None = None, rest: float = 0.0) -> Motion:
    """A screw: slides from `a` to `b` while it turns, through `turns` degrees at most (None: freely)."""
    axis = np.array(origin, float), np.array(direction, float)
    return Motion(JointName.SLIDER, *axis, a, b, rotates=True, rotation_limit=turns, rest=rest)


@dataclass(eq=False)
class Link:
    """Nodes that move as one: whole subtrees or leaves. `motion` is how they move against `parent`.

    A link without motion takes `kind` (free, heavy, static or junk) as its joint. `lumped_name` is what its leaf is called
    where every body is one leaf (default: `name`, and "base_body" for what does not move).
    """

    name: str
    nodes: list[Node]
    parent: Link | None = None
    motion: Motion | None = None
    kind: JointName = JointName.FREE
    lumped_name: str = ""

    def leaves(self) -> Iterator[Node]:
        return (leaf for node in self.nodes for leaf in node.leaves())


@dataclass(eq=False)
class SynthObject:
    """An object as a family builds it. Every leaf below `root` belongs to exactly one link."""

    category: str
    root: Node
    links: list[Link]

    def below(self, link: Link) -> list[Link]:
        """`link` and all that hang on it, parents first."""
        found = [link]
        for above in found:
            found += [other for other in self.links if other.parent is above]
        return found

    def check(self) -> None:
        """Raise ValueError unless every leaf has geometry and exactly one link, and every parent is a link of the object."""
        owned = [leaf for link in self.links for leaf in link.leaves()]
        leaves = list(self.root.leaves())
        if len(owned) != len(set(owned)) or set(owned) != set(leaves):
            odd = [leaf.name for leaf in leaves if owned.count(leaf) != 1]
            raise ValueError(f"{self.category}: leaves {odd} do not belong to exactly one link")
        if not all(leaf.pieces for leaf in leaves):
            raise ValueError(f"{self.category}: a leaf without geometry")
        if not all(link.parent is None or link.parent in self.links for link in self.links):
            raise ValueError(f"{self.category}: a link hangs on one that is not part of the object")

    def depth(self, link: Link) -> int:
        """Number of links above `link`."""
        return 0 if link.parent is None else 1 + self.depth(link.parent)

    def settle(self) -> None:
        """Bring every joint to its rest value: what hangs on it moves along, and limits count from there."""
        for link in sorted(self.links, key=self.depth, reverse=True):
            if link.motion is None or link.motion.rest == 0.0:
                continue
            rest = link.motion.rest
            self._carry(link, link.motion.at(rest))
            link.motion = replace(link.motion, a=link.motion.a - rest, b=link.motion.b - rest, rest=0.0)

    def _carry(self, link: Link, matrix: NDArray[np.float64]) -> None:
        for carried in self.below(link):
            for leaf in carried.leaves():
                leaf.pieces = [transform(piece, matrix) for piece in leaf.pieces]
            if carried is not link and carried.motion is not None:
                carried.motion = carried.motion.moved_by(matrix)

    def bounds(self) -> tuple[Vector, Vector]:
        """Smallest and largest corner [3] of all vertices."""
        pieces = [piece.vertices for leaf in self.root.leaves() for piece in leaf.pieces]
        return np.min([p.min(axis=0) for p in pieces], axis=0), np.max([p.max(axis=0) for p in pieces], axis=0)

    def normalise(self, diagonal: float, offset: Point = (0.0, 0.0, 0.0)) -> None:
        """Centre the object's box at `offset` and scale it to `diagonal`, joints with it."""
        low, high = self.bounds()
        factor = diagonal / max(float(np.linalg.norm(high - low)), 1e-9)
        shift = np.asarray(offset, float) - factor * 0.5 * (low + high)
        for leaf in self.root.leaves():
            leaf.pieces = [move(scale(piece, factor), shift) for piece in leaf.pieces]
        for link in self.links:
            if link.motion is not None:
                scaled = link.motion.scaled(factor)
                link.motion = replace(scaled, origin=scaled.origin + shift)
