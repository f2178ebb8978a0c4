"""Refrigerators with one to four doors, freezer drawers, shelves and water dispensers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from kinmo.synth.details.appliances import add_feet, appliance_casing
from kinmo.synth.details.casework_extras import add_lift_top
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import pull
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.details.resting_details import add_body_details
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, box, box_between, cylinder, move, open_box, rounded_box, sheet, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider

Cell = tuple[float, float, float, float, str]
"""Left, low, right and high edge of a door, and the side of its hinge, or "drawer"."""


def build(draw: Draw) -> SynthObject:
    """Refrigerator whose doors turn about an outer vertical edge and whose drawers slide forward.

    Variants: one door, two or three one above the other, two side by side, two over drawers or over one door, four doors, a low
    bar with one door, a chest whose lid folds up, and a stack of drawers. Shelves, crispers and inner drawers slide or are
    fixed. A dispenser on a door has keys that slide in and a paddle that tips or slides.
    """
    low_one = draw.chance(0.2)
    width, depth = draw.ratio(0.5, 1.3), draw.ratio(0.45, 1.1)
    height = draw.ratio(0.4, 1.0) if low_one else draw.ratio(0.9, 2.3)
    x, y, z = width / 2, height / 2, depth / 2
    wall = draw.between(0.03, 0.08)
    root = Node("refrigerator")
    body = root.add("body")
    casing = body.add("frame", *appliance_casing(draw, np.array([-x, -y, -z]), np.array([x, y, z]), wall))
    base = Link("frame", [casing], kind=draw.pick([JointType.HEAVY, JointType.STATIC], [8, 1]))
    links = [base]
    low = -y + draw.pick([0.0, draw.between(0.02, 0.12) * height])
    top = y - draw.pick([0.0, draw.between(0.02, 0.1) * height], [3, 1])
    thickness, handles = draw.ratio(0.02, 0.15), draw.chance(0.8)
    # Doors lie on the body, or fit between its walls.
    inset = draw.pick([0.0, wall], [7, 1])
    front = z - draw.pick([0.0, thickness], [1, 3]) if inset else z
    if low_one and draw.chance(0.2):
        links.append(add_lift_top(draw, body, base, (-x, y, -z), (x, y + thickness, z), "door"))
        casing.pieces = [turn(open_box((-x, -z, -y), (x, z, y), wall), X, -90.0)]
    else:
        for cell in _cells(draw, x - inset, low, top - inset, low_one=low_one):
            if cell[4] == "drawer":
                links.append(_drawer(draw, body, base, cell, front, thickness, depth, handles=handles))
            else:
                links.append(_door(draw, body, base, cell, front, thickness, handles))
    if draw.chance(0.35):
        links += _interior(draw, body, base, (width - 2 * wall, 0.2 * height, 0.75 * depth), low)
    doors = [link for link in links if link.name == "door"]
    if doors and draw.chance(0.15):
        links += _dispenser(draw, body, draw.pick(doors), z)
    if draw.chance(0.5):
        base.nodes.append(add_feet(draw, root, x, z, -y))
    if draw.chance(0.25):
        base.nodes += add_body_details(draw, root, (-x, -y, -z), (x, y, z))
    return SynthObject("Refrigerator", root, links)


def _cells(draw: Draw, x: float, low: float, high: float, *, low_one: bool) -> list[Cell]:
    """Division of the front into doors and drawers."""
    side = draw.pick(["left", "right"], [1, 1])
    plan = draw.pick(["single", "two", "three", "beside", "french", "four", "drawers"], [1, 5, 1, 4, 3, 1, 0.5])
    if low_one:
        plan = draw.pick(["single", "two", "drawers"], [5, 1, 1])
    gap = draw.pick([0.0, draw.between(0.002, 0.015)])
    split = low + (high - low) * draw.pick([draw.between(0.15, 0.5), draw.between(0.5, 0.85)])
    if plan == "single":
        return [(-x, low, x, high, side)]
    if plan in ("two", "three", "drawers"):
        count = {"two": 2, "three": 3}.get(plan, draw.integer(2, 4))
        edges = [low, split, high] if plan == "two" else list(np.linspace(low, high, count + 1))
        share = {"two": 0.25, "three": 0.5}.get(plan, 1.0)
        swapped = draw.chance(0.1)  # one door is hinged at the other side
        cells: list[Cell] = []
        for index, (bottom, ceiling) in enumerate(pairwise(edges)):
            other = "left" if side == "right" else "right"
            is_drawer = draw.chance(share) and (plan == "drawers" or index < len(edges) - 2)
            hinged = other if swapped and index == 0 else side
            cells.append((-x, bottom + gap * (index > 0), x, ceiling - gap, "drawer" if is_drawer else hinged))
        return cells[::-1]
    middle = draw.pick([0.0, draw.between(-0.3, 0.3) * x], [1, 2]) if plan == "beside" else 0.0
    floor = low if plan == "beside" else split
    pair: list[Cell] = [(-x, floor + gap, middle - gap, high, "left"), (middle + gap, floor + gap, x, high, "right")]
    if plan == "beside":
        return pair
    if plan == "four":
        return [*pair, (-x, low, -gap, split - gap, "left"), (gap, low, x, split - gap, "right")]
    if draw.chance(0.15):
        return [*pair, (-x, low, x, split - gap, side)]
    rows = draw.integer(1, 3)
    step = (split - low) / rows
    columns = [(-x, -gap), (gap, x)] if rows > 1 and draw.chance(0.15) else [(-x, x)]
    spans = [(low + row * step, low + (row + 1) * step - gap) for row in range(rows)]
    return [*pair, *((left, bottom, right, ceiling, "drawer") for bottom, ceiling in spans for left, right in columns)]


def _panel(draw: Draw, node: Node, cell: Cell, back: float, thickness: float) -> None:
    """Add the panel of a door or drawer."""
    left, low, right, high, _ = cell
    size, at = (right - left, high - low, thickness), ((left + right) / 2, (low + high) / 2, back + thickness / 2)
    slab = rounded_box(size, draw.between(0.1, 0.5) * thickness, "y", at, 3) if draw.chance(0.4) else box(size, at)
    panel = node.add("door_frame", slab)
    if draw.chance(0.3):
        panel.pieces.append(box((0.96 * size[0], 0.97 * size[1], 0.01), (at[0], at[1], back - 0.005)))
    add_fittings(draw, node, (left, low), (right, high), back + thickness, cell[4] if cell[4] in ("left", "right") else "")
    if draw.chance(0.15):
        logo = (at[0], high - 0.12 * size[1], back + thickness + 0.002)
        node.add("other").add("other_leaf", sheet((0.15 * size[0], 0.02), logo, "z"))


def _door(draw: Draw, body: Node, base: Link, cell: Cell, z: float, thickness: float, handles: bool) -> Link:
    """A hinged door with a handle and door shelves."""
    left, low, right, high, side = cell
    node = body.add("door")
    back = z + draw.pick([0.0, draw.between(0.0, 0.01)])
    _panel(draw, node, cell, back, thickness)
    out = -1.0 if side == "left" else 1.0
    edge = left if side == "left" else right
    width, height = right - left, high - low
    if handles:
        thick, reach = draw.ratio(0.012, 0.06), draw.ratio(0.03, 0.12)
        level = draw.chance(0.1) and width > 0.3
        length = min(0.4 * width if level else height, height) * draw.ratio(0.1, 0.95)
        margin = draw.between(0.03, 0.18) * width + (0.5 * length if level else 0.0)
        x = edge - out * (width - margin)
        y = (low + high) / 2 + draw.between(-0.5, 0.5) * (height - length)
        foot, room = (x, y, back + thickness), 0.4 * min(width, height)
        node.add("handle", *pull(draw, length, foot, vertical=not level, thickness=thick, reach=reach, room=room))
    if draw.chance(0.3):
        for row in range(draw.integer(1, 3)):
            shelf = box((0.75 * width, 0.06, 0.1), ((left + right) / 2, low + (row + 0.7) * height / 4, back - 0.05))
            node.add("other").add("other_leaf", shelf)
    inward, forward = draw.between(0.0, 0.05) * width, thickness * draw.pick([0.0, 0.3, 0.6, -0.3])
    axis = (edge - out * inward, high, back + forward)
    if draw.chance(0.2):
        (node if draw.chance(0.4) else _hardware_group(body, base)).add(
            "hinge", cylinder(0.02, 0.03, "y", (axis[0], high + 0.015, axis[2]), 12)
        )
    rest = draw.between(20, 110) if draw.chance(0.15) else 0.0
    return Link("door", [node], base, hinge(axis, (0, out, 0), 0, draw.pick([90.0, 120.0, 180.0], [2, 2, 4]), rest=rest))


def _drawer(draw: Draw, body: Node, base: Link, cell: Cell, z: float, thickness: float, depth: float, *, handles: bool) -> Link:
    """A drawer, mostly with a handle, with a block, a tub or nothing behind its front."""
    left, low, right, high, _ = cell
    node = body.add("drawer")
    _panel(draw, node, cell, z, thickness)
    wide, rim, deep = 0.5 * (right - left) - 0.08, low + draw.between(0.3, 0.9) * (high - low), draw.between(0.5, 0.9) * depth
    form = draw.pick(["block", "tub", "none"], [3, 4, 3]) if wide > 0.05 else "none"
    middle = 0.5 * (left + right)
    if form == "block":
        node.add("drawer_box", box_between((middle - wide, low + 0.02, z - deep), (middle + wide, rim, z)))
    elif form == "tub":
        tall = rim - low - 0.02
        tub = turn(open_box((-wide, -deep / 2, -tall / 2), (wide, deep / 2, tall / 2), min(0.015, 0.2 * tall)), X, -90.0)
        node.add("drawer_box", move(tub, (middle, low + 0.02 + tall / 2, z - deep / 2)))
    if handles:
        at = (middle, high - draw.between(0.05, 0.6) * (high - low), z + thickness)
        long = draw.between(0.2, 0.9) * (right - left)
        node.add("handle", *pull(draw, long, at, vertical=False, thickness=0.03, room=high - low))
    travel = draw.between(0.4, 0.75) * depth
    rest = travel * draw.between(0.2, 0.9) if draw.chance(0.12) else 0.0
    return Link("drawer", [node], base, slider((0, 0, 1), 0, travel, rest=rest))


def _interior(draw: Draw, body: Node, base: Link, size: tuple[float, float, float], low: float) -> list[Link]:
    """Shelves that are fixed or slide, and crispers that slide out, one above the other."""
    inside, links = body.add("body_interior"), []
    width, pitch, deep = size
    crispers, sliding = draw.chance(0.4), draw.chance(0.3)
    for row in range(draw.integer(1, 4)):
        y = low + (row + 1) * pitch
        out = slider((0, 0, 1), 0, draw.between(0.4, 0.8) * deep)
        if row == 0 and crispers:
            for side in draw.pick([(0.0,), (-1.0, 1.0)]):
                wide = width if side == 0.0 else 0.49 * width
                tray = inside.add("tray", box((wide, 0.7 * pitch, 0.95 * deep), (side * 0.25 * width, y - 0.4 * pitch, -0.02)))
                links.append(Link("tray", [tray], base, out, leaf_name="translation_tray"))
        shelf = inside.add("shelf", box((width, 0.012, deep), (0, y, -0.02)))
        if sliding:
            links.append(Link("shelf", [shelf], base, out, leaf_name="translation_tray"))
        else:
            base.nodes.append(shelf)
    return links


def _dispenser(draw: Draw, body: Node, door: Link, z: float) -> list[Link]:
    """A water dispenser on a door: a plate with keys, and a paddle that tips or slides; on some doors the paddle is fixed."""
    corners = np.concatenate([piece.vertices for leaf in door.leaves() for piece in leaf.pieces])
    low, high = corners.min(axis=0), corners.max(axis=0)
    front = draw.pick([float(high[2]), z + 0.5 * (float(high[2]) - z)], [1, 1])
    wide, middle = 0.4 * float(high[0] - low[0]), 0.5 * (low + high)
    at = (float(middle[0]), float(middle[1]) + 0.15 * float(high[1] - low[1]), max(front, float(high[2]) - 0.02))
    group = body.add("other")
    door.nodes.append(group.add("other_leaf", box((wide, 1.4 * wide, 0.02), at)))
    links = add_keypad(draw, group, door, (at[0], at[1] + 0.4 * wide, at[2] + 0.01), (0.8 * wide, 0.4 * wide), "button")
    pin = (at[0], at[1] - 0.05 * wide, at[2] + 0.02)
    paddle = box((0.25 * wide, 0.4 * wide, 0.02), (pin[0], pin[1] - 0.2 * wide, pin[2]))
    if draw.chance(0.6):
        motion = hinge(pin, (1, 0, 0), 0, draw.between(8, 30)) if draw.chance(0.7) else slider((0, 0, -1), 0, 0.02)
        links.append(Link("lever", [group.add("lever", paddle)], door, motion))
    else:
        door.nodes.append(group.add("lever", paddle))
    return links


def _hardware_group(body: Node, base: Link) -> Node:
    """A group of hardware that belongs to the housing."""
    group = body.add("other")
    base.nodes.append(group)
    return group
