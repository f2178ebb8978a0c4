"""Safes with a hinged door that has dials, wheels, levers, key cylinders and keypads."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.appliances import frame_bars
from kinmo.synth.details.door_locks import add_door_lock
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.details.resting_details import add_body_details, let_rest
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, box, box_between, cylinder, open_box, rotation_about, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider

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


FIXED_LOCK_SHARE = 0.08
"""Share of locks that do not move."""
RESTING_KEYS_SHARE = 0.08
"""Share of keypads whose keys do not move."""
INSET, OVERLAID = "inset", "overlaid"
"""Doors that fit into the casing's front, and doors that lie on it."""


def build(draw: Draw) -> SynthObject:
    """Safe whose door turns about a vertical edge, or rarely about its lower or upper edge.

    Variants: one door, a pair of doors, a tall cabinet, a box whose lid is on top. Locks on a door turn about its normal, and
    keys of a keypad slide in. Shelves, a drawer or a smaller door may be behind the door.
    """
    width, depth = draw.ratio(0.6, 1.5), draw.ratio(0.4, 1.4)
    height = draw.ratio(0.5, 2.2)
    wall = draw.ratio(0.02, 0.2) * min(width, height)
    front, thickness = depth / 2, draw.ratio(0.02, 0.2)
    fit = draw.pick([INSET, OVERLAID], [4, 1])
    root = Node("Safe")
    body = root.add("base_body", *_casing(draw, width, height, depth, wall, thickness if fit == INSET else 0.0))
    base = Link("base_body", [body], kind=draw.pick([JointType.HEAVY, JointType.FREE, JointType.STATIC], [6, 2, 2]))
    links = [base]
    rim = wall if fit == INSET else draw.between(0.0, 0.8) * wall
    half, tall = width / 2 - rim, height - 2 * rim
    face = front + (draw.pick([0.0, draw.between(-0.04, 0.05)]) if fit == INSET else thickness)
    if draw.chance(0.12):
        spans = [(-half, 0.0, "left"), (0.0, half, "right")]
    else:
        spans = [(-half, half, draw.pick(["left", "right", "bottom", "top"], [4, 8, 0.6, 0.4]))]
    for index, (left, right, side) in enumerate(spans):
        door = _door(draw, root, base, (left, right, tall), face, thickness, side)
        links.append(door)
        if index == 0 or draw.chance(0.5):
            middle = 0.5 * (left + right)
            towards = {"left": -1.0, "right": 1.0}.get(side, 0.0)
            _locks(draw, root, links, door, middle, towards, right - left, tall, face)
    if draw.chance(0.2):
        links += _inside(draw, root, base, half, tall, front - thickness, depth - wall - thickness)
    if draw.chance(0.3):
        base.nodes += add_body_details(draw, root, (-width / 2, -height / 2, -front), (width / 2, height / 2, front))
    shape = SynthObject("Safe", root, links)
    if height < width and draw.chance(0.15):
        # The door is on top: a cash box or a floor safe.
        shape.move(rotation_about(X, -90.0))
    return shape


def _door(
    draw: Draw, root: Node, base: Link, span: tuple[float, float, float], face: float, thickness: float, side: str
) -> Link:
    """A door from `span`'s left to its right edge, as high as its last value, with its hinge at one edge."""
    left, right, tall = span
    wide, middle = right - left, 0.5 * (left + right)
    center = (middle, 0, face - thickness / 2)
    slab = rounded_box((wide, tall, thickness), draw.between(0.02, 0.15) * wide, "z", center) if draw.chance(0.2) else None
    node = root.add("door", slab or box((wide, tall, thickness), center))
    out = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "bottom": (0.0, -1.0), "top": (0.0, 1.0)}[side]
    upright = out[0] != 0.0
    if draw.chance(0.2):
        node.pieces.append(box((0.8 * wide, 0.85 * tall, 0.3 * thickness), (middle, 0, face + 0.1 * thickness)))
    if draw.chance(0.3) and upright:
        node.pieces += [
            cylinder(0.02, 0.08, "x", (middle - out[0] * (wide / 2 + 0.02), y * tall, face - thickness * 0.6))
            for y in (-0.25, 0.0, 0.25)
        ]
    if draw.chance(0.2) and upright:
        # Bolts stand out of the edge opposite to the hinge.
        bolt, reach = 0.3 * min(thickness, 0.1), draw.between(0.01, 0.05)
        edge = middle - out[0] * (0.5 * wide + 0.5 * reach)
        levels = np.linspace(-0.35, 0.35, draw.integer(2, 5)) * tall
        bolts = [cylinder(bolt, reach, "x", (edge, level, face - 0.5 * thickness), 10) for level in levels]
        node.pieces += bolts
    inward = draw.between(0.0, 0.04)
    deep = face - draw.pick([0.0, inward, thickness])
    at = (middle + out[0] * (wide / 2 - inward), out[1] * (tall / 2 - inward), deep)
    opens = draw.pick([90.0, 120.0, 160.0, 170.0, 180.0], [1, 1, 2, 4, 1]) if upright else draw.pick([90.0, 110.0])
    rest = draw.between(20, min(opens, 110)) if draw.chance(0.33) else 0.0
    axis = (0.0, out[0], 0.0) if upright else (-out[1], 0.0, 0.0)
    if draw.chance(0.5) and upright:
        size = draw.ratio(0.01, 0.04)
        barrels = [cylinder(size, draw.between(0.08, 0.2) * tall, "y", (at[0], y * tall, face), 12) for y in (-0.3, 0.3)]
        if draw.chance(0.6):
            base.nodes[0].pieces += barrels
        else:
            base.nodes.append(root.add("hinge", *barrels))
    corners = (left, -0.5 * tall), (right, 0.5 * tall)
    fittings = add_fittings(draw, root, *corners, face, side)
    return Link("door", [node, *fittings], base, hinge(at, axis, 0, opens, rest=rest))


