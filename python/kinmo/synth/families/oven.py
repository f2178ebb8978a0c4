"""Ovens and ranges with doors, knobs, trays, a drawer and a cooktop."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from kinmo.synth.details.appliances import add_dial, add_feet, appliance_casing, rectangular_frame
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.details.resting_details import add_body_details
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, box_between, cylinder, sheet, torus
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Oven with one to three doors that fold down or turn about a side, or a pair of doors that meet in the middle.

    Knobs turn; trays, keys and drawers slide. A cooktop may have a cover hinged at the rear. Controls are above,
    below or beside the doors.
    """
    width, height, depth = draw.ratio(0.6, 1.8), draw.ratio(0.5, 1.8), draw.ratio(0.5, 1.2)
    x, y, z = width / 2, height / 2, depth / 2
    wall = draw.between(0.03, 0.08)
    root = Node(draw.pick(["oven", "microwave"], [3, 1]))
    body = root.add("body")
    casing = body.add("frame", *appliance_casing(draw, np.array([-x, -y, -z]), np.array([x, y, z]), wall))
    base = Link("frame", [casing], kind=draw.pick([JointType.HEAVY, JointType.STATIC], [3, 1]))
    links = [base]
    strip = draw.ratio(0.06, 0.25) * height
    where = draw.pick(["above", "below", "beside"], [8, 1, 1.5 if width > height else 0.3])
    has_drawer = where != "below" and draw.chance(0.25)
    low = -y + (draw.between(0.12, 0.3) * height if has_drawer else draw.pick([0.0, draw.between(0.0, 0.12) * height]))
    top, right, panel = y, x, (0.0, y - strip / 2, x, strip)
    if where == "above":
        top = y - strip
    elif where == "below":
        low, panel = -y + strip, (0.0, -y + strip / 2, x, strip)
    else:
        column = draw.between(0.15, 0.3) * width
        right, panel = x - column, (x - column / 2, 0.0, column / 2, 0.8 * height)
        casing.pieces.append(box_between((right, -y, -z), (x, y, z)))
    look = _Look(draw)
    for left, bottom, end, ceiling, side in _cells(draw, -x, low, right, top):
        links.append(look.add_door(draw, body, base, (left, bottom), (end, ceiling), z, side))
    links += _trays(draw, body, base, (-x + wall, low), (right - wall, top), depth)
    if has_drawer:
        links.append(_drawer(draw, body, base, x, -y, low - 0.01, z, depth))
    links += _controls(draw, body, base, *panel, z)
    if draw.chance(0.4):
        _cooktop(draw, root, base, x, y, z)
        if draw.chance(0.15):
            links.append(_cover(draw, root, base, x, y, z))
    if draw.chance(0.3):
        base.nodes.append(add_feet(draw, root, x, z, -y))
    if draw.chance(0.25):
        base.nodes += add_body_details(draw, root, (-x, -y, -z), (x, y, z))
    return SynthObject("Oven", root, links)


def _cells(draw: Draw, left: float, low: float, right: float, high: float) -> list[tuple[float, float, float, float, str]]:
    """Doors in an area of the front: left, low, right and high edge, and the edge of the hinge."""
    wide, tall = right - left, high - low
    if draw.chance(0.12):
        middle = 0.5 * (left + right)
        return [(left, low, middle, high, "left"), (middle, low, right, high, "right")]
    if wide > 1.2 * tall and draw.chance(0.2):
        middle, side = left + draw.between(0.35, 0.65) * wide, draw.pick(["bottom", "left", "right"], [3, 1, 1])
        return [(left, low, middle, high, side), (middle, low, right, high, side)]
    count = draw.pick([1, 2, 3], [3, 2, 0.3] if tall > 0.9 * wide else [9, 1, 0.1])
    shares = np.cumsum([0.0, *(draw.ratio(0.5, 1.5) for _ in range(count))])
    edges = low + tall * shares / shares[-1]
    side, gap = draw.pick(["bottom", "left", "right", "top"], [12, 2, 2, 0.5]), draw.pick([0.0, 0.01])
    return [(left, bottom, right, ceiling - gap, side) for bottom, ceiling in pairwise(edges)]


class _Look:
    """Common style of the doors of one oven."""

    def __init__(self, draw: Draw) -> None:
        self.thickness = draw.ratio(0.015, 0.12)
        self.rim = draw.ratio(0.04, 0.18)
        self.window = draw.pick(["pane", "plate", "none"], [5, 3, 1])
        self.grip = draw.pick([draw.between(0.6, 0.95), draw.between(0.2, 0.6)], [3, 1])
        self.rod = draw.ratio(0.012, 0.06)
        self.has_handle = draw.chance(0.92)
        self.inset = draw.pick([0.0, 1.0, draw.between(0.0, 1.0)], [6, 1, 1])
        """Depth of the door in the body, as a share of its thickness."""

    def add_door(
        self, draw: Draw, body: Node, base: Link, low: tuple[float, float], high: tuple[float, float], z: float, side: str
    ) -> Link:
        """Add a door between two corners (x, y) with its hinge at one edge."""
        node = body.add("door")
        back, wide, tall = z - self.inset * self.thickness, high[0] - low[0], high[1] - low[1]
        front, rim = back + self.thickness, min(self.rim, 0.35 * wide, 0.35 * tall)
        corners = np.array([*low, back]), np.array([*high, front])
        if self.window == "pane":
            node.add("door_frame", rectangular_frame(*corners, rim))
        else:
            node.add("door_frame", box_between(*corners))
        pane, center = (wide - 2 * rim, tall - 2 * rim), (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]))
        middle = (*center, front - (0.4 * self.thickness if self.window == "pane" else -0.002))
        if self.window != "none":
            node.add("glass", sheet(pane, middle, "z") if draw.chance(0.5) else box((*pane, 0.004), middle))
        out = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}[side]
        upright = out[0] != 0
        if self.has_handle:
            inset = draw.between(0.5, 0.9) * rim
            foot = (center[0] - out[0] * (0.5 * wide - inset), center[1] - out[1] * (0.5 * tall - inset), front)
            length, rod = self.grip * (tall if upright else wide), self.rod
            grip = pull(draw, length, foot, vertical=upright, thickness=rod, reach=2.2 * rod, room=1.5 * rim)
            node.add("handle", *grip)
        add_fittings(draw, node, low, high, front, side)
        opens = draw.pick([90.0, draw.between(70.0, 100.0)]) if not upright else draw.pick([90.0, 110.0, 170.0])
        rest = draw.between(0.2, 1.0) * opens if draw.chance(0.12) else 0.0
        deep, inward = back + self.thickness * draw.pick([0.0, 0.2, 0.6]), draw.pick([0.0, draw.between(0.0, 0.04)])
        at = (center[0] + out[0] * (0.5 * wide - inward), center[1] + out[1] * (0.5 * tall - inward), deep)
        axis = (0, out[0], 0) if upright else (-out[1], 0, 0)
        return Link("door", [node], base, hinge(at, axis, 0, opens, rest=rest))


