"""Putting a mechanism on what it belongs to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.model import Mechanism, Moving
from kinmo.synth.model import Link, Motion, Node, Point
from kinmo.synth.primitives import Y, scale, transform

LEAVES = 0.5
"""Chance that the pieces of a moving part are leaves of their own, as the frame and the handle of a door are."""
PIECES = ("frame", "panel", "handle", "bar", "piece")
DOORS, LIDS = ("door", "leaf"), ("lid", "cover", "flap")
"""What panels are called whose hinge is upright, and those whose hinge is level."""
CALLED_SO = 0.8
"""Chance that such a panel has one of those names."""
TOLD = 0.25
"""Chance that the name of a node says how it moves, as `rotation_lid` and `translation_window` of PartNet-Mobility do."""
ADDED, WORDS = 0.25, ("frame", "surface", "front", "board", "body", "panel")
"""Chance that the name ends in a word that says nothing of it."""
LYING_WHEELS = ("disc", "dial", "drum")
"""What is not called a wheel, since its line is upright."""


def mount(
    draw: Draw, mechanism: Mechanism, factors: float | Point, matrix: NDArray[np.float64], group: Node, base: Link
) -> list[Link]:
    """Scale a mechanism, place it by `matrix` [4, 4] on `base`, add its nodes below `group`, and return its links."""

    def placed(pieces: Sequence[Mesh]) -> list[Mesh]:
        return [transform(scale(piece, factors), matrix) for piece in pieces]

    group = group.add("unit") if len(mechanism.moving) + bool(mechanism.fixed) > 1 else group
    if mechanism.fixed:
        base.nodes.append(group.add("mount", *placed(mechanism.fixed)))
    made: dict[Moving, Link] = {}
    for part in mechanism.moving:
        pieces, motion = placed(part.pieces), part.motion.scaled(factors).moved_by(matrix)
        name = _called(draw, part.name, motion)
        node_name = _detailed(draw, name, motion)
        if len(pieces) > 1 and draw.chance(LEAVES):
            node = group.add(node_name)
            for piece in pieces:
                node.add(draw.pick(PIECES), piece)
        else:
            node = group.add(node_name, *pieces)
        holder = base if part.on is None else made[part.on]
        made[part] = Link(name, [node], holder, motion)
    return list(made.values())


def _called(draw: Draw, name: str, motion: Motion) -> str:
    """The name, or for a panel and a wheel mostly one that tells how its line lies."""
    upright = abs(float(motion.direction @ Y)) > 0.7
    if name == "wheel" and upright:
        return draw.pick(LYING_WHEELS)
    if name not in DOORS + LIDS or not motion.is_hinge or not draw.chance(CALLED_SO):
        return name
    return draw.pick(DOORS if upright else LIDS)


def _detailed(draw: Draw, name: str, motion: Motion) -> str:
    """The name with more words, as nodes of a hierarchy have them."""
    if draw.chance(TOLD) and not motion.rotates:
        name = f"{'rotation' if motion.is_hinge else 'translation'}_{name}"
    return f"{name}_{draw.pick(WORDS)}" if draw.chance(ADDED) else name
