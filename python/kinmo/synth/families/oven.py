"""Ovens and ranges with doors, knobs, trays, a drawer and a cooktop."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.appliances import add_dial, add_feet, appliance_casing, rectangular_frame
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, box_between, cylinder, sheet, torus
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Oven with one or two doors that fold down or, rarely, turn about a side.

    Knobs turn; trays, keys and a drawer slide. A cooktop may have a cover hinged at the rear.
    """
    width, height, depth = draw.between(0.8, 1.3), draw.between(0.9, 1.6), draw.between(0.7, 1.1)
    x, y, z = width / 2, height / 2, depth / 2
    wall = draw.between(0.03, 0.08)
    root = Node(draw.pick(["oven", "microwave"], [3, 1]))
    body = root.add("body")
    casing = body.add("frame", *appliance_casing(draw, np.array([-x, -y, -z]), np.array([x, y, z]), wall))
    base = Link("frame", [casing], kind=draw.pick([JointType.HEAVY, JointType.STATIC], [3, 1]))
    links = [base]
    strip = draw.between(0.1, 0.2) * height
    top = y - strip
    has_drawer = draw.chance(0.25)
    low = -y + (draw.between(0.15, 0.22) * height if has_drawer else draw.pick([0.0, 0.06]))
    doors = draw.pick([1, 2], [3, 2] if height > 1.2 else [9, 1])
    split = low + (top - low) * draw.between(0.55, 0.68)
    spans = [(low, top)] if doors == 1 else [(low, split - 0.01), (split, top)]
    look = _Look(draw)
    for bottom, ceiling in spans:
        links.append(look.add_door(draw, body, base, x, bottom, ceiling, z))
        links += _trays(draw, body, base, x - wall, bottom, ceiling, depth)
    if has_drawer:
        links.append(_drawer(draw, body, base, x, -y, low - 0.01, z, depth))
    links += _controls(draw, body, base, x, y - strip / 2, strip, z)
    if draw.chance(0.4):
        _cooktop(draw, root, base, x, y, z)
        if draw.chance(0.15):
            links.append(_cover(draw, root, base, x, y, z))
    if draw.chance(0.3):
        base.nodes.append(add_feet(draw, root, x, z, -y))
    return SynthObject("Oven", root, links)


class _Look:
    """Common style of the doors of one oven."""

    def __init__(self, draw: Draw) -> None:
        self.thickness = draw.between(0.025, 0.09)
        self.rim = draw.between(0.06, 0.14)
        self.window = draw.pick(["pane", "plate", "none"], [5, 3, 1])
        self.grip = draw.between(0.6, 0.95)
        self.rod = draw.between(0.02, 0.045)
        self.side = draw.pick([0.0, -1.0, 1.0], [14, 1, 1])

    def add_door(self, draw: Draw, body: Node, base: Link, x: float, low: float, high: float, z: float) -> Link:
        """Add a door between two heights."""
        node = body.add("door")
        front = z + self.thickness
        corners = np.array([-x, low, z]), np.array([x, high, front])
        if self.window == "pane":
            node.add("door_frame", rectangular_frame(*corners, self.rim))
        else:
            node.add("door_frame", box_between(*corners))
        pane = (2 * (x - self.rim), high - low - 2 * self.rim)
        middle = (0, 0.5 * (low + high), front - (0.4 * self.thickness if self.window == "pane" else -0.002))
        if self.window != "none":
            node.add("glass", sheet(pane, middle, "z") if draw.chance(0.5) else box((*pane, 0.004), middle))
        inset = draw.between(0.5, 0.9) * self.rim
        upright = self.side != 0.0
        foot = (-self.side * (x - inset), 0.5 * (low + high), front) if upright else (0, high - inset, front)
        length = self.grip * ((high - low) if upright else 2 * x)
        node.add("handle", *pull(draw, length, foot, vertical=upright, thickness=self.rod, reach=2.2 * self.rod))
        rest = draw.between(20, 90) if draw.chance(0.12) else 0.0
        deep = z + self.thickness * draw.pick([0.0, 0.2, 0.6])
        if self.side != 0.0:
            # The door is hinged at its side.
            return Link("door", [node], base, hinge((self.side * x, 0, deep), (0, self.side, 0), 0, 110, rest=rest))
        axis = (0, low + draw.pick([0.0, draw.between(0.0, 0.04)]), deep)
        return Link("door", [node], base, hinge(axis, (1, 0, 0), 0, 90, rest=rest))


