"""Which parts of a shape form rigid bodies, and how the bodies move against each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint


@dataclass(frozen=True, eq=False)
class Body:
    """Leaves that move as one. `leaves` are indices into `Shape.parts`.

    `parent` is the index of the body that `joint` moves this one against; None for a body that stands on its own. A body with a
    parent and no joint is fastened to it. `id` and `name` are those of the source.
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
    """The mobility tree of a shape: every leaf belongs to exactly one body, and parents form no cycle.

    `junk` are leaves that the annotation marks as not belonging to the object (they belong to bodies too).
    """

    bodies: tuple[Body, ...]
    junk: frozenset[int] = frozenset()

    def movable(self) -> Iterator[tuple[int, Body]]:
        """Index and body of everything that has a joint."""
        return ((i, body) for i, body in enumerate(self.bodies) if body.is_movable)

    def with_joints(self, change: Callable[[Joint], Joint]) -> Mobility:
        """The same bodies, their joints changed."""
        bodies = (replace(body, joint=None if body.joint is None else change(body.joint)) for body in self.bodies)
        return replace(self, bodies=tuple(bodies))

    def turned(self, rotation: NDArray[np.float64]) -> Mobility:
        """The same bodies and joints in a frame to which `rotation` [3, 3] takes this one's."""
        return self.with_joints(lambda joint: joint.turned(rotation))

    def descendants(self, index: int) -> tuple[int, ...]:
        """Indices of the bodies that move along with body `index`, itself first."""
        return descendants([body.parent for body in self.bodies], index)


def descendants(parents: Sequence[int | None], index: int) -> tuple[int, ...]:
    """Indices below `index` in a forest given by `parents`, `index` first, breadth first."""
    found = [index]
    for node in found:
        found += [i for i, parent in enumerate(parents) if parent == node]
    return tuple(found)


def upwards(parents: Mapping[int, int], index: int) -> Iterator[int]:
    """`index`, what it is attached to by `parents`, and so on."""
    node: int | None = index
    while node is not None:
        yield node
        node = parents.get(node)


def has_cycle(parents: Sequence[int | None]) -> bool:
    """Whether following parents ever comes back."""
    state = [0] * len(parents)
    for start in range(len(parents)):
        path = []
        node: int | None = start
        while node is not None and state[node] == 0:
            state[node] = 1
            path.append(node)
            node = parents[node]
        if node is not None and state[node] == 1:
            return True
        for visited in path:
            state[visited] = 2
    return False
