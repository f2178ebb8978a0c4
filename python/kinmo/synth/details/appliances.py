"""Parts of kitchen appliances: a casing open to the front, a frame, feet and dials."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, Z, box, box_between, cylinder, join, open_box
from kinmo.synth.synth_object import Link, Node, hinge, slider, spinner


def appliance_casing(draw: Draw, low: np.ndarray, high: np.ndarray, wall: float) -> list[Mesh]:
    """Casing of an appliance: a box that is open to the front (+z).

    Args:
        low: Lowest corner [3].
        high: Highest corner [3].
        wall: Thickness of the walls.

    Returns:
        Five walls as one piece, as five or as one closed surface, or a solid block.
    """
    (x0, y0, z0), (x1, y1, _) = low, high
    back = box_between((x0 + wall, y0 + wall, z0), (x1 - wall, y1 - wall, z0 + wall))
    walls = [*frame_bars(low, high, wall), back]
    form = draw.pick(["joined", "pieces", "shell", "block"], [5, 3, 2, 1])
    if form == "shell":
        return [open_box(low, high, wall)]
    if form == "block":
        return [box_between(low, high)]
    return [join(*walls)] if form == "joined" else walls


def frame_bars(low: Point, high: Point, rim: float) -> list[Mesh]:
    """Four bars, `rim` wide, of a rectangular frame in the x-y plane between two corners [3]."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return [
        box_between((x0, y0, z0), (x0 + rim, y1, z1)),
        box_between((x1 - rim, y0, z0), (x1, y1, z1)),
        box_between((x0 + rim, y0, z0), (x1 - rim, y0 + rim, z1)),
        box_between((x0 + rim, y1 - rim, z0), (x1 - rim, y1, z1)),
    ]


def rectangular_frame(low: np.ndarray, high: np.ndarray, rim: float) -> Mesh:
    """A rectangular frame in the x-y plane between two corners [3], with bars `rim` wide, as one piece."""
    return join(*frame_bars(low, high, rim))


def add_feet(draw: Draw, above: Node, x: float, z: float, low: float) -> Node:
    """Add four feet below the height `low`, as base/foot_base/foot. `x` and `z` are half extents; returns the base."""
    base = above.add("base")
    group = base.add("foot_base")
    height, size = draw.between(0.015, 0.05), draw.between(0.03, 0.08)
    round_feet = draw.chance(0.5)
    for sx, sz in ((1, -1), (-1, -1), (1, 1), (-1, 1)):
        at = (sx * (x - size), low - height / 2, sz * (z - size))
        group.add("foot", cylinder(size / 2, height, "y", at, 12) if round_feet else box((size, height, size), at))
    return base


def add_dial(draw: Draw, above: Node, carrier: Link, at: tuple[float, float, float], radius: float, name: str) -> list[Link]:
    """Add a knob on a front that turns about z, mostly without limits. Some knobs are pressed in, and some do not move."""
    deep = radius * draw.ratio(0.2, 2.0)
    node = above.add(name, *dial(draw, radius, deep, at))
    kind = draw.pick(["turns", "limited", "pressed", "fixed"], [7, 2, 0.3, 1])
    if kind == "fixed":
        carrier.nodes.append(node)
        return []
    motion = {
        "turns": spinner(at, Z),
        "limited": hinge(at, Z, *draw.pick([(0.0, 90.0), (0.0, 180.0), (0.0, 270.0), (-135.0, 135.0)])),
        "pressed": slider(-Z, 0.0, 0.4 * deep),
    }[kind]
    leaf = draw.pick(["knob", "switch", "button"], [3, 2, 1]) if kind != "pressed" else "button"
    return [Link("knob", [node], carrier, motion, leaf_name=leaf)]
