"""An order of parts that is the same for all shapes: it depends neither on the file nor on who labelled it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.mobility import Body

HEIGHT_FIRST = 1.2
"""Parts count as lying side by side only where they lie this much farther apart sideways than upwards."""
FIRST = (1.0, -1.0, -1.0)
"""Along x (to the back), y (to the right) and z (up) comes first what is in front, to the left and above."""
ONE_ROW = 0.03
"""Diagonals: what lies no farther from the next along a direction is in one row across it, such as two doors above a third."""


def canonical_order(bodies: Sequence[Body], centers: NDArray[np.float64]) -> list[int]:
    """Indices of the bodies, parents first; body 0 is the base. `centers` [N, 3] are in a frame with z up and the front at -x.

    Below one body come those with equal kinds of joints and equal bodies below in a row.
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
            order += [group[row] for row in in_a_row(centers[group])]
    return order


def in_a_row(centers: NDArray[np.float64]) -> NDArray[np.intp]:
    """Order of places [N, 3], z up and the front at -x, in diagonals: from the top, from the left, from the front, along the
    direction in which they spread most; those in one row across it (`ONE_ROW`) in the order of that row.
    """
    x, y, z = np.ptp(centers, axis=0)
    sideways = (1, 0) if y >= x else (0, 1)
    axes = (2, *sideways) if HEIGHT_FIRST * z >= max(x, y) else (sideways[0], 2, sideways[1])
    orders = [np.argsort(centers[:, axis] * FIRST[axis], kind="stable") for axis in axes]
    for axis, order in zip(axes, orders, strict=True):
        rows = np.split(order, np.flatnonzero(np.abs(np.diff(centers[order, axis])) > ONE_ROW) + 1)
        if len(rows) > 1:
            return np.concatenate([row[in_a_row(centers[row])] for row in rows])
    return orders[0]
