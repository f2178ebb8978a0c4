"""Objects whose panels slide in grooves or on rails: cupboards, desks, boxes with sliding lids, cages, hatches, show cases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.appliances import frame_bars
from kinmo.synth.details.casework import add_drawer, legs
from kinmo.synth.details.casework_doors import add_hung_door, add_shutter, add_sliding_doors
from kinmo.synth.details.casework_extras import add_inner_shelves, add_trim
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, join, move, open_box, rotation_about, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, slider


def build(draw: Draw) -> SynthObject:
    """Object with panels that slide sideways or up.

    Variants: a cupboard or wardrobe, a desk with a closed top, a box whose lid slides, a cage with a gate, a hatch in a wall,
    and a glass case. Some have drawers, too.
    """
    style = draw.pick([_cupboard, _desk, _box, _cage, _hatch, _glass_case], [5, 2, 3, 2, 2, 2])
    return style(draw)


def _start(draw: Draw, name: str, body_name: str, *pieces: Mesh) -> tuple[Node, Link]:
    """Root and static base of an object."""
    root = Node(name)
    body = root.add(body_name, *pieces)
    return root, Link(body_name, [body], kind=draw.pick([JointType.STATIC, JointType.HEAVY, JointType.FREE]))


def _cupboard(draw: Draw) -> SynthObject:
    """Carcass with one row of sliding doors, or with two rows, of which one may be drawers, a shutter or open."""
    tall = draw.chance(0.4)
    width, height = draw.ratio(0.6, 2.4), draw.ratio(1.2, 2.2) if tall else draw.ratio(0.35, 1.1)
    depth, board = draw.ratio(0.3, 0.7), draw.ratio(0.012, 0.04)
    low, high = np.array([-width, -height, -depth]) / 2, np.array([width, height, depth]) / 2
    root, base = _start(draw, "storage_furniture", "cabinet_frame", *_shell(draw, low, high, board))
    inside, tall_inside = width - 2 * board, height - 2 * board
    rows = draw.pick([1, 2], [3, 1])
    split = draw.between(0.25, 0.75)
    tops = [tall_inside] if rows == 1 else [split * tall_inside - board / 2, (1 - split) * tall_inside - board / 2]
    links: list[Link] = []
    fronts, edge = Fronts.random(draw, board), low[1] + board
    for index, tall_row in enumerate(tops):
        opening = Opening(0.0, edge + tall_row / 2, inside, tall_row, depth - 1.5 * board, high[2])
        edge += tall_row + board
        if index:
            shelf = box_between((-inside / 2, opening.low - board, low[2]), (inside / 2, opening.low, high[2]))
            base.nodes.append(root.add("shelf", shelf))
        links += _close(draw, root, base, opening, fronts, board, may_differ=index > 0)
        if draw.chance(0.4):
            add_inner_shelves(draw, root, base, opening, board, min(6 * board, 0.4 * opening.depth))
    if draw.chance(0.4):
        thick = draw.ratio(0.02, 0.07)
        drop = low[1] - draw.between(0.05, 0.3)
        for leg in legs(draw, width / 2 - thick, depth / 2 - thick, drop, low[1], thick):
            base.nodes.append(root.add("foot", leg))
    elif draw.chance(0.5):
        add_trim(draw, root, base, low, high)
    return SynthObject("StorageFurniture", root, [base, *links])


def _shell(draw: Draw, low: np.ndarray, high: np.ndarray, board: float) -> list[Mesh]:
    """Meshes of a carcass open to the front: one surface, or boards with or without a back."""
    if draw.chance(0.4):
        return [open_box(low, high, board)]
    back = box_between((low[0], low[1], low[2] - 0.2 * board), (high[0], high[1], low[2] + 0.2 * board))
    return [*frame_bars(low, high, board), *([back] if draw.chance(0.85) else [])]


def _close(
    draw: Draw, root: Node, base: Link, opening: Opening, fronts: Fronts, board: float, *, may_differ: bool
) -> list[Link]:
    """Close an opening with panels that slide; with drawers beside each other if it `may_differ` from the others."""
    if may_differ and draw.chance(0.4):
        count = draw.integer(1, 3)
        wide = opening.width / count
        cells = [opening.x + wide * (index + 0.5 - count / 2) for index in range(count)]
        border = (0.0, 0.0, 0.5 * board, 0.5 * board)
        parts = [replace(opening, x=x, width=wide, border=border) for x in cells]
        return [add_drawer(draw, root, base, part, fronts) for part in parts]
    thick = draw.between(0.4, 1.2) * board
    kind = draw.pick(["doors", "shutter", "hung"], [6, 2, 1])
    if kind == "doors":
        upwards = draw.chance(0.1) and opening.height > 0.15 * opening.width
        return add_sliding_doors(draw, root, base, opening, thick, upwards=upwards)
    return [
        add_shutter(draw, root, base, opening, thick) if kind == "shutter" else add_hung_door(draw, root, base, opening, fronts)
    ]


def _desk(draw: Draw) -> SynthObject:
    """Table with a low cupboard on its top that sliding panels close, and sometimes a drawer below the top."""
    width, depth, top = draw.ratio(0.8, 1.8), draw.ratio(0.45, 0.9), draw.between(0.65, 0.8)
    board = draw.ratio(0.015, 0.04)
    plate = box_between((-width / 2, top - board, -depth / 2), (width / 2, top, depth / 2))
    root, base = _start(draw, "table", "tabletop", plate)
    thick = draw.ratio(0.03, 0.08)
    if draw.chance(0.6):
        stands = legs(draw, width / 2 - thick, depth / 2 - thick, 0.0, top - board, thick)
    else:
        stands = [box_between((s * width / 2 - board, 0, -depth / 2), (s * width / 2, top - board, depth / 2)) for s in (1,)]
        stands += [box_between((-width / 2, 0, -depth / 2), (-width / 2 + board, top - board, depth / 2))]
    base.nodes += [root.add("leg", stand) for stand in stands]
    tall, deep = draw.between(0.15, 0.7), depth * draw.between(0.35, 0.9)
    share = draw.pick([1.0, draw.between(0.5, 0.95)])
    low = np.array([-share * width / 2, top, -depth / 2])
    high = np.array([share * width / 2, top + tall, -depth / 2 + deep])
    base.nodes.append(root.add("cabinet_frame", *_shell(draw, low, high, board)))
    opening = Opening(0.0, top + tall / 2, share * width - 2 * board, tall - 2 * board, deep - board, high[2])
    fronts = Fronts.random(draw, board)
    links = _close(draw, root, base, opening, fronts, 0.8 * board, may_differ=False)
    if draw.chance(0.4):
        room = width - 2.5 * thick
        drawer = Opening(0.0, top - board - 0.07, room * draw.between(0.4, 0.95), 0.13, 0.8 * depth, depth / 2)
        links.append(add_drawer(draw, root, base, drawer, fronts))
    return SynthObject("Table", root, [base, *links])


def _box(draw: Draw) -> SynthObject:
    """Box whose lid slides off in grooves or over the rims; it lies, or stands on an end."""
    x, z, height = draw.ratio(0.1, 0.5), draw.ratio(0.1, 0.5), draw.ratio(0.06, 0.6)
    wall = draw.ratio(0.006, 0.03)
    tub = turn(open_box((-x, -z, -height / 2), (x, z, height / 2), wall), X, -90.0)
    root, base = _start(draw, "box", "base_body", tub)
    axis = draw.pick([X, Z])
    half = np.array([x, 0.0, z])
    lip, thick = draw.between(0.3, 1.0) * wall, draw.ratio(0.005, 0.03)
    top = height / 2
    grooved = draw.chance(0.6)
    inside = half - np.abs(np.cross(Y, axis)) * wall * 0.9 if grooved else half
    level = top + thick / 2
    size = 2 * inside
    size[1] = thick
    node = root.add(draw.pick(["lid", "translation_lid", "cover"]), box(size, (0, level, 0)))
    if grooved:
        # Strips on the rim hold the lid at three sides.
        side = np.cross(Y, axis)
        strip = np.abs(axis) * 2 * half + np.abs(side) * wall + Y * (thick + lip)
        edges = [
            box(strip, side * s * (float(np.abs(side) @ half) - wall / 2) + Y * (top + (thick + lip) / 2)) for s in (-1, 1)
        ]
        base.nodes.append(root.add(draw.pick(["rail", "base_body", "frame"]), *edges))
    long = float(np.abs(axis) @ half)
    sense = draw.sign()
    if draw.chance(0.7):
        place = axis * sense * -long * draw.pick([0.0, -0.85, 0.8]) + Y * (top + thick)
        across = box(np.abs(axis) * 0.1 * long + np.abs(np.cross(Y, axis)) * 0.5 * min(x, z) + Y * thick, place)
        knob = cylinder(0.08 * min(x, z), 2 * thick + 0.04, "y", place + Y * thick, 14)
        node.pieces.append(draw.pick([across, knob]))
    travel = 2 * long * draw.between(0.6, 1.0)
    rest = draw.pick([0.0, draw.between(0.1, 0.9) * travel], [2, 1])
    lid = Link("lid", [node], base, slider(sense * axis, 0.0, travel, rest=rest), leaf_name="translation_lid")
    shape = SynthObject("Box", root, [base, lid])
    if draw.chance(0.2):
        shape.move(rotation_about(X, 90.0))
    return shape


def _bars(low: np.ndarray, high: np.ndarray, count: int, rod: float) -> list[Mesh]:
    """Upright rods between two corners [3] of a plane across z."""
    middle = 0.5 * (low + high)
    return [cylinder(rod, high[1] - low[1], "y", (x, middle[1], middle[2]), 8) for x in np.linspace(low[0], high[0], count)]


def _cage(draw: Draw) -> SynthObject:
    """Cage of rods or boards with a gate at the front that slides up or sideways."""
    x, y, z = draw.ratio(0.2, 0.7), draw.ratio(0.2, 0.7), draw.ratio(0.2, 0.7)
    rod = draw.ratio(0.004, 0.02)
    floor = box_between((-x, -y - 0.03, -z), (x, -y, z))
    root, base = _start(draw, "cage", "base_body", floor)
    low, high = np.array([-x, -y, -z]), np.array([x, y, z])
    count = draw.integer(6, 14)
    wide = draw.between(0.3, 0.6) * 2 * x
    tall = draw.between(0.5, 0.95) * 2 * y
    left = -wide / 2 + draw.between(-0.2, 0.2) * x
    open_low, open_high = np.array([left, -y, z]), np.array([left + wide, -y + tall, z])
    pieces = _bars(np.array([-x, -y, -z]), np.array([x, y, -z]), count, rod)
    sides = _bars(np.array([-z, -y, x]), np.array([z, y, x]), count, rod)
    pieces += [turn(piece, Y, angle) for piece in sides for angle in (90.0, -90.0)]
    front = np.linspace(-x, x, count)
    for place in front:
        bottom = open_high[1] if open_low[0] < place < open_high[0] else -y
        pieces += _bars(np.array([place, bottom, z]), np.array([place, y, z]), 1, rod)
    pieces += [cylinder(rod, tall, "y", (edge, -y + tall / 2, z), 8) for edge in (open_low[0], open_high[0])]
    pieces += [*frame_bars(low, (x, y, -z + 2 * rod), 2 * rod), *frame_bars((-x, -y, z - 2 * rod), high, 2 * rod)]
    roof = box_between((-x, y, -z), (x, y + 0.02, z))
    base.nodes.append(root.add("frame", *([join(*pieces)] if draw.chance(0.5) else pieces)))
    base.nodes.append(root.add(draw.pick(["roof", "top_panel"]), roof))
    depth = z + draw.between(2.0, 4.0) * rod
    if draw.chance(0.6):
        gate = _bars(open_low + (rod, 0, depth - z), open_high + (-rod, 0, depth - z), max(3, int(count * wide / (2 * x))), rod)
        rims = frame_bars((open_low[0], -y, depth - rod), (open_high[0], -y + tall, depth + rod), 2 * rod)
        gate = [*gate, *rims]
    else:
        gate = [box_between((open_low[0], -y, depth - rod), (open_high[0], -y + tall, depth + rod))]
    if draw.chance(0.5):
        middle = (0.5 * (open_low[0] + open_high[0]), -y + tall * draw.between(0.4, 0.9), depth + rod)
        gate += pull(draw, 0.3 * wide, middle, vertical=False, reach=3 * rod)
    node = root.add(draw.pick(["door", "gate"]), *gate)
    upwards = draw.chance(0.65)
    travel = (tall if upwards else wide) * draw.between(0.6, 1.0)
    if draw.chance(0.7):
        rail_size = (3 * rod, min(2 * y, 1.9 * tall), 2 * rod) if upwards else (min(2 * x, 2 * wide), 3 * rod, 2 * rod)
        for side in (-1, 1):
            at = (left + wide / 2 + side * (wide / 2 + 2 * rod), -y + rail_size[1] / 2, depth)
            if not upwards:
                at = (0.0, -y + tall / 2 + side * (tall / 2 + 2 * rod), depth)
            base.nodes.append(root.add("rail", box(rail_size, at)))
    direction = Y if upwards else X * draw.sign()
    rest = draw.pick([0.0, draw.between(0.1, 1.0) * travel], [3, 1])
    gate_link = Link("door", [node], base, slider(direction, 0.0, travel, rest=rest), leaf_name="translation_door")
    return SynthObject("cage", root, [base, gate_link])


def _hatch(draw: Draw) -> SynthObject:
    """A piece of wall or a frame with an opening that one or two panels close."""
    width, height = draw.ratio(0.4, 1.6), draw.ratio(0.4, 1.6)
    depth, rim = draw.ratio(0.04, 0.25), draw.ratio(0.04, 0.4)
    low, high = np.array([-width / 2 - rim, -height / 2 - rim, -depth]), np.array([width / 2 + rim, height / 2 + rim, 0.0])
    bars = frame_bars(low, high, rim)
    root, base = _start(draw, "window", draw.pick(["frame", "base_body"]), *(bars if draw.chance(0.5) else [join(*bars)]))
    opening = Opening(0.0, 0.0, width, height, depth, 0.0)
    thick = draw.between(0.15, 0.4) * depth
    if draw.chance(0.5):
        links = [add_shutter(draw, root, base, opening, thick)]
    else:
        links = add_sliding_doors(draw, root, base, opening, thick)
    if draw.chance(0.3):
        sill = box((1.1 * width, 0.04, 2 * depth), (0, -height / 2 - 0.02, depth))
        base.nodes.append(root.add(draw.pick(["shelf", "sill"]), sill))
    return SynthObject("Window", root, [base, *links])


def _glass_case(draw: Draw) -> SynthObject:
    """A case of thin panes on a plinth, closed by panes that slide sideways."""
    width, height, depth = draw.ratio(0.5, 1.8), draw.ratio(0.3, 1.4), draw.ratio(0.25, 0.6)
    pane = draw.ratio(0.004, 0.015)
    low, high = np.array([-width / 2, 0.0, -depth / 2]), np.array([width / 2, height, depth / 2])
    plinth = draw.ratio(0.05, 0.8)
    block = box_between((low[0], -plinth, low[2]), (high[0], 0.0, high[2]))
    root, base = _start(draw, "storage_furniture", "base_body", block)
    walls = [*frame_bars(low, high, pane), box_between(low, (high[0], high[1], low[2] + pane))]
    base.nodes.append(root.add(draw.pick(["glass", "frame"]), *walls))
    for level in np.linspace(0.0, height, draw.integer(0, 3) + 2)[1:-1]:
        shelf = box_between((low[0], level, low[2]), (high[0], level + pane, high[2] - 0.15 * depth))
        base.nodes.append(root.add("shelf", shelf))
    opening = Opening(0.0, height / 2, width - 2 * pane, height - 2 * pane, depth, high[2])
    links = add_sliding_doors(draw, root, base, opening, 1.5 * pane, upwards=draw.chance(0.1))
    shape = SynthObject("StorageFurniture", root, [base, *links])
    if draw.chance(0.3):
        posts = [(sx * (width / 2 - pane), height / 2, sz * (depth / 2 - pane)) for sx in (-1, 1) for sz in (-1,)]
        base.nodes.append(root.add("frame", *(move(box((3 * pane, height, 3 * pane)), at) for at in posts)))
    return shape
