"""The links of a robot: bodies that are fastened to each other are one."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.core.joint import Joint
from kinmo.core.mobility import Mobility
from kinmo.core.names import unique_names

BASE = "base"


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid piece of the robot. `body` is the body whose joint moves it (None for the base), `bodies` all that it is made of.

    `parent` is the index of the link that `joint` is attached to; both are None for the base, which comes first.
    """

    name: str
    body: int | None
    bodies: tuple[int, ...]
    leaves: tuple[int, ...]
    parent: int | None = None
    joint: Joint | None = None


def links_of(mobility: Mobility) -> tuple[Link, ...]:
    """The links of a mobility tree, every link after its parent.

    The base takes all bodies that stand on their own, and every link the bodies that are fastened to it, so that the links form
    one tree whatever the number of roots. A mobility without a root body gets an empty base.
    """
    bodies = mobility.bodies

    def owner(index: int) -> int | None:
        """The movable body that `index` goes along with; None for the base."""
        node: int | None = index
        while node is not None and bodies[node].joint is None:
            node = bodies[node].parent
        return node

    owners = [owner(index) for index in range(len(bodies))]
    order: list[int | None] = [None]
    for above in order:
        order += [i for i, body in enumerate(bodies) if body.joint is not None and _owner_above(owners, body.parent) == above]
    place = {body: index for index, body in enumerate(order)}
    names = unique_names(BASE if body is None else bodies[body].name for body in order)
    links = []
    for name, body in zip(names, order, strict=True):
        members = tuple(i for i, owning in enumerate(owners) if owning == body)
        leaves = tuple(sorted(leaf for i in members for leaf in bodies[i].leaves))
        if body is None:
            links.append(Link(name, None, members, leaves))
        else:
            links.append(
                Link(name, body, members, leaves, place[_owner_above(owners, bodies[body].parent)], bodies[body].joint)
            )
    return tuple(links)


def _owner_above(owners: list[int | None], parent: int | None) -> int | None:
    return None if parent is None else owners[parent]
