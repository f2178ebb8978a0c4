"""Dishwashers with a door that folds down, controls and racks."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.appliances import add_dial, add_feet, appliance_casing
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.details.resting_details import add_body_details
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, box_between, cylinder, join, sheet, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Dishwasher with a door hinged at its lower edge, or one or two drawers.

    Racks slide out or are fixed; buttons slide and dials turn.
    """
    width, height, depth = draw.ratio(0.6, 1.5), draw.ratio(0.6, 1.7), draw.ratio(0.6, 1.3)
    x, y, z = width / 2, height / 2, depth / 2
    wall = draw.between(0.02, 0.06)
    root = Node("dishwasher")
    body = root.add("body")
    casing = body.add("frame", *appliance_casing(draw, np.array([-x, -y, -z]), np.array([x, y, z]), wall))
    base = Link("frame", [casing], kind=draw.pick([JointType.HEAVY, JointType.FREE], [8, 1]))
    links = [base]
    strip = draw.pick([0.0, draw.ratio(0.05, 0.2) * height], [1, 3])
    kick = draw.pick([0.0, draw.ratio(0.03, 0.2) * height], [1, 3])
    low, high = -y + kick, y - strip
    drawers = draw.pick([0, 1, 2], [9, 1, 1])
    edges = [low, low + draw.between(0.4, 0.6) * (high - low), high] if drawers == 2 else [low, high]
    for bottom, ceiling in pairwise(edges):
        door = _door(draw, body, base, (x, bottom, ceiling), z, wall)
        if drawers:
            _make_drawer(draw, door, (x - wall, bottom, ceiling), z, depth)
        links.append(door)
    if strip:
        links += _controls(draw, body, base, x, y - strip / 2, strip, z)
    if draw.chance(0.55):
        opened = links[1].motion is not None and links[1].motion.rest > 60.0
        links += _racks(draw, body, base, x - wall, y, depth, may_be_out=opened)
    if kick and draw.chance(0.7):
        surface = box_between((-x, -y - 0.02, -z), (x, -y + kick, z - draw.between(0.02, 0.1)))
        base.nodes.append(root.add("base").add("surface_base").add("surface", surface))
    elif draw.chance(0.5):
        base.nodes.append(add_feet(draw, root, x, z, -y))
    if draw.chance(0.2):
        base.nodes += add_body_details(draw, root, (-x, -y, -z), (x, y, z))
    return SynthObject("Dishwasher", root, links)


def _door(draw: Draw, body: Node, base: Link, extent: tuple[float, float, float], z: float, wall: float) -> Link:
    """The door between the heights `extent[1:]`, as wide as the body, hinged near its lower edge."""
    x, low, high = extent
    node = body.add("door")
    thickness = draw.ratio(0.02, 0.15)
    back = z - draw.pick([0.0, 0.5, 1.0], [4, 3, 1]) * thickness
    inset = draw.pick([0.0, wall, 0.01])
    panel: list[Mesh] = [box_between((-x + inset, low, back), (x - inset, high, back + thickness))]
    if draw.chance(0.3):
        panel.append(box_between((-x + 2 * wall, low + 0.05, back - 0.03), (x - 2 * wall, high - 0.05, back)))
    node.add("door_frame", *panel)
    if draw.chance(0.8):
        top = high - draw.between(0.03, 0.25) * (high - low)
        length = 2 * x * draw.ratio(0.15, 0.98)
        thick, reach = draw.ratio(0.012, 0.07), draw.ratio(0.03, 0.12)
        foot, room = (0, top, back + thickness), 0.4 * (high - low)
        node.add("handle", *pull(draw, length, foot, vertical=False, thickness=thick, reach=reach, room=room))
    if draw.chance(0.15):
        # The dispenser for powder, inside the door.
        at = (draw.between(-0.4, 0.4) * x, 0.5 * (low + high), back - 0.01)
        lid = cylinder(0.08 * x, 0.02, "z", (at[0] + 0.35 * x, *at[1:]), 16)
        node.add("other_leaf", box((0.4 * x, 0.3 * x, 0.02), at), lid)
    if draw.chance(0.15):
        size = (1.4 * x, 0.6 * (high - low))
        node.add("glass", sheet(size, (0, 0.5 * (low + high), back + thickness + 0.002), "z"))
    add_fittings(draw, node, (inset - x, low), (x - inset, high), back + thickness, "bottom")
    axis = (0, low + draw.pick([0.0, draw.between(0.0, 0.06)]), back + thickness * draw.pick([0.0, 0.3, 0.6]))
    rest = draw.pick([90.0, draw.between(15, 85)]) if draw.chance(0.25) else 0.0
    return Link("door", [node], base, hinge(axis, (1, 0, 0), 0, 90, rest=rest))


