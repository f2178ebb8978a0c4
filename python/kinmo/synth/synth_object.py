"""Articulated object under construction: a tree of named nodes, and links made of its leaves.

Everything is in PartNet-Mobility's frame: y up, +z to the front, +x to the right of the viewer. Lengths are in units of the
family's own. `SynthObject.normalise` brings an object to the size that files have.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.synth.primitives.transforms import move, rotation_about, scale, transform

Point = Sequence[float] | Vector


@dataclass(eq=False)
class Node:
    """A node of the hierarchy.

    Attributes:
        name: Name in the written hierarchy.
        children: Child nodes. A node with children has no pieces.
        pieces: Meshes of a leaf, one OBJ file each.
    """

    name: str
    children: list[Node] = field(default_factory=list)
    pieces: list[Mesh] = field(default_factory=list)

    def add(self, name: str, *pieces: Mesh) -> Node:
        """Append and return a child. Without pieces it is a group, which needs children of its own."""
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


class JointType(str, Enum):
    """Joint types of mobility_v2.json.

    Hinge and slider are joints that move. Free, heavy and static are bodies without a joint. Junk is no part of the object.
    """

    HINGE = "hinge"
    SLIDER = "slider"
    FREE = "free"
    HEAVY = "heavy"
    STATIC = "static"
    JUNK = "junk"


@dataclass(frozen=True, eq=False)
class Motion:
    """A joint as mobility_v2.json states it. Values are degrees for a hinge and lengths for a slider.

    Attributes:
        type: HINGE or SLIDER.
        origin: A point [3] of the axis.
        direction: Direction [3] of the axis, of any length.
        a: One limit, counted from the pose of the file.
        b: The other limit. It may be the smaller one.
        no_limit: The joint turns freely; `a` and `b` mean nothing.
        rotates: The slider is a screw, which turns while it slides.
        rotation_limit: Largest turn of a screw in degrees, or None if it turns freely.
        rest: Joint value shown in the file, counted from the pose in which the family builds the part.
    """

    type: JointType
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
        """True for a revolute joint."""
        return self.type is JointType.HINGE

    @property
    def has_position(self) -> bool:
        """True if the position of the axis matters: for hinges and screws, not for sliders."""
        return self.is_hinge or self.rotates

    def at(self, value: float) -> NDArray[np.float64]:
        """Rigid transform [4, 4] of the part at a joint value (degrees or lengths)."""
        if self.is_hinge:
            return rotation_about(self.direction, value, self.origin)
        matrix = np.eye(4)
        matrix[:3, 3] = value * self.direction / np.linalg.norm(self.direction)
        return matrix

    def moved_by(self, matrix: NDArray[np.float64]) -> Motion:
        """The joint under a rigid transform [4, 4]."""
        rotation, offset = matrix[:3, :3], matrix[:3, 3]
        return replace(self, origin=rotation @ self.origin + offset, direction=rotation @ self.direction)

    def scaled(self, factors: float | Point) -> Motion:
        """The joint of a part that is scaled about the origin.

        With different factors the scaled part moves as before only if its axis lies along x, y or z.

        Args:
            factors: One factor, or one per axis [3].
        """
        factors = np.broadcast_to(np.asarray(factors, float), 3)
        unit = self.direction / np.linalg.norm(self.direction)
        length = 1.0 if self.is_hinge else float(np.linalg.norm(factors * unit))
        return replace(self, origin=factors * self.origin, a=length * self.a, b=length * self.b, rest=length * self.rest)


def hinge(origin: Point, direction: Point, a: float, b: float, *, rest: float = 0.0) -> Motion:
    """Revolute joint with limits `a` and `b` in degrees."""
    return Motion(JointType.HINGE, np.array(origin, float), np.array(direction, float), a, b, rest=rest)


def spinner(origin: Point, direction: Point) -> Motion:
    """Revolute joint without limits."""
    return Motion(JointType.HINGE, np.array(origin, float), np.array(direction, float), no_limit=True)


def slider(direction: Point, a: float, b: float, *, rest: float = 0.0) -> Motion:
    """Prismatic joint with limits `a` and `b` in lengths. Its origin is zero, as in most files."""
    return Motion(JointType.SLIDER, np.zeros(3), np.array(direction, float), a, b, rest=rest)


def screw(origin: Point, direction: Point, a: float, b: float, *, turns: float | None = None, rest: float = 0.0) -> Motion:
    """Screw joint: slides from `a` to `b` (lengths) while it turns by at most `turns` degrees (None: freely)."""
    axis = np.array(origin, float), np.array(direction, float)
    return Motion(JointType.SLIDER, *axis, a, b, rotates=True, rotation_limit=turns, rest=rest)


@dataclass(eq=False)
class Link:
    """Nodes that move as one rigid body.

    Attributes:
        name: Name of the body.
        nodes: Leaves or whole subtrees of the hierarchy.
        parent: The link that `motion` is relative to.
        motion: Joint between this link and `parent`, or None if the link does not move.
        kind: Joint type of a link without motion: free, heavy, static or junk.
        leaf_name: Name of the link's leaf in flat hierarchies, which have one leaf per link. Default: `name`, and "base_body"
            for a link without motion.
    """

    name: str
    nodes: list[Node]
    parent: Link | None = None
    motion: Motion | None = None
    kind: JointType = JointType.FREE
    leaf_name: str = ""

    def leaves(self) -> Iterator[Node]:
        """Leaves of all nodes of the link."""
        return (leaf for node in self.nodes for leaf in node.leaves())

    def move(self, matrix: NDArray[np.float64]) -> None:
        """Move the link's meshes and its joint by a rigid transform [4, 4], in place."""
        for leaf in self.leaves():
            leaf.pieces = [transform(piece, matrix) for piece in leaf.pieces]
        if self.motion is not None:
            self.motion = self.motion.moved_by(matrix)


