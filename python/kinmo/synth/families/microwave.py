"""Microwaves with a door at the left, controls at the right and a turntable."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.appliances import add_dial, add_feet, appliance_casing, rectangular_frame
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, box_between, cylinder, rounded_box, sheet, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Microwave whose door turns about its left edge.

    The turntable and dials turn; keys and the door button slide in.
    """
    width, height, depth = draw.between(1.2, 1.7), draw.between(0.6, 1.1), draw.between(0.7, 1.4)
    x, y, z = width / 2, height / 2, depth / 2
    split = x - draw.between(0.18, 0.32) * width
    wall = draw.between(0.03, 0.1)
    root = Node("microwave")
    body = root.add("body")
    casing = body.add("frame", *appliance_casing(draw, np.array([-x, -y, -z]), np.array([split, y, z]), wall))
    casing.pieces.append(box_between((split, -y, -z), (x, y, z)))
    base = Link("frame", [casing], kind=draw.pick([JointType.HEAVY, JointType.FREE], [8, 1]))
    links = [base, _door(draw, body, base, -x, split, y, z)]
    if draw.chance(0.75):
        links += _controls(draw, body, base, split, x, y, z)
    if draw.chance(0.7):
        links += _turntable(draw, body, base, (split - x) / 2, -y + wall, min(split + x, depth) * 0.4)
    if draw.chance(0.5):
        base.nodes.append(add_feet(draw, root, x, z, -y))
    return SynthObject("Microwave", root, links)


def _door(draw: Draw, body: Node, base: Link, left: float, right: float, y: float, z: float) -> Link:
    """The door with its window and handle, hinged at its left edge."""
    node = body.add("door")
    thickness, rim = draw.between(0.02, 0.13), draw.between(0.08, 0.2)
    shrink = draw.pick([0.0, draw.between(0.0, 0.06)])
    back = z - draw.pick([0.0, thickness], [3, 2])
    low = np.array([left + shrink, -y + shrink, back])
    high = np.array([right - draw.pick([0.0, 0.01]), y - shrink, back + thickness])
    pane_z = back + thickness * draw.pick([0.5, 1.0, 1.02])
    pane = (high[0] - low[0] - 2 * rim, high[1] - low[1] - 2 * rim)
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), pane_z)
    if draw.chance(0.85):
        solid = draw.chance(0.4)
        node.add("door_frame", box_between(low, high) if solid else rectangular_frame(low, high, rim))
    if draw.chance(0.85) or not node.children:
        thin = draw.pick([0.0, 0.004, 0.02])
        node.add("glass", sheet(pane, middle, "z") if thin == 0 else box((*pane, thin), middle))
    if draw.chance(0.6):
        length = draw.between(0.3, 0.85) * 2 * y
        at = (high[0] - draw.between(0.25, 0.6) * rim, middle[1], back + thickness)
        node.add("handle", *pull(draw, length, at, vertical=True, thickness=draw.between(0.03, 0.07)))
    if draw.chance(0.15):
        for place in (-0.8, 0.8):
            node.add("hinge", box((0.05, 0.01, 0.08), (low[0] + 0.02, place * y, back)))
    axis = (low[0] + draw.between(-0.02, 0.04), 0, back + thickness * draw.pick([0.0, 0.5, 1.0]))
    opens = draw.pick([90.0, 110.0, 120.0], [6, 1, 1])
    rest = draw.between(20, 80) if draw.chance(0.15) else 0.0
    return Link("door", [node], base, hinge(axis, (0, -1, 0), 0, opens, rest=rest))


def _controls(draw: Draw, body: Node, base: Link, left: float, right: float, y: float, z: float) -> list[Link]:
    """A display, a keypad, dials or both, and a wide button that opens the door."""
    panel = body.add("side_controls")
    middle, width = 0.5 * (left + right), right - left
    links: list[Link] = []
    if draw.chance(0.6):
        display = (0.7 * width, draw.between(0.08, 0.2) * y)
        at = (middle, 0.75 * y, z + 0.003)
        flat = draw.chance(0.4)
        base.nodes.append(panel.add("display_panel", sheet(display, at, "z") if flat else box((*display, 0.01), at)))
    kind = draw.pick(["keypad", "dials", "both"], [5, 4, 2])
    if kind != "dials":
        height = 1.1 * y if kind == "keypad" else 0.5 * y
        links += add_keypad(draw, panel, base, (middle, 0.05 * y, z), (0.75 * width, height), "control_button")
    if kind != "keypad":
        count = draw.pick([1, 2], [1, 2]) if kind == "dials" else 1
        for row in range(count):
            at = (middle, (0.4 - 0.7 * row) * y if kind == "dials" else -0.5 * y, z)
            links.append(add_dial(draw, panel, base, at, draw.between(0.2, 0.32) * width, "control_button"))
    if draw.chance(0.35):
        travel = draw.between(0.004, 0.02)
        node = panel.add("door_button", rounded_box((0.7 * width, 0.1 * y, 2 * travel), 0.01, "z", (middle, -0.82 * y, z)))
        links.append(Link("door_button", [node], base, slider((0, 0, -1), 0, travel), leaf_name="button"))
    if not panel.children:
        base.nodes.append(panel.add("display_panel", sheet((0.8 * width, y), (middle, 0, z), "z")))
    return links


def _turntable(draw: Draw, body: Node, base: Link, x: float, floor: float, radius: float) -> list[Link]:
    """The turntable, alone or on a support, sometimes with a cup on it."""
    inside = body.add("body_interior")
    thickness = draw.pick([0.0, draw.between(0.015, 0.04)], [1, 5])
    lift = floor + draw.between(0.01, 0.05)
    tray = inside.add("tray", cylinder(radius, thickness, "y", (x, lift + thickness / 2, 0), draw.pick([16, 24, 32])))
    nodes = [tray]
    if draw.chance(0.3):
        arms = [turn(box((1.6 * radius, 0.02, 0.06)), (0, 1, 0), 60.0 * k) for k in range(3)]
        support = inside.add("tray_support", *arms)
        support.pieces = [type(arm)(arm.vertices + [x, floor + 0.01, 0], arm.faces) for arm in arms]
        nodes.append(support)
    if draw.chance(0.3):
        cup = cylinder(0.07, 0.15, "y", (x + 0.1, lift + thickness + 0.075, 0.05), 16, top_radius=0.09)
        nodes.append(inside.add("other").add("other_leaf", cup))
    return [Link("body_interior", nodes, base, spinner((x, lift, 0), (0, 1, 0)), leaf_name="tray")]