def _make_drawer(draw: Draw, door: Link, extent: tuple[float, float, float], z: float, depth: float) -> None:
    """Make the door the front of a drawer, with the tub behind it."""
    x, low, high = extent
    if draw.chance(0.8):
        wall, far, rim = 0.02, z - draw.between(0.6, 0.9) * depth, low + draw.between(0.4, 0.9) * (high - low)
        tub = [box_between((-x, low, far), (x, low + wall, z)), box_between((-x, low, far), (x, rim, far + wall))]
        tub += [box_between((s * x - 0.5 * wall, low, far), (s * x + 0.5 * wall, rim, z)) for s in (-0.95, 0.95)]
        door.nodes[0].add("other").add("other_leaf", *tub)
    travel = draw.between(0.4, 0.85) * depth
    rest = travel * draw.pick([0.0, draw.between(0.2, 0.95)])
    door.motion = slider((0, 0, 1), 0, travel, rest=rest)


def _controls(draw: Draw, body: Node, base: Link, x: float, y: float, height: float, z: float) -> list[Link]:
    """A panel above the door with a display, and buttons, a dial or a keypad."""
    panel = body.add("side_controls")
    front = z + draw.between(0.0, 0.04)
    plate = box_between((-x, y - height / 2, z - 0.02), (x, y + height / 2, front)) if draw.chance(0.7) else None
    base.nodes.append(panel.add("control_panel", plate or sheet((2 * x, height), (0, y, front), "z")))
    links: list[Link] = []
    if draw.chance(0.5):
        base.nodes.append(panel.add("display_panel", box((0.6 * x, 0.5 * height, 0.006), (0, y, front + 0.003))))
    kind = draw.pick(["row", "dial", "keypad", "none"], [4, 2, 2, 2])
    side = draw.sign()
    if kind == "row":
        count, radius = draw.integer(1, 6), draw.between(0.15, 0.3) * height
        travel = draw.between(0.01, 0.04)
        for index in range(count):
            at = (side * (0.85 * x - 2.6 * index * radius), y, front + travel / 2)
            knob = cylinder(radius, travel, "z", at, 16) if draw.chance(0.6) else box((1.6 * radius, radius, travel), at)
            node = panel.add("control_button", knob)
            links.append(Link("control_button", [node], base, slider((0, 0, -1), 0, travel), leaf_name="button"))
    elif kind == "dial":
        links += add_dial(draw, panel, base, (side * 0.7 * x, y, front), 0.35 * height, "control_button")
    elif kind == "keypad":
        pad = (0.5 * x, 0.7 * height)
        links += add_keypad(draw, panel, base, (side * 0.65 * x, y, front), pad, "control_button")
    return links


