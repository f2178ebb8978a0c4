"""What the edges of a hierarchy should say, from an annotated mobility (paper, section 3.1).

A part moves as its *carrier*: the body that the whole part goes along with. An edge i -> j then says how i moves against j: by
the joint of i's carrier if j's carrier is the body that the joint is attached to, FIXED if both have the same carrier, NONE
otherwise. Stated so, a label depends on the tree alone, and never on the order in which a file lists children.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.box import Box
from kinmo.core.joint import Joint, JointKind, MotionType
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.vector import Vector


def distance_to_line(points: NDArray[np.float64], pivot: Vector, direction: Vector) -> NDArray[np.float64]:
    """Distance [N] of points [N, 3] from the line through `pivot` along the unit vector `direction`."""
    offsets = points - pivot
    along = offsets @ direction
    squared: NDArray[np.float64] = np.sum(offsets * offsets, axis=-1) - along * along
    return np.sqrt(np.maximum(squared, 0.0))


def motion_type(joint: Joint, box: Box, up: Vector) -> MotionType:
    """The fine motion type of `joint` for a moving part with the oriented box `box`, all in one frame.

    H or V by the angle to `up`; C if the box's centre is nearer to the axis than every corner is, S otherwise.
    """
    orientation = "V" if joint.is_vertical(up) else "H"
    if joint.kind is not JointKind.REVOLUTE:
        return MotionType[f"{joint.kind.value}_{orientation}"]
    places = np.vstack([box.corners(), box.center])
    nearest = int(np.argmin(distance_to_line(places, joint.pivot, joint.direction)))
    return MotionType[f"R_{orientation}_{'C' if nearest == 8 else 'S'}"]


def sibling_edges(shape: Shape) -> NDArray[np.int64]:
    """All ordered pairs [E, 2] of parts with the same parent, as indices into `shape.parts`."""
    pairs = [(i, j) for part in shape.parts for i in part.children for j in part.children if i != j]
    return np.array(pairs, np.int64).reshape(-1, 2)


def carriers_of(leaf_sets: Sequence[Sequence[int]], mobility: Mobility) -> tuple[int | None, ...]:
    """For every set of leaves, the index of the body it goes along with; None if it spans bodies that do not hang together."""
    body_of = {leaf: index for index, body in enumerate(mobility.bodies) for leaf in body.leaves}
    along = [set(mobility.descendants(index)) for index in range(len(mobility.bodies))]

    def carrier(leaves: Sequence[int]) -> int | None:
        present = {body_of[leaf] for leaf in leaves}
        return next((body for body in sorted(present) if present <= along[body]), None)

    return tuple(carrier(leaves) for leaves in leaf_sets)


@dataclass(frozen=True, eq=False)
class EdgeLabels:
    """One label an edge.

    `types` [E] int64 (MotionType), `bodies` [E] int64 (the moving body of a motion edge, else -1), `directions` and `pivots`
    [E, 3] float64 in the frame and lengths of the shape (zero where there is no motion).
    """

    types: NDArray[np.int64]
    bodies: NDArray[np.int64]
    directions: NDArray[np.float64]
    pivots: NDArray[np.float64]


def label_edges(shape: Shape, mobility: Mobility, edges: NDArray[np.int64], body_types: dict[int, MotionType]) -> EdgeLabels:
    """Labels of `edges` [E, 2]; `body_types` holds the motion type of every movable body (`motion_type`)."""
    carried_by = carriers_of(shape.leaves_below, mobility)
    count = len(edges)
    labels = EdgeLabels(
        np.full(count, MotionType.NONE, np.int64), np.full(count, -1, np.int64), np.zeros((count, 3)), np.zeros((count, 3))
    )
    for edge, (moving, reference) in enumerate(edges.tolist()):
        carrier, other = carried_by[moving], carried_by[reference]
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
