"""Putting a mechanism on what it belongs to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.synth.mechanisms.model import Mechanism, Moving
from kinmo.synth.model import Link, Node, Point
from kinmo.synth.primitives import scale, transform


def mount(mechanism: Mechanism, factors: float | Point, matrix: NDArray[np.float64], group: Node, base: Link) -> list[Link]:
    """Scale a mechanism, place it by `matrix` [4, 4] on `base`, add its nodes below `group`, and return its links."""
    group = group.add("unit") if len(mechanism.moving) + bool(mechanism.fixed) > 1 else group
    if mechanism.fixed:
        pieces = [transform(scale(piece, factors), matrix) for piece in mechanism.fixed]
        base.nodes.append(group.add("mount", *pieces))
    made: dict[Moving, Link] = {}
    for part in mechanism.moving:
        node = group.add(part.name, *(transform(scale(piece, factors), matrix) for piece in part.pieces))
        holder = base if part.on is None else made[part.on]
        made[part] = Link(part.name, [node], holder, part.motion.scaled(factors).moved_by(matrix))
    return list(made.values())
