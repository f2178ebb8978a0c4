"""An order of parts that is the same for all shapes: it depends neither on the file nor on who labelled it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.mobility import Body

HEIGHT_FIRST = 1.2
"""Parts count as lying side by side only where they lie this much farther apart sideways than upwards."""


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
    """Order of places [N, 3], z up and the front at -x, along the direction in which they spread most: from the top, from the
    left, from the front.
    """
    x, y, z = np.ptp(centers, axis=0)
    along = -centers[:, 2] if HEIGHT_FIRST * z >= max(x, y) else -centers[:, 1] if y >= x else centers[:, 0]
    return np.argsort(along, kind="stable")