def _inside(draw: Draw, root: Node, base: Link, half: float, tall: float, front: float, depth: float) -> list[Link]:
    """Shelves, a drawer that slides out, or a small door behind the door."""
    kind = draw.pick(["shelf", "drawer", "door"])
    deep, level = 0.85 * depth, draw.between(-0.3, 0.2) * tall
    if kind == "drawer":
        size = draw.between(0.1, 0.3) * tall
        tray = root.add("drawer", box((1.8 * half, size, deep), (0, level, front - 0.03 - 0.5 * deep)))
        return [Link("drawer", [tray], base, slider((0, 0, 1), 0, draw.between(0.4, 0.8) * deep))]
    shelf = root.add("shelf", box((1.9 * half, 0.03, deep), (0, level, front - 0.03 - 0.5 * deep)))
    base.nodes.append(shelf)
    if kind == "shelf":
        return []
    high = 0.5 * tall - level - 0.03
    leaf = root.add("inner_door", box((1.9 * half, high, 0.02), (0, level + 0.5 * high + 0.015, front - 0.05)))
    side = draw.sign()
    return [Link("door", [leaf], base, hinge((side * 0.95 * half, 0, front - 0.04), (0, side, 0), 0, 90.0))]


def _casing(draw: Draw, width: float, height: float, depth: float, wall: float, recess: float) -> list[Mesh]:
    """Five walls of a box open to the front. The back may be a solid block behind the door."""
    x, y, z = width / 2, height / 2, depth / 2
    if draw.chance(0.15):
        return [open_box((-x, -y, -z), (x, y, z), wall)]
    walls = frame_bars(np.array([-x, -y, -z]), np.array([x, y, z]), wall)
    if draw.chance(0.3):
        back = box_between((-x + wall, -y + wall, -z), (x - wall, y - wall, z - recess))
    else:
        back = box_between((-x + wall, -y + wall, -z), (x - wall, y - wall, -z + wall))
    pieces = [*walls, back]
    if draw.chance(0.4):
        pieces += [box((0.12, 0.06, 0.12), (sx * (x - 0.1), -y - 0.03, sz * (z - 0.1))) for sx in (-1, 1) for sz in (-1, 1)]
    return pieces


def _locks(
    draw: Draw,
    root: Node,
    links: list[Link],
    door: Link,
    center: float,
    side: float,
    width: float,
    height: float,
    face: float,
) -> None:
    """Add dials, wheels, levers, key cylinders, a keypad or a fixed grip to a door about x = `center`, in any arrangement.

    `side` is 1 or -1 for a hinge at the right or left edge, and 0 for another one.
    """
    kinds = draw.pick(_HARDWARE, [3, 2, 3, 3, 2, 3, 3, 2, 2, 2, 2, 1])
    layout = draw.pick(["column", "row", "loose"], [4, 3, 2])
    middle = center - side * draw.between(0.0, 0.3) * width
    for index, kind in enumerate(kinds):
        share = (index + 0.5) / len(kinds) - 0.5
        x, y = middle, draw.between(-0.08, 0.08) * height
        if layout == "column":
            y -= share * draw.between(0.4, 0.7) * height
        elif layout == "row":
            x = center - (side or 1.0) * share * 0.75 * width
        else:
            x, y = center - (side or 1.0) * draw.between(-0.2, 0.4) * width, draw.between(-0.35, 0.35) * height
        if kind == "keypad":
            foot, pad = (x, y, face), (draw.between(0.25, 0.45) * width, draw.between(0.22, 0.4) * height)
            if draw.chance(0.3):
                # A display above the keys.
                shown = box((pad[0], 0.25 * pad[1], 0.01), (x, y + 0.75 * pad[1], face))
                door.nodes.append(root.add(draw.pick(["screen", "other_leaf"]), shown))
            if draw.chance(0.3):
                plate = box((1.2 * pad[0], 1.2 * pad[1], 0.03), (x, y, face + 0.015))
                door.nodes.append(root.add("frame", plate))
                foot = (x, y, face + 0.03)
            keys = add_keypad(draw, root, door, foot, pad, "button", lookalikes=False)
            if draw.chance(RESTING_KEYS_SHARE):
                let_rest(keys, door)
            else:
                links += keys
        elif kind == "grip":
            long = draw.between(0.1, 0.35) * height
            grip = pull(draw, long, (x, y, face), vertical=draw.chance(0.7), room=0.3 * min(width, height))
            door.nodes.append(root.add("handle", *grip))
        else:
            low, high = _SIZES[kind]
            size = min(draw.ratio(low, high), 0.7 * min(width, height))
            lock = add_door_lock(draw, root, door, kind, (x, y, face), size)
            if draw.chance(FIXED_LOCK_SHARE):
                door.nodes += lock.nodes
            else:
                links.append(lock)