def _trays(draw: Draw, body: Node, base: Link, low: tuple[float, float], high: tuple[float, float], depth: float) -> list[Link]:
    """One to three racks or sheets between two corners (x, y) of the interior that slide out. Some are fixed."""
    if draw.chance(0.4):
        return []
    inside = body.add("body_interior")
    links, x, tall = [], 0.5 * (low[0] + high[0]), high[1] - low[1]
    half, deep, moves = 0.46 * (high[0] - low[0]), 0.38 * depth, not draw.chance(0.15)
    count = draw.pick([1, 2, 3], [4, 4, 1])
    for own, level in zip(draw.identical(count), np.linspace(0.0, 1.0, count + 2)[1:-1], strict=True):
        y = low[1] + float(level) * tall
        if own.chance(0.65):
            bars = [box((2 * half, 0.01, 0.01), (x, y, s * deep)) for s in np.linspace(-0.9, 1.0, own.integer(3, 12))]
            pieces = [*bars, *(box((0.015, 0.04, 2 * deep), (x + s * half, y, 0.0)) for s in (-1, 1))]
        else:
            thin, rim = 0.01, own.between(0.01, 0.08) * tall
            pieces = [box((2 * half, thin, 2 * deep), (x, y, 0.0))]
            pieces += [box((0.015, rim, 2 * deep), (x + s * half, y + 0.5 * rim, 0.0)) for s in (-1, 1)]
        node = inside.add("tray", *pieces)
        out = slider((0, 0, 1), 0, own.between(0.4, 0.8) * depth)
        if moves:
            links.append(Link("tray", [node], base, out, leaf_name="translation_tray"))
        else:
            base.nodes.append(node)
    return links


def _drawer(draw: Draw, body: Node, base: Link, x: float, low: float, high: float, z: float, depth: float) -> Link:
    """A drawer below the oven."""
    node = body.add("drawer")
    node.add("drawer_front", box_between((-x, low, z), (x, high, z + 0.04)))
    if draw.chance(0.6):
        node.add("drawer_box", box_between((-0.9 * x, low + 0.02, z - 0.8 * depth), (0.9 * x, high - 0.04, z)))
    if draw.chance(0.6):
        node.add("handle", *pull(draw, x, (0, high - 0.04, z + 0.04), vertical=False, thickness=0.025, room=high - low))
    add_fittings(draw, node, (-x, low), (x, high), z + 0.04)
    return Link("drawer", [node], base, slider((0, 0, 1), 0, draw.between(0.4, 0.7) * depth))


def _controls(draw: Draw, body: Node, base: Link, x: float, y: float, half: float, height: float, z: float) -> list[Link]:
    """Knobs in a row or column, a keypad, or only a display, in an area about (x, y) of half width `half`."""
    panel = body.add("side_controls")
    links: list[Link] = []
    upright = height > 2 * half
    long, wide = (height, 2 * half) if upright else (2 * half, height)
    if draw.chance(0.6):
        size = (0.7 * wide, 0.2 * long) if upright else (draw.between(0.15, 0.75) * long, 0.5 * wide)
        at = (x, y + 0.35 * long, z + 0.003) if upright else (x, y, z + 0.003)
        base.nodes.append(panel.add("display_panel", sheet(size, at, "z")))
    kind = draw.pick(["knobs", "buttons", "both", "none"], [6, 1, 1, 2])
    if kind in ("knobs", "both"):
        count, radius = draw.integer(1, 8), draw.between(0.12, 0.4) * wide
        count = max(1, min(count, int(0.8 * long / (2 * radius))))
        room, name = (0.85 if kind == "knobs" else 0.4) * long, draw.pick(["knob", "control_button"])
        for own, index in zip(draw.identical(count), range(count), strict=True):
            aside = room * ((index + 0.5) / count - 0.5) - (0.0 if kind == "knobs" else 0.2 * long)
            links += add_dial(own, panel, base, (x, y + aside, z) if upright else (x + aside, y, z), radius, name)
    if kind in ("buttons", "both"):
        pad = (0.7 * wide, 0.3 * long) if upright else (0.3 * long, 0.8 * wide)
        links += add_keypad(
            draw, panel, base, (x, y + 0.3 * long, z) if upright else (x + 0.3 * long, y, z), pad, "control_button"
        )
    if not panel.children:
        base.nodes.append(panel.add("control_panel", box((1.9 * half, 0.8 * height, 0.02), (x, y, z + 0.01))))
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
