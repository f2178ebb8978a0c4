"""True labels of the edges between sibling parts, from an annotated mobility (paper, section 3.1).

Every part has a *carrier*: the body that the whole part moves along with. The edge i -> j describes the motion of part i
relative to part j. Its label is the motion type of the joint of i's carrier if that joint is attached to j's carrier. The label
is FIXED if both parts have the same carrier, else NONE. It depends on the hierarchy alone, not on the order of children in a
file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.mobility import Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.shape import Shape


@dataclass(frozen=True, eq=False)
class EdgeLabels:
    """The labels of E edges, in the frame and the length unit of the shape.

    Attributes:
        types: [E] int64, values of `MotionType`.
        bodies: [E] int64, index of the moving body, or -1 for an edge without motion.
        directions: [E, 3] float64, unit axis directions, or zero for an edge without motion.
        pivots: [E, 3] float64, points of the axes, or zero for an edge without motion.
    """

    types: NDArray[np.int64]
    bodies: NDArray[np.int64]
    directions: NDArray[np.float64]
    pivots: NDArray[np.float64]


def sibling_edges(shape: Shape) -> NDArray[np.int64]:
    """All ordered pairs [E, 2] of parts with the same parent, as indices into `shape.parts`."""
    pairs = [(i, j) for part in shape.parts for i in part.children for j in part.children if i != j]
    return np.array(pairs, np.int64).reshape(-1, 2)


def carriers_of(leaf_sets: Sequence[Sequence[int]], mobility: Mobility) -> tuple[int | None, ...]:
    """The body that each set of leaves moves along with.

    It is the topmost body that owns one of the leaves. It is None if other leaves of the set do not move along with that body.
    """
    body_of = {leaf: index for index, body in enumerate(mobility.bodies) for leaf in body.leaves}
    moved_along = [set(mobility.descendants(index)) for index in range(len(mobility.bodies))]

    def carrier(leaves: Sequence[int]) -> int | None:
        present = {body_of[leaf] for leaf in leaves}
        return next((body for body in sorted(present) if present <= moved_along[body]), None)

    return tuple(carrier(leaves) for leaves in leaf_sets)


def label_edges(shape: Shape, mobility: Mobility, edges: NDArray[np.int64], body_types: dict[int, MotionType]) -> EdgeLabels:
    """Labels of edges [E, 2] from moving to reference parts (indices into `shape.parts`), from the joints of a mobility.

    `body_types` has the motion type of every movable body, by index of the body (see `motion_type`).
    """
    carriers = carriers_of(shape.leaves_below, mobility)
    types, bodies = (np.full(len(edges), value, np.int64) for value in (MotionType.NONE, -1))
    labels = EdgeLabels(types, bodies, np.zeros((len(edges), 3)), np.zeros((len(edges), 3)))
    for edge, (moving, reference) in enumerate(edges.tolist()):
        carrier, other = carriers[moving], carriers[reference]
        if carrier is None or other is None:
            continue
        body = mobility.bodies[carrier]
        if carrier == other:
            labels.types[edge] = MotionType.FIXED
        elif body.joint is not None and body.parent == other:
            labels.types[edge] = body_types[carrier]
            labels.bodies[edge] = carrier
            labels.directions[edge] = body.joint.direction
            labels.pivots[edge] = body.joint.pivot
    return labels