@dataclass(eq=False)
class SynthObject:
    """An object as a family builds it. Every leaf below `root` belongs to exactly one link.

    Attributes:
        category: Category in `kinmo.core.categories.canonical_category`'s spelling.
        root: Root of the hierarchy.
        links: All links, in any order.
    """

    category: str
    root: Node
    links: list[Link]

    @classmethod
    def flat(cls, category: str, links: list[Link]) -> SynthObject:
        """Object whose nodes all hang directly below the root. Those of the base, `links[0]`, come last."""
        base, *moving = links
        return cls(category, Node(category, [*(node for link in moving for node in link.nodes), *base.nodes]), links)

    def subtree(self, link: Link) -> list[Link]:
        """`link` and all links that hang on it, parents first."""
        found = [link]
        for above in found:
            found += [other for other in self.links if other.parent is above]
        return found

    def depth(self, link: Link) -> int:
        """Number of links above `link`."""
        return 0 if link.parent is None else 1 + self.depth(link.parent)

    def check(self) -> None:
        """Check the rules that writers rely on.

        Raises:
            ValueError: A leaf has no geometry or not exactly one link, or a parent is no link of the object.
        """
        owned = [leaf for link in self.links for leaf in link.leaves()]
        leaves = list(self.root.leaves())
        if len(owned) != len(set(owned)) or set(owned) != set(leaves):
            odd = [leaf.name for leaf in leaves if owned.count(leaf) != 1]
            raise ValueError(f"{self.category}: leaves {odd} do not belong to exactly one link")
        if not all(leaf.pieces for leaf in leaves):
            raise ValueError(f"{self.category}: a leaf has no geometry")
        if not all(link.parent is None or link.parent in self.links for link in self.links):
            raise ValueError(f"{self.category}: the parent of a link is not part of the object")

    def apply_rest_pose(self) -> None:
        """Bring every joint to its rest value, in place. Child links move along, and limits count from the new pose."""
        for link in sorted(self.links, key=self.depth, reverse=True):
            motion = link.motion
            if motion is None or motion.rest == 0.0:
                continue
            matrix = motion.at(motion.rest)
            for carried in self.subtree(link):
                carried.move(matrix)
            link.motion = replace(motion, a=motion.a - motion.rest, b=motion.b - motion.rest, rest=0.0)

    def move(self, matrix: NDArray[np.float64]) -> None:
        """Move the whole object by a rigid transform [4, 4], in place."""
        for link in self.links:
            link.move(matrix)

    def bounds(self) -> tuple[Vector, Vector]:
        """Smallest and largest corner [3] of all vertices."""
        pieces = [piece.vertices for leaf in self.root.leaves() for piece in leaf.pieces]
        return np.min([p.min(axis=0) for p in pieces], axis=0), np.max([p.max(axis=0) for p in pieces], axis=0)

    def normalise(self, diagonal: float, offset: Point = (0.0, 0.0, 0.0)) -> None:
        """Scale the object and its joints to a bounding-box diagonal, and centre its box, in place.

        Args:
            diagonal: Wanted length of the diagonal.
            offset: Wanted centre [3] of the box.
        """
        low, high = self.bounds()
        factor = diagonal / max(float(np.linalg.norm(high - low)), 1e-9)
        shift = np.asarray(offset, float) - factor * 0.5 * (low + high)
        for leaf in self.root.leaves():
            leaf.pieces = [move(scale(piece, factor), shift) for piece in leaf.pieces]
        for link in self.links:
            if link.motion is not None:
                scaled = link.motion.scaled(factor)
                link.motion = replace(scaled, origin=scaled.origin + shift)
