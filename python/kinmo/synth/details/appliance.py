"""What kitchen appliances share: a housing open to the front, a door with a window, a control panel, feet."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import dial
from kinmo.synth.draw import Draw
from kinmo.synth.model import Link, Motion, Node, spinner
from kinmo.synth.primitives import box, box_between, cylinder, join


def housing(draw: Draw, low: np.ndarray, high: np.ndarray, wall: float) -> list[Mesh]:
    """A box between two corners that is open to the front (+z): five walls as one piece or five, or a solid block."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    walls = [
        box_between((x0, y0, z0), (x0 + wall, y1, z1)),
        box_between((x1 - wall, y0, z0), (x1, y1, z1)),
        box_between((x0 + wall, y0, z0), (x1 - wall, y0 + wall, z1)),
        box_between((x0 + wall, y1 - wall, z0), (x1 - wall, y1, z1)),
        box_between((x0 + wall, y0 + wall, z0), (x1 - wall, y1 - wall, z0 + wall)),
    ]
    form = draw.pick(["joined", "pieces", "block"], [6, 3, 1])
    if form == "block":
        return [box_between(low, high)]
    return [join(*walls)] if form == "joined" else walls


def frame(low: np.ndarray, high: np.ndarray, rim: float) -> Mesh:
    """A rectangular frame in the x-y plane between two corners, with bars `rim` wide."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return join(
        box_between((x0, y0, z0), (x0 + rim, y1, z1)),
        box_between((x1 - rim, y0, z0), (x1, y1, z1)),
        box_between((x0 + rim, y0, z0), (x1 - rim, y0 + rim, z1)),
        box_between((x0 + rim, y1 - rim, z0), (x1 - rim, y1, z1)),
    )


def add_feet(draw: Draw, above: Node, x: float, z: float, low: float) -> Node:
    """Four feet that end at height `low` (below it is the floor), as base/foot_base/foot."""
    base = above.add("base")
    group = base.add("foot_base")
    height, size = draw.between(0.015, 0.05), draw.between(0.03, 0.08)
    round_feet = draw.chance(0.5)
    for sx, sz in ((1, -1), (-1, -1), (1, 1), (-1, 1)):
        at = (sx * (x - size), low - height / 2, sz * (z - size))
        group.add("foot", cylinder(size / 2, height, "y", at, 12) if round_feet else box((size, height, size), at))
    return base


def add_dial(draw: Draw, above: Node, carrier: Link, at: tuple[float, float, float], radius: float, name: str) -> Link:
    """A knob on a front that turns about z, mostly without limits."""
    node = above.add(name, *dial(draw, radius, radius * draw.between(0.25, 1.5), at))
    motion = spinner(at, (0, 0, 1))
    if draw.chance(0.2):
        motion = Motion(motion.joint, motion.origin, motion.direction, 0.0, draw.pick([90.0, 180.0, 270.0]))
    return Link("knob", [node], carrier, motion, lumped_name=draw.pick(["knob", "switch", "button"], [3, 2, 1]))
