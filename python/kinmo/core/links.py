"""Robot links: bodies that are fixed to each other form one link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility
from kinmo.core.names import name_or_number, unique_names

BASE = "base"
"""Name of the root link."""
NAME_ENDINGS = ("", "_joint", "_slide", "_slide_joint")
"""Endings of the names of a link, its joint, and the extra link and joint of a screw."""


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid link of a robot. Its names are identifiers, all of them different. Exports have the same names.

    Attributes:
        name: name of the link: that of `body`, or body_ and its number if the name has no letter or digit of ASCII.
        body: index of the body whose joint moves the link. None for the base.
        bodies: indices of all bodies that form the link.
        leaves: indices of all leaf parts that form the link.
        parent: index of the link that `joint` is attached to. None for the base.
        joint: the joint to the parent link. None for the base.
        joint_name: name of the joint in a robot. Empty for the base.
        slide_link: name of the light link between the two robot joints of a screw. Empty for others.
        slide_joint_name: name of the robot joint by which a screw slides; `joint_name` turns it. Empty for others.
    """

    name: str
    body: int | None
    bodies: tuple[int, ...]
    leaves: tuple[int, ...]
    parent: int | None = None
    joint: Joint | None = None
    joint_name: str = ""
    slide_link: str = ""
    slide_joint_name: str = ""


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
    stems = (BASE if body is None else name_or_number(bodies[body].name, "body", bodies[body].id) for body in order)
    links = []
    for (name, joint_name, *slide), body in zip(_names(unique_names(stems)), order, strict=True):
        members = tuple(i for i, found in enumerate(movers) if found == body)
        leaves = tuple(sorted(leaf for i in members for leaf in bodies[i].leaves))
        if body is None:
            links.append(Link(name, None, members, leaves))
        else:
            parent, joint = place[mover(bodies[body].parent)], bodies[body].joint
            screw = slide if joint is not None and joint.kind is JointKind.SCREW else ()
            links.append(Link(name, body, members, leaves, parent, joint, joint_name, *screw))
    return tuple(links)


def _names(stems: Sequence[str]) -> list[list[str]]:
    """Four names for each link, one for each of `NAME_ENDINGS`. All differ."""
    names = unique_names(f"{stem}{ending}" for ending in NAME_ENDINGS for stem in stems)
    return [names[place :: len(stems)] for place in range(len(stems))]
