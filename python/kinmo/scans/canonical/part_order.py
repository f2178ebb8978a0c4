"""Canonical order of parts: the same for all objects of a category, whatever the file and its labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.mobility import Body

HEIGHT_WEIGHT = 1.2
"""Weight of the vertical spread against the horizontal one: rows are side by side only if they spread clearly sideways."""
SIGNS = (1.0, -1.0, -1.0)
"""Sort direction along x (to the back), y (to the right) and z (up): front, left and top come first."""
ROW_GAP = 0.03
"""Largest gap between neighbours of one row across a direction, diagonals; for example, two doors above a third."""


def canonical_order(bodies: Sequence[Body], centers: NDArray[np.float64]) -> list[int]:
    """Indices of an object's bodies in canonical order, parents first; body 0 is the base.

    Siblings are grouped by joint kind and by the subtree below them. `spatial_order` of the box centers [N, 3] orders each
    group.
    """
    below: list[list[int]] = [[i for i, body in enumerate(bodies) if body.parent == index] for index in range(len(bodies))]

    def form(index: int) -> tuple[object, ...]:
        joint = bodies[index].joint
        return ("" if joint is None else joint.kind.value, tuple(sorted(map(form, below[index]), key=repr)))

    order = [0]
    for index in order:
        groups: dict[str, list[int]] = {}
        for child in below[index]:
            groups.setdefault(repr(form(child)), []).append(child)
        for _, group in sorted(groups.items()):
            order += [group[row] for row in spatial_order(centers[group])]
    return order


def spatial_order(centers: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of positions from the top, from the left or from the front, along the direction of largest spread.

    Positions in one row across that direction (`ROW_GAP`) are ordered within the row. Positions [N, 3] are in diagonals, in a
    frame with z up and the front at -x.
    """
    x, y, z = np.ptp(centers, axis=0)
    sideways = (1, 0) if y >= x else (0, 1)
    axes = (2, *sideways) if HEIGHT_WEIGHT * z >= max(x, y) else (sideways[0], 2, sideways[1])
    orders = [np.argsort(centers[:, axis] * SIGNS[axis], kind="stable") for axis in axes]
    for axis, order in zip(axes, orders, strict=True):
        rows = np.split(order, np.flatnonzero(np.abs(np.diff(centers[order, axis])) > ROW_GAP) + 1)
        if len(rows) > 1:
            return np.concatenate([row[spatial_order(centers[row])] for row in rows])
    return orders[0]


def reordered(bodies: Sequence[Body], order: Sequence[int]) -> tuple[Body, ...]:
    """Bodies in a new order, which their ids and parents follow. The children of a dropped body move to the new first one."""
    place: dict[int | None, int | None] = {index: position for position, index in enumerate(order)}
    place[None] = None
    return tuple(replace(bodies[i], id=new, parent=place.get(bodies[i].parent, 0)) for new, i in enumerate(order))
