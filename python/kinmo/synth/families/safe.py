"""Safes with a hinged door that has dials, wheels, levers, key cylinders and keypads."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.appliances import frame_bars
from kinmo.synth.details.door_locks import add_door_lock
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, box_between, cylinder
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge

_HARDWARE = [
    ["wheel"],
    ["dial"],
    ["lever"],
    ["wheel", "dial"],
    ["wheel", "cylinder"],
    ["lever", "dial"],
    ["lever", "keypad"],
    ["keypad", "dial"],
    ["keypad", "cylinder", "grip"],
    ["tee", "keypad"],
    ["lever", "cover", "cylinder"],
    ["grip"],
]
"""Sets of hardware on a door."""
_SIZES = {
    "dial": (0.06, 0.2),
    "wheel": (0.16, 0.55),
    "lever": (0.1, 0.3),
    "tee": (0.1, 0.28),
    "cylinder": (0.05, 0.12),
    "cover": (0.05, 0.12),
}
"""Range of the size of each kind."""


def build(draw: Draw) -> SynthObject:
    """Safe whose door turns about a vertical edge.

    Locks on the door turn about its normal, and keys of a keypad slide in.
    """
    width, height, depth = draw.between(0.8, 1.3), draw.between(0.8, 1.7), draw.between(0.7, 1.2)
    wall = draw.between(0.04, 0.14)
    front, thickness = depth / 2, draw.between(0.03, 0.15)
    root = Node("Safe")
    body = root.add("base_body", *_casing(draw, width, height, depth, wall, thickness))
    base = Link("base_body", [body], kind=draw.pick([JointType.HEAVY, JointType.FREE, JointType.STATIC], [6, 2, 2]))

    side = draw.pick([-1.0, 1.0], [1, 4])
    door_width, door_height = width - 2 * wall, height - 2 * wall
    proud = draw.pick([0.0, draw.between(0.0, 0.05)])
    face = front + proud
    door_node = root.add("door", box((door_width, door_height, thickness), (0, 0, face - thickness / 2)))
    if draw.chance(0.3):
        bolts = [
            cylinder(0.02, 0.08, "x", (-side * (door_width / 2 + 0.02), y, face - thickness * 0.6)) for y in (-0.2, 0.0, 0.2)
        ]
        door_node.pieces += bolts
    inward = draw.between(0.0, 0.04)
    axis = (side * (door_width / 2 - inward), draw.pick([0.0, height / 2 - wall]), face - draw.pick([0.0, inward, thickness]))
    opening = draw.pick([90.0, 120.0, 160.0, 170.0, 180.0], [1, 1, 2, 4, 1])
    rest = draw.between(20, min(opening, 110)) if draw.chance(0.33) else 0.0
    door = Link("door", [door_node], base, hinge(axis, (0, side, 0), 0, opening, rest=rest))
    if draw.chance(0.5):
        hinges = [cylinder(0.02, 0.12 * height, "y", (axis[0], y * height, front), 12) for y in (-0.3, 0.3)]
        if draw.chance(0.6):
            body.pieces += hinges
        else:
            base.nodes.append(root.add("hinge", *hinges))

    links = [base, door]
    _locks(draw, root, links, side, door_width, door_height, face)
    return SynthObject("Safe", root, links)


def _casing(draw: Draw, width: float, height: float, depth: float, wall: float, recess: float) -> list[Mesh]:
    """Five walls of a box open to the front. The back may be a solid block behind the door."""
    x, y, z = width / 2, height / 2, depth / 2
    walls = frame_bars(np.array([-x, -y, -z]), np.array([x, y, z]), wall)
    if draw.chance(0.3):
        back = box_between((-x + wall, -y + wall, -z), (x - wall, y - wall, z - recess))
    else:
        back = box_between((-x + wall, -y + wall, -z), (x - wall, y - wall, -z + wall))
    pieces = [*walls, back]
    if draw.chance(0.4):
        pieces += [box((0.12, 0.06, 0.12), (sx * (x - 0.1), -y - 0.03, sz * (z - 0.1))) for sx in (-1, 1) for sz in (-1, 1)]
    return pieces


def _locks(draw: Draw, root: Node, links: list[Link], side: float, width: float, height: float, face: float) -> None:
    """Add dials, wheels, levers, key cylinders, a keypad or a fixed grip to the door, in any arrangement."""
    door = links[1]
    kinds = draw.pick(_HARDWARE, [3, 2, 3, 3, 2, 3, 3, 2, 2, 2, 2, 1])
    layout = draw.pick(["column", "row", "loose"], [4, 3, 2])
    middle = -side * draw.between(0.0, 0.3) * width
    for index, kind in enumerate(kinds):
        share = (index + 0.5) / len(kinds) - 0.5
        x, y = middle, draw.between(-0.08, 0.08) * height
        if layout == "column":
            y -= share * draw.between(0.4, 0.7) * height
        elif layout == "row":
            x = -side * share * 0.75 * width
        else:
            x, y = -side * draw.between(-0.2, 0.4) * width, draw.between(-0.35, 0.35) * height
        if kind == "keypad":
            center, pad = (x, y, face), (draw.between(0.25, 0.45) * width, draw.between(0.22, 0.4) * height)
            if draw.chance(0.3):
                plate = box((1.2 * pad[0], 1.2 * pad[1], 0.03), (x, y, face + 0.015))
                door.nodes.append(root.add("frame", plate))
                center = (x, y, face + 0.03)
            links += add_keypad(draw, root, door, center, pad, "button", lookalikes=False)
        elif kind == "grip":
            grip = pull(draw, draw.between(0.1, 0.35) * height, (x, y, face), vertical=draw.chance(0.7))
            door.nodes.append(root.add("handle", *grip))
        else:
            low, high = _SIZES[kind]
            links.append(add_door_lock(draw, root, door, kind, (x, y, face), draw.between(low, high)))
