"""The mobility tree of a shape: its rigid bodies and the joints between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from graphlib import CycleError, TopologicalSorter

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body: leaf parts that move as one.

    Attributes:
        id: number of the body in its source.
        name: name of the body in its source.
        leaves: indices into `Shape.parts`.
        parent: index of the body that this one is attached to. None for a root.
        joint: the joint to the parent. A body with a parent and no joint is fixed to it.
    """

    id: int
    name: str
    leaves: tuple[int, ...]
    parent: int | None = None
    joint: Joint | None = None

    @property
    def is_movable(self) -> bool:
        return self.joint is not None


@dataclass(frozen=True, eq=False)
class Mobility:
    """The mobility tree of a shape. Every leaf belongs to exactly one body, and parents form no cycle.

    Attributes:
        bodies: the bodies, in any order. There may be several roots.
        junk: leaves that the annotation marks as not belonging to the object. They belong to bodies too.
    """

    bodies: tuple[Body, ...]
    junk: frozenset[int] = frozenset()

    def movable(self) -> Iterator[tuple[int, Body]]:
        """Index and body of every body that has a joint."""
        return ((i, body) for i, body in enumerate(self.bodies) if body.is_movable)

    def with_joints(self, change: Callable[[Joint], Joint]) -> Mobility:
        """The same bodies with changed joints."""
        bodies = (replace(body, joint=None if body.joint is None else change(body.joint)) for body in self.bodies)
        return replace(self, bodies=tuple(bodies))

    def rotated(self, rotation: NDArray[np.float64]) -> Mobility:
        """The mobility in a frame that `rotation` [3, 3] rotates the present frame to."""
        return self.with_joints(lambda joint: joint.rotated(rotation))

    def is_junk(self, index: int) -> bool:
        """True if body `index` has leaves and all of them are junk."""
        leaves = self.bodies[index].leaves
        return bool(leaves) and self.junk >= set(leaves)

    def descendants(self, index: int) -> tuple[int, ...]:
        """Indices of the bodies that move along with body `index`, itself first."""
        return descendants([body.parent for body in self.bodies], index)


def descendants(parents: Sequence[int | None], index: int) -> tuple[int, ...]:
    """Node `index` of a forest and all below it, breadth first. `parents` holds the parent of each node, None for roots."""
    found = [index]
    for node in found:
        found += [i for i, parent in enumerate(parents) if parent == node]
    return tuple(found)


def path_to_root(parents: Mapping[int, int], index: int) -> Iterator[int]:
    """`index`, its parent, the parent's parent and so on. `parents` has no entry for roots."""
    node: int | None = index
    while node is not None:
        yield node
        node = parents.get(node)


def has_cycle(parents: Sequence[int | None]) -> bool:
    """True if a node is its own ancestor. `parents` holds the parent of each node, None for roots."""
    try:
        TopologicalSorter({node: () if parent is None else (parent,) for node, parent in enumerate(parents)}).prepare()
    except CycleError:
        return True
    return False