def _trays(draw: Draw, body: Node, base: Link, x: float, low: float, high: float, depth: float) -> list[Link]:
    """One or two racks behind a door that slide out."""
    if draw.chance(0.4):
        return []
    inside = body.add("body_interior")
    links = []
    for level in draw.pick([[0.4], [0.3, 0.55]]):
        y = low + level * (high - low)
        bars = [box((1.85 * x, 0.01, 0.01), (0, y, s * depth)) for s in np.linspace(-0.35, 0.4, draw.integer(3, 12))]
        sides = [box((0.015, 0.04, 0.76 * depth), (s * 0.93 * x, y, 0.025 * depth)) for s in (-1, 1)]
        node = inside.add("tray", *bars, *sides)
        links.append(
            Link("tray", [node], base, slider((0, 0, 1), 0, draw.between(0.5, 0.75) * depth), leaf_name="translation_tray")
        )
    return links


def _drawer(draw: Draw, body: Node, base: Link, x: float, low: float, high: float, z: float, depth: float) -> Link:
    """A drawer below the oven."""
    node = body.add("drawer")
    node.add("drawer_front", box_between((-x, low, z), (x, high, z + 0.04)))
    if draw.chance(0.6):
        node.add("drawer_box", box_between((-0.9 * x, low + 0.02, z - 0.8 * depth), (0.9 * x, high - 0.04, z)))
    if draw.chance(0.6):
        node.add("handle", *pull(draw, x, (0, high - 0.04, z + 0.04), vertical=False, thickness=0.025))
    return Link("drawer", [node], base, slider((0, 0, 1), 0, draw.between(0.4, 0.7) * depth))


def _controls(draw: Draw, body: Node, base: Link, x: float, y: float, height: float, z: float) -> list[Link]:
    """Knobs in a row, a keypad, or only a display."""
    panel = body.add("side_controls")
    links: list[Link] = []
    if draw.chance(0.6):
        display = sheet((draw.between(0.3, 1.5) * x, 0.5 * height), (0, y, z + 0.003), "z")
        base.nodes.append(panel.add("display_panel", display))
    kind = draw.pick(["knobs", "buttons", "none"], [6, 1, 2])
    if kind == "knobs":
        count, radius = draw.integer(2, 6), draw.between(0.16, 0.3) * height
        for index in range(count):
            at = (1.7 * x * ((index + 0.5) / count - 0.5), y, z)
            links.append(add_dial(draw, panel, base, at, radius, draw.pick(["knob", "control_button"])))
    elif kind == "buttons":
        pad = (0.6 * x, 0.8 * height)
        links += add_keypad(draw, panel, base, (0.6 * x, y, z), pad, "control_button")
    if not panel.children:
        base.nodes.append(panel.add("control_panel", box((1.9 * x, 0.8 * height, 0.02), (0, y, z + 0.01))))
    return links


def _cooktop(draw: Draw, root: Node, base: Link, x: float, y: float, z: float) -> None:
    """Add a plate with four burners, sometimes with a splashboard."""
    top = root.add("top")
    base.nodes.append(top)
    top.add("surface", box((2 * x, 0.03, 2 * z), (0, y + 0.015, 0)))
    for sx in (-0.5, 0.5):
        for sz in (-0.45, 0.45):
            at, radius = (sx * x, y + 0.04, sz * z), draw.between(0.2, 0.35) * min(x, z)
            top.add("burner", torus(radius, 0.012, "y", at) if draw.chance(0.4) else cylinder(radius, 0.02, "y", at))
    if draw.chance(0.4):
        top.add("back_panel", box((2 * x, 0.25, 0.04), (0, y + 0.14, -z + 0.02)))


def _cover(draw: Draw, root: Node, base: Link, x: float, y: float, z: float) -> Link:
    """A lid over the burners, hinged at the rear, mostly shown open."""
    thick = draw.between(0.01, 0.03)
    node = root.add(draw.pick(["lid", "cover"]), box((2 * x, thick, 2 * z), (0, y + 0.07 + thick / 2, 0)))
    opens = draw.between(85, 100)
    rest = draw.pick([opens, 0.0, draw.between(30, 80)], [3, 2, 1])
    return Link("lid", [node], base, hinge((0, y + 0.07, -z), (-1, 0, 0), 0, opens, rest=rest))
