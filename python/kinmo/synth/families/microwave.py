"""Microwaves with a door, controls beside, above or below it, and a turntable."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.synth.details.appliances import add_dial, add_feet, appliance_casing, rectangular_frame
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.details.resting_details import add_body_details
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, box_between, cylinder, rounded_box, sheet, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Microwave whose door turns about a side or its lower or upper edge, or slides out with a drawer behind it.

    The turntable and dials turn; keys and the door button slide in.
    """
    width, height, depth = draw.ratio(0.9, 2.0), draw.ratio(0.5, 1.3), draw.ratio(0.5, 1.5)
    x, y, z = width / 2, height / 2, depth / 2
    wall = draw.ratio(0.02, 0.12)
    root = Node("microwave")
    body = root.add("body")
    where = draw.pick(["right", "left", "above", "below"], [10, 1.5, 1, 1])
    share = draw.between(0.15, 0.35)
    low, high, panel_low, panel_high = np.array([-x, -y]), np.array([x, y]), np.array([-x, -y]), np.array([x, y])
    axis = 0 if where in ("right", "left") else 1
    if where in ("right", "above"):
        high[axis] = panel_low[axis] = high[axis] - share * (width, height)[axis]
    else:
        low[axis] = panel_high[axis] = low[axis] + share * (width, height)[axis]
    casing = body.add("frame", *appliance_casing(draw, np.array([*low, -z]), np.array([*high, z]), wall))
    casing.pieces.append(box_between((*panel_low, -z), (*panel_high, z)))
    base = Link("frame", [casing], kind=draw.pick([JointType.HEAVY, JointType.FREE], [8, 1]))
    links = [base, _door(draw, body, base, low, high, z, depth)]
    if draw.chance(0.75):
        links += _controls(draw, body, base, panel_low, panel_high, z)
    if draw.chance(0.7):
        middle, room = 0.5 * float(low[0] + high[0]), min(float(high[0] - low[0]), depth)
        links += _turntable(draw, body, base, middle, float(low[1]) + wall, room * draw.between(0.25, 0.42))
    if draw.chance(0.5):
        base.nodes.append(add_feet(draw, root, x, z, -y))
    if draw.chance(0.25):
        base.nodes += add_body_details(draw, root, (-x, -y, -z), (x, y, z))
    return SynthObject("Microwave", root, links)


def _door(
    draw: Draw, body: Node, base: Link, area_low: NDArray[np.float64], area_high: NDArray[np.float64], z: float, depth: float
) -> Link:
    """The door between two corners [2] with its window and handle, mostly hinged at its left edge."""
    node = body.add("door")
    thickness, rim = draw.ratio(0.015, 0.15), draw.ratio(0.05, 0.25) * float((area_high - area_low).min())
    shrink = draw.pick([0.0, draw.between(0.0, 0.06)])
    back = z - draw.pick([0.0, thickness], [3, 2])
    low, high = np.array([*(area_low + shrink), back]), np.array([*(area_high - shrink), back + thickness])
    pane_z = back + thickness * draw.pick([0.5, 1.0, 1.02])
    pane = (high[0] - low[0] - 2 * rim, high[1] - low[1] - 2 * rim)
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), pane_z)
    if draw.chance(0.85):
        solid = draw.chance(0.4)
        node.add("door_frame", box_between(low, high) if solid else rectangular_frame(low, high, rim))
    if draw.chance(0.85) or not node.children:
        thin = draw.pick([0.0, 0.004, 0.02])
        node.add("glass", sheet(pane, middle, "z") if thin == 0 else box((*pane, thin), middle))
    side = draw.pick(["left", "right", "bottom", "top", "drawer"], [10, 2, 2, 0.7, 0.4])
    out = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1), "drawer": (0, -1)}[side]
    size, upright = high - low, out[0] != 0
    if draw.chance(0.6):
        length = draw.between(0.3, 0.85) * size[1 if upright else 0]
        inset = draw.between(0.25, 0.6) * rim
        at = (middle[0] - out[0] * (0.5 * size[0] - inset), middle[1] - out[1] * (0.5 * size[1] - inset), back + thickness)
        node.add("handle", *pull(draw, length, at, vertical=upright, thickness=draw.ratio(0.02, 0.08), room=1.5 * rim))
    add_fittings(draw, node, low[:2], high[:2], back + thickness, "" if side == "drawer" else side)
    if side == "drawer":
        tub = box_between((*(low[:2] + 0.1 * size[:2]), z - 0.8 * depth), (*(low[:2] + (0.9, 0.5) * size[:2]), z))
        node.add("drawer_box", tub)
        return Link("door", [node], base, slider((0, 0, 1), 0, draw.between(0.3, 0.7) * depth))
    if draw.chance(0.15):
        across = (0.05, 0.01, 0.08) if upright else (0.01, 0.05, 0.08)
        for place in (-0.4, 0.4):
            along = (0, place * size[1]) if upright else (place * size[0], 0)
            edge = (middle[0] + out[0] * 0.48 * size[0] + along[0], middle[1] + out[1] * 0.48 * size[1] + along[1], back)
            node.add("hinge", box(across, edge))
    inward = draw.between(-0.02, 0.04)
    origin = (middle[0] + out[0] * (0.5 * size[0] - inward), middle[1] + out[1] * (0.5 * size[1] - inward))
    axis = (0, out[0], 0) if upright else (-out[1], 0, 0)
    opens = draw.pick([90.0, 110.0, 120.0, draw.between(70.0, 170.0)], [6, 1, 1, 1])
    rest = draw.between(20, 80) if draw.chance(0.15) else 0.0
    deep = back + thickness * draw.pick([0.0, 0.5, 1.0])
    return Link("door", [node], base, hinge((*origin, deep), axis, 0, opens, rest=min(rest, opens)))


