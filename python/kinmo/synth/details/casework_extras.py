"""Rarer parts of furniture: lids, pull-out boards, larders, trim, false fronts, leaning drawers, locked doors, casters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework import add_door, add_drawer
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.details.door_locks import add_door_lock
from kinmo.synth.details.wheels import add_caster
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, X, Z, box, box_between, join, move, rotation_about
from kinmo.synth.synth_object import Link, Node, hinge, slider


def add_lift_top(draw: Draw, above: Node, carcass: Link, low: Point, high: Point, name: str) -> Link:
    """Add a board between two corners [3] that folds up about its rear edge, rarely its front edge or an end."""
    edge = draw.pick(["rear", "front", "end"], [8, 1, 1])
    thick = float(high[1]) - float(low[1])
    level = float(low[1]) + draw.pick([0.0, 0.5 * thick, thick])
    opens = draw.between(45.0, 110.0)
    rest = draw.between(0.2, 0.9) * opens if draw.chance(0.25) else 0.0
    node = above.add(name, box_between(low, high))
    if edge == "end":
        motion = hinge((float(low[0]), level, 0), Z, 0.0, opens, rest=rest)
    else:
        z, sense = (float(low[2]), -1.0) if edge == "rear" else (float(high[2]), 1.0)
        motion = hinge((0, level, z), sense * X, 0.0, opens, rest=rest)
    return Link("lid", [node], carcass, motion, leaf_name="rotation_lid")


def add_pullout(draw: Draw, above: Node, carcass: Link, opening: Opening) -> Link:
    """Add a board in an opening that slides out: a keyboard tray, a shelf, a cutting board."""
    thick = min(draw.between(0.015, 0.05), 0.5 * opening.height)
    deep, y = opening.depth * draw.between(0.6, 0.95), opening.low + draw.between(0.1, 0.8) * (opening.height - thick)
    front = opening.front + draw.pick([0.0, draw.between(-0.05, 0.02)])
    half = 0.5 * opening.width - draw.between(0.0, 0.02)
    pieces = [box_between((opening.x - half, y, front - deep), (opening.x + half, y + thick, front))]
    if draw.chance(0.4):
        pieces.append(box((2 * half, 2 * thick, 0.02), (opening.x, y + thick, front + 0.01)))
    if draw.chance(0.15):
        # A keyboard lies on the tray.
        pieces.append(box((1.2 * half, 0.02, 0.35 * deep), (opening.x, y + thick + 0.01, front - 0.4 * deep)))
    if draw.chance(0.3):
        # The brackets that the tray slides in hang below the top.
        reach = min(2 * thick, opening.high - y)
        for side in (-1, 1):
            x, thin = opening.x + side * (half - 0.5 * thick), 0.2 * thick
            hanger = box_between((x - thin, y + reach, front - deep), (x + thin, opening.high, front - 0.1 * deep))
            carcass.nodes.append(above.add(draw.pick(["rail", "bar"]), hanger))
    node = above.add(draw.pick(["tray", "shelf", "keyboard_tray", "board"]), *pieces)
    travel = deep * draw.between(0.4, 0.9)
    rest = travel * draw.between(0.2, 0.9) if draw.chance(0.2) else 0.0
    return Link("tray", [node], carcass, slider(Z, 0.0, travel, rest=rest), leaf_name="translation_tray")


def add_larder(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> Link:
    """Add a tall front that slides out together with the shelves, baskets or racks behind it."""
    node = above.add(draw.pick(["drawer", "cabinet_door"], [2, 1]))
    height, back = fronts.face(opening).height, fronts.back_plane(opening)
    node.add("drawer_front", *fronts.panel(draw, opening))
    deep, half = opening.depth * draw.between(0.7, 0.95), draw.between(0.35, 0.48) * opening.width
    rod = min(0.06 * opening.width, 0.03)
    low, high = opening.low + 0.03 * height, opening.high - 0.03 * height
    x, far = opening.x, back - deep
    frame = [box_between((x - rod, low, far), (x + rod, high, far + 2 * rod))]
    frame.append(box_between((x - rod, high - 2 * rod, far), (x + rod, high, back)))
    if draw.chance(0.5):
        frame = [piece for s in (-1, 1) for piece in (move(part, (s * (half - rod), 0, 0)) for part in frame)]
    levels = low + (high - low) * np.linspace(0.0, 0.9, draw.integer(2, 6))
    wall = draw.between(0.1, 0.6) * (levels[1] - levels[0])
    form = draw.pick(["plate", "tub", "basket"])
    shelves = [piece for level in levels for piece in _larder_shelf(form, x, half, float(level), far, back, wall)]
    if draw.chance(0.5):
        node.add("drawer_box", *frame, *shelves)
    else:
        node.add("frame", *frame)
        for shelf in shelves:
            node.add("shelf", shelf)
    if fronts.has_handles:
        foot = (x, opening.y + draw.between(-0.2, 0.3) * height, back + 1.5 * fronts.thickness)
        length = min(fronts.handle_length, 0.4 * height)
        node.add("handle", *fronts.grip(draw, length, foot, opening, vertical=draw.chance(0.7)))
    travel = deep * draw.between(0.6, 1.0)
    rest = travel * draw.between(0.2, 0.95) if draw.chance(0.15) else 0.0
    return Link("drawer", [node], carcass, slider(Z, 0.0, travel, rest=rest))


def _larder_shelf(form: str, x: float, half: float, level: float, far: float, back: float, wall: float) -> list[Mesh]:
    """One shelf of a larder: a plate, a tub in one piece, or a basket with a rim of rods."""
    thin = 0.04 * half
    floor = box_between((x - half, level, far), (x + half, level + thin, back))
    if form == "plate":
        return [floor]
    top = level + wall
    if form == "tub":
        sides = [box_between((x + s * half - thin, level, far), (x + s * half + thin, top, back)) for s in (-1, 1)]
        ends = [box_between((x - half, level, z - thin), (x + half, top, z + thin)) for z in (far + thin, back - thin)]
        return [join(floor, *sides, *ends)]
    rims = [box_between((x + s * half - thin, top - thin, far), (x + s * half + thin, top, back)) for s in (-1, 1)]
    rims += [box_between((x - half, top - thin, z - thin), (x + half, top, z + thin)) for z in (far + thin, back - thin)]
    return [join(floor, *rims)]


def add_trim(draw: Draw, above: Node, carcass: Link, low: Point, high: Point) -> None:
    """Add fixed trim to a carcass between two corners [3]: skirting, cornices, pilasters, end panels, mouldings, splashbacks.

    Each is one leaf per board, or one leaf in all. They look like fronts, drawers and rails, and do not move.
    """
    (x0, y0, z0), (x1, y1, z1) = np.asarray(low, float), np.asarray(high, float)
    wide, tall, deep = x1 - x0, y1 - y0, z1 - z0
    thin = draw.ratio(0.008, 0.04) * min(wide, tall)
    kinds = ["skirting", "cornice", "pilaster", "end panel", "moulding", "splashback"]
    for kind in sorted({draw.pick(kinds, [4, 4, 2, 3, 2, 2]) for _ in range(draw.integer(1, 3))}):
        if kind == "skirting":
            rise, back = draw.between(0.04, 0.14) * tall, draw.pick([0.0, draw.between(0.02, 0.1) * deep])
            pieces = [box_between((x0, y0 - rise, z1 - back), (x1, y0, z1 - back + thin))]
            if draw.chance(0.6):
                ends = ((x0 - thin, x0), (x1, x1 + thin))
                pieces += [box_between((left, y0 - rise, z0), (right, y0, z1 - back)) for left, right in ends]
        elif kind == "cornice":
            steps, over = draw.integer(1, 3), draw.between(0.5, 2.0) * thin
            pieces = [
                box_between(
                    (x0 - step * over, y1 + (step - 1) * thin, z0), (x1 + step * over, y1 + step * thin, z1 + step * over)
                )
                for step in range(1, steps + 1)
            ]
        elif kind == "pilaster":
            half = draw.between(0.8, 2.5) * thin
            pieces = [
                box_between((x - half, y0, z1), (x + half, y1, z1 + draw.between(0.3, 1.2) * thin))
                for x in (x0 + half, x1 - half)
            ]
        elif kind == "end panel":
            inset = draw.pick([0.0, draw.between(0.05, 0.15)])
            spans = ((x0 - 0.5 * thin, x0), (x1, x1 + 0.5 * thin))
            near, far = z1 - inset * deep, z0 + inset * deep
            pieces = [box_between((left, y0 + inset * tall, far), (right, y1 - inset * tall, near)) for left, right in spans]
        elif kind == "moulding":
            level = y1 - draw.pick([0.0, draw.between(0.0, 0.1)]) * tall
            pieces = [box_between((x0 - 0.5 * thin, level - thin, z1), (x1 + 0.5 * thin, level, z1 + 0.6 * thin))]
        else:
            pieces = [box_between((x0, y1, z0), (x1, y1 + draw.between(0.08, 0.6) * min(tall, wide), z0 + 0.5 * thin))]
        name = draw.pick([kind.replace(" ", "_"), "other_leaf", "panel", "frame_horizontal_bar"], [4, 1, 1, 1])
        if draw.chance(0.5):
            carcass.nodes.append(above.add(name, *pieces))
        else:
            carcass.nodes += [above.add(name, piece) for piece in pieces]


def add_inner_shelves(draw: Draw, above: Node, carcass: Link, opening: Opening, board: float, setback: float) -> None:
    """Add one to three shelves behind the doors of an opening, `board` thick. They end `setback` behind its front."""
    for level in np.linspace(opening.low, opening.high, draw.integer(1, 3) + 2)[1:-1].tolist():
        low = (opening.x - opening.width / 2, level - board / 2, opening.front - opening.depth)
        high = (opening.x + opening.width / 2, level + board / 2, opening.front - setback)
        carcass.nodes.append(above.add("shelf", box_between(low, high)))


def add_false_front(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> None:
    """Add a fixed panel that looks like a drawer or a door, sometimes with a handle."""
    panel = fronts.panel(draw, opening)
    node = above.add(draw.pick(["vertical_front_panel", "frame_horizontal_bar", "other_leaf"], [4, 1, 1]), *panel)
    carcass.nodes += [node, *fronts.fit(draw, above, opening)]
    if draw.chance(0.5):
        at = (opening.x, opening.y, fronts.back_plane(opening) + 1.5 * fronts.thickness)
        grip = fronts.grip(draw, 0.3 * fronts.face(opening).width, at, opening, vertical=draw.chance(0.3))
        carcass.nodes.append(above.add("handle", *grip))


def add_leaning_drawer(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> Link:
    """Add a drawer or bin that slides out along a line leaning up or down."""
    link = add_drawer(draw, above, carcass, opening, fronts)
    pivot = (opening.x, opening.low, opening.front)
    most = min(np.degrees(np.arctan2(0.5 * opening.height, opening.depth)), 30.0)
    link.move(rotation_about(X, draw.sign() * draw.between(0.3, 1.0) * most, pivot))
    return link


def add_locked_door(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts, side: str) -> list[Link]:
    """Add a door with a knob, lever or key on it that turns about the door's normal."""
    plain = replace(fronts, has_handles=False)
    door = add_door(draw, above, carcass, opening, plain, side)
    out = 1.0 if side == "right" else -1.0
    at = (
        opening.x - out * draw.between(0.3, 0.42) * opening.width,
        opening.y + draw.between(-0.2, 0.2) * opening.height,
        plain.back_plane(opening) + plain.thickness,
    )
    kind = draw.pick(["dial", "lever", "tee", "cylinder"], [3, 3, 1, 2])
    group = door.nodes[0]
    door.nodes = list(group.children)
    return [door, add_door_lock(draw, group, door, kind, at, draw.between(0.04, 0.15))]


def add_casters(
    draw: Draw, above: Node, carcass: Link, x: float, z: float, low: float, *, always_moves: bool = False
) -> list[Link]:
    """Add four casters or wheels.

    Args:
        above: Node that they are added below.
        carcass: Link that they carry.
        x: Half distance along x.
        z: Half distance along z.
        low: Height of the carcass's underside.
        always_moves: Give the wheels joints.

    Returns:
        Links of casters that swivel about a vertical stem, and of wheels that roll. What does not move belongs to `carcass`.
    """
    radius = draw.ratio(0.02, 0.1)
    thick, drop = radius * draw.ratio(0.3, 1.2), radius * draw.between(2.15, 3.2)
    swivels, rolls, heading = draw.chance(0.6), always_moves or draw.chance(0.7), draw.between(0.0, 360.0)
    alike, links = draw.chance(0.6), []
    places = ((x, z), (-x, z), (x, -z), (-x, -z))
    for own, (right, ahead) in zip(draw.identical(len(places)), places, strict=True):
        angle = 0.0 if not swivels else heading if alike else draw.between(0.0, 360.0)
        stem = (right, low, ahead)
        links += add_caster(own, above, carcass, stem, drop, radius, thick, heading=angle, swivels=swivels, rolls=rolls)
    return links
