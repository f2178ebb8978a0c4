"""Robot links: bodies that are fixed to each other form one link."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.core.joint import Joint
from kinmo.core.mobility import Mobility
from kinmo.core.names import unique_names

BASE = "base"
"""Name of the root link."""


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid link of a robot.

    Attributes:
        name: unique name of the link.
        body: index of the body whose joint moves the link. None for the base.
        bodies: indices of all bodies that form the link.
        leaves: indices of all leaf parts that form the link.
        parent: index of the link that `joint` is attached to. None for the base.
        joint: the joint to the parent link. None for the base.
    """

    name: str
    body: int | None
    bodies: tuple[int, ...]
    leaves: tuple[int, ...]
    parent: int | None = None
    joint: Joint | None = None


def links_of(mobility: Mobility) -> tuple[Link, ...]:
    """The links of a mobility as one tree, the base first and every link after its parent.

    The base holds all root bodies. It is empty if there is none. Every link also holds the bodies that are fixed to it.
    """
    bodies = mobility.bodies

    def mover(index: int | None) -> int | None:
        """The body whose joint moves body `index`. None if the base holds it."""
        while index is not None and bodies[index].joint is None:
            index = bodies[index].parent
        return index

    movers = [mover(index) for index in range(len(bodies))]
    order: list[int | None] = [None]
    for above in order:
        order += [i for i, body in enumerate(bodies) if body.joint is not None and mover(body.parent) == above]
    place = {body: index for index, body in enumerate(order)}
    names = unique_names(BASE if body is None else bodies[body].name for body in order)
    links = []
    for name, body in zip(names, order, strict=True):
        members = tuple(i for i, found in enumerate(movers) if found == body)
        leaves = tuple(sorted(leaf for i in members for leaf in bodies[i].leaves))
        if body is None:
            links.append(Link(name, None, members, leaves))
        else:
            links.append(Link(name, body, members, leaves, place[mover(bodies[body].parent)], bodies[body].joint))
    return tuple(links)
