"""Placement of a mechanism on an object."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.primitives import Y, scale, transform
from kinmo.synth.synth_object import Link, Motion, Node, Point

SEPARATE_LEAVES_CHANCE = 0.5
"""Chance that each piece of a moving part is a leaf, like the frame and the handle of a door."""
PIECE_NAMES = ("frame", "panel", "handle", "bar", "piece")
"""Names of such leaves."""
DOOR_NAMES, LID_NAMES = ("door", "leaf"), ("lid", "cover", "flap")
"""Names of panels with a vertical hinge, and of panels with a horizontal one."""
PANEL_NAME_CHANCE = 0.8
"""Chance that a hinged panel gets the name that fits its hinge."""
MOTION_PREFIX_CHANCE = 0.25
"""Chance that a node name states the motion, like `rotation_lid` and `translation_window` in PartNet-Mobility."""
SUFFIX_CHANCE, SUFFIXES = 0.25, ("frame", "surface", "front", "board", "body", "panel")
"""Chance that a node name ends in a word unrelated to the motion, and those words."""
DISC_NAMES = ("disc", "dial", "drum")
"""Names of wheels with a vertical axis."""


def mount(
    draw: Draw, mechanism: Mechanism, factors: float | Point, matrix: NDArray[np.float64], group: Node, base: Link
) -> list[Link]:
    """Scale a mechanism and add it to an object.

    Args:
        draw: Random values of the names.
        mechanism: The mechanism, in its unit cell.
        factors: One scale factor, or one per axis [3].
        matrix: Rigid transform [4, 4] from the scaled cell to the object.
        group: Node that the mechanism's nodes are added below.
        base: Link that carries the mechanism.

    Returns:
        One link per moving part, parents first.
    """

    def placed(pieces: Sequence[Mesh]) -> list[Mesh]:
        return [transform(scale(piece, factors), matrix) for piece in pieces]

    group = group.add("unit") if len(mechanism.moving) + bool(mechanism.fixed) > 1 else group
    if mechanism.fixed:
        base.nodes.append(group.add("mount", *placed(mechanism.fixed)))
    made: dict[MovingPart, Link] = {}
    for part in mechanism.moving:
        pieces, motion = placed(part.pieces), part.motion.scaled(factors).moved_by(matrix)
        name = _panel_name(draw, part.name, motion)
        node_name = _node_name(draw, name, motion)
        if len(pieces) > 1 and draw.chance(SEPARATE_LEAVES_CHANCE):
            node = group.add(node_name)
            for piece in pieces:
                node.add(draw.pick(PIECE_NAMES), piece)
        else:
            node = group.add(node_name, *pieces)
        holder = base if part.parent is None else made[part.parent]
        made[part] = Link(name, [node], holder, motion)
    return list(made.values())


def _panel_name(draw: Draw, name: str, motion: Motion) -> str:
    """Name of a part. Panels and wheels mostly get a name that fits the direction of their axis."""
    upright = abs(float(motion.direction @ Y)) > 0.7
    if name == "wheel" and upright:
        return draw.pick(DISC_NAMES)
    if name not in DOOR_NAMES + LID_NAMES or not motion.is_hinge or not draw.chance(PANEL_NAME_CHANCE):
        return name
    return draw.pick(DOOR_NAMES if upright else LID_NAMES)


def _node_name(draw: Draw, name: str, motion: Motion) -> str:
    """The name with additional words, like node names of real hierarchies."""
    if draw.chance(MOTION_PREFIX_CHANCE) and not motion.rotates:
        name = f"{'rotation' if motion.is_hinge else 'translation'}_{name}"
    return f"{name}_{draw.pick(SUFFIXES)}" if draw.chance(SUFFIX_CHANCE) else name