def _controls(draw: Draw, body: Node, base: Link, low: NDArray[np.float64], high: NDArray[np.float64], z: float) -> list[Link]:
    """A display, a keypad, dials or both, and a wide button that opens the door, along the longer side of an area."""
    panel = body.add("side_controls")
    (x, y), (width, height) = 0.5 * (low + high), high - low
    upright = height > width
    long, across = max(width, height), min(width, height)
    links: list[Link] = []

    def at(share: float) -> tuple[float, float, float]:
        """Point at a share of the length, from the upper or left end."""
        return (x, y + (0.5 - share) * height, z) if upright else (x + (share - 0.5) * width, y, z)

    def area(part: float) -> tuple[float, float]:
        """Size of a field that covers a part of the length."""
        return (0.75 * across, part * long) if upright else (part * long, 0.75 * across)

    if draw.chance(0.6):
        display, place, flat = area(draw.between(0.05, 0.15)), at(0.12), draw.chance(0.4)
        mesh = sheet(display, (*place[:2], z + 0.003), "z") if flat else box((*display, 0.01), (*place[:2], z + 0.003))
        base.nodes.append(panel.add("display_panel", mesh))
    kind = draw.pick(["keypad", "dials", "both"], [5, 4, 2])
    if kind != "dials":
        links += add_keypad(
            draw, panel, base, at(0.5 if kind == "keypad" else 0.4), area(0.45 if kind == "keypad" else 0.25), "control_button"
        )
    if kind != "keypad":
        count = draw.pick([1, 2, 3], [1, 2, 0.5]) if kind == "dials" else 1
        radius = min(draw.between(0.15, 0.4) * across, 0.25 * long / count)
        for index, own in enumerate(draw.identical(count)):
            place = at(0.25 + 0.5 * (index + 0.5) / count if kind == "dials" else 0.72)
            links += add_dial(own, panel, base, place, radius, "control_button")
    if draw.chance(0.35):
        travel = draw.between(0.004, 0.02)
        node = panel.add("door_button", rounded_box((*area(0.08), 2 * travel), 0.01, "z", at(0.91)))
        links.append(Link("door_button", [node], base, slider((0, 0, -1), 0, travel), leaf_name="button"))
    if not panel.children:
        base.nodes.append(panel.add("display_panel", sheet(area(0.5), at(0.5), "z")))
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
