"""Roles of a shape's leaves when one body moves: own, moving, reference, obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kinmo.core.mobility import Body, descendants
from kinmo.features.prepared_shape import PreparedShape


@dataclass(frozen=True, eq=False)
class LeafRoles:
    """Leaves that matter to the motion of one body, as positions in `PreparedShape.leaves`.

    Attributes:
        own: Leaves of the body.
        moving: Leaves of the body and of its descendants.
        reference: Leaves of the body that it is attached to; all obstacles if it is attached to none.
        obstacles: Leaves that do not move with the body.
    """

    own: list[int]
    moving: list[int]
    reference: list[int]
    obstacles: list[int]


def leaf_roles(shape: PreparedShape, bodies: Sequence[Body]) -> list[LeafRoles]:
    """Roles of the leaves for each of `bodies`, which form a mobility tree of the shape."""
    position = {leaf: place for place, leaf in enumerate(shape.leaves)}
    own = [[position[leaf] for leaf in body.leaves] for body in bodies]
    parents = [body.parent for body in bodies]
    roles = []
    for index, body in enumerate(bodies):
        moving = sorted(leaf for below in descendants(parents, index) for leaf in own[below])
        obstacles = sorted(set(range(len(shape.leaves))) - set(moving))
        reference = own[body.parent] if body.parent is not None else obstacles
        roles.append(LeafRoles(own[index], moving, reference, obstacles))
    return roles