def _racks(draw: Draw, body: Node, base: Link, x: float, y: float, depth: float, *, may_be_out: bool) -> list[Link]:
    """Wire baskets, trays or tubs that slide out on rails, or are fixed where nobody annotated that.

    Wheels and cutlery baskets move with their rack and have no joint of their own.
    """
    inside, links, sliding = body.add("body_interior"), [], draw.chance(0.6)
    for level in draw.pick([[-0.5], [0.2], [-0.5, 0.2], [-0.5, 0.1, 0.6]], [1, 1, 3, 1]):
        half, tall = np.array([draw.between(0.8, 0.93) * x, 0.4 * depth]), draw.ratio(0.05, 0.35) * y
        low, rim = level * y, draw.between(0.006, 0.014)
        form = draw.pick(["wires", "tub", "tray", "grid"], [5, 2, 1, 2])
        pieces = _basket(draw, form, half, low, tall, rim)
        if draw.chance(0.4):
            # Wheels at the sides, on the rails.
            radius, count = 0.25 * min(tall, 0.1), draw.pick([2, 3])
            places = np.linspace(-0.8, 0.8, count) * half[1]
            pieces += [cylinder(radius, rim, "x", (s * (half[0] + rim), low, z), 12) for s in (-1, 1) for z in places]
        if draw.chance(0.25):
            size = half * (draw.between(0.1, 0.3), draw.between(0.2, 0.5))
            at = (draw.between(-0.6, 0.6) * half[0], low + rim, draw.between(-0.4, 0.4) * half[1])
            pieces.append(box((2 * size[0], tall, 2 * size[1]), (at[0], at[1] + tall / 2, at[2])))
        if draw.chance(0.4):
            rails = [box((0.5 * rim, 2 * rim, 2 * half[1]), (s * (x - 0.3 * rim), low - 2 * rim, 0)) for s in (-1, 1)]
            base.nodes.append(inside.add(draw.pick(["rail", "other_leaf"]), *rails))
        node = inside.add("shelf", *(pieces if draw.chance(0.4) else [join(*pieces)]))
        if draw.chance(0.2):
            # Spray arms hang below racks.
            at, long = (0, low - 3 * rim, 0), 0.6 * float(half.min())
            arm = turn(box((2 * long, 2 * rim, 0.2 * long), at), (0, 1, 0), draw.between(0.0, 90.0))
            base.nodes.append(inside.add("other_leaf", arm, cylinder(0.15 * long, 3 * rim, "y", at, 12)))
        if sliding:
            travel = draw.between(0.4, 0.85) * depth
            out = draw.between(0.2, 0.9) if may_be_out and draw.chance(0.4) else 0.0
            motion = slider((0, 0, 1), 0, travel, rest=out * travel)
            links.append(Link("shelf", [node], base, motion, leaf_name="translation_tray"))
        else:
            base.nodes.append(node)
    return links


def _basket(draw: Draw, form: str, half: np.ndarray, low: float, tall: float, rim: float) -> list[Mesh]:
    """Meshes of a rack of half extents `half` (x, z) above the height `low`: "wires", "grid", "tub" or "tray"."""
    (x, z), high = half, low + tall
    if form == "tray":
        return [box((2 * x, rim, 2 * z), (0, low, 0)), box((2 * x, 0.5 * tall, rim), (0, low + 0.25 * tall, z))]
    if form == "tub":
        walls = [box((rim, tall, 2 * z), (s * x, low + tall / 2, 0)) for s in (-1, 1)]
        walls += [box((2 * x, tall, rim), (0, low + tall / 2, s * z)) for s in (-1, 1)]
        return [*walls, box((2 * x, rim, 2 * z), (0, low, 0))]
    levels = [low, high] if draw.chance(0.7) else [low, 0.5 * (low + high), high]
    bars = [box((2 * x, rim, rim), (0, y, s * z)) for y in levels for s in (-1, 1)]
    bars += [box((rim, rim, 2 * z), (s * x, y, 0)) for y in levels for s in (-1, 1)]
    across = np.linspace(-z, z, draw.integer(5, 10))[1:-1]
    bars += [box((2 * x, rim, rim), (0, low, place)) for place in across]
    if form == "grid":
        bars += [box((rim, rim, 2 * z), (place, low, 0)) for place in np.linspace(-x, x, draw.integer(4, 8))[1:-1]]
    if draw.chance(0.6):
        bars += [box((rim, tall, rim), (s * x, low + tall / 2, place)) for place in across for s in (-1, 1)]
    if draw.chance(0.4):
        # Rods that hold plates.
        rods = [(place, row) for place in across for row in np.linspace(-0.7, 0.7, draw.integer(3, 5)) * x]
        bars += [box((rim, 0.7 * tall, rim), (row, low + 0.35 * tall, place)) for place, row in rods]
    return bars
