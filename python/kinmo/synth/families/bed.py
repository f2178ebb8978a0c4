"""Beds with drawers, lifting or folding tops and side rails, and wheels below some."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework import add_drawer, legs
from kinmo.synth.details.casework_extras import add_casters
from kinmo.synth.details.casework_filling import on_side
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, facing, join, rounded_box, rounded_path, sweep
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Bed that lies along z, with its head at the rear.

    Variants: a bed with drawers at its sides and foot, sometimes with a top that lifts up; and a nursing bed whose back and
    leg sections fold up, with rails at the sides that slide or fold down, casters, and cranks that turn.
    """
    root = Node("bed")
    width, length = draw.ratio(0.7, 2.0), draw.ratio(1.7, 2.3)
    if draw.chance(0.5):
        width = min(width, 1.3)
        links = _nursing_bed(draw, root, width, length)
    else:
        links = _storage_bed(draw, root, width, length)
    return SynthObject("Bed", root, links)


def _board(draw: Draw, width: float, low: float, high: float, z: float, thick: float) -> list[Mesh]:
    """Meshes of a head or foot board: a plate, posts with rails, or a bent tube with bars."""
    kind = draw.pick(["plate", "bars", "tube"], [3, 2, 1])
    x = width / 2
    if kind == "plate":
        return [rounded_box((width, high - low, thick), draw.pick([0.001, 0.2]) * (high - low), "z", (0, (low + high) / 2, z))]
    if kind == "bars":
        posts = [box_between((s * x - thick, low, z - thick), (s * x + thick, high, z + thick)) for s in (-1, 1)]
        rails = [box((width, 1.5 * thick, 0.8 * thick), (0, y, z)) for y in np.linspace(low + thick, high - thick, 3)]
        return [*posts, *rails]
    path = rounded_path(np.array([(-x, low, z), (-x, high, z), (x, high, z), (x, low, z)]), 0.3 * (high - low))
    uprights = [cylinder(0.3 * thick, high - low, "y", (u * x, (low + high) / 2, z), 8) for u in np.linspace(-0.7, 0.7, 5)]
    return [sweep(path, 0.6 * thick, 8), *uprights]


def _storage_bed(draw: Draw, root: Node, width: float, length: float) -> list[Link]:
    """A bed on a box or legs, with drawers below it or a top that lifts up."""
    board, tall, low = draw.ratio(0.015, 0.05), draw.between(0.18, 0.45), draw.between(0.0, 0.2)
    x, z, top = width / 2, length / 2, low + tall
    base = Link("bed_frame", [], kind=draw.pick([JointType.STATIC, JointType.HEAVY]))
    links = [base]
    thick = draw.ratio(0.03, 0.08)
    lifts = draw.chance(0.35)
    sides = draw.pick([(X,), (-X,), (X, -X), (Z,), (X, -X, Z)], [2, 2, 4, 1, 1])
    deep = 0.45 * width if len(sides) > 1 else 0.8 * width
    frame = [box_between((-x, top - board, -z), (x, top, z)), box_between((-x, low, -z), (x, low + board, z))]
    if lifts:
        frame = [box_between((s * x - board, low, -z), (s * x + board, top, z)) for s in (-1, 1)] + [frame[1]]
        frame += [box_between((-x, low, s * z - board), (x, top, s * z + board)) for s in (-1, 1)]
    else:
        frame += [
            box_between((-board, low, -z), (board, top - board, z - 0.3 * length if any(side[2] for side in sides) else z))
        ]
    base.nodes.append(root.add("bed_frame", *frame))
    if low > 0.03:
        for leg in legs(draw, x - thick, z - thick, 0.0, low, thick):
            base.nodes.append(root.add("leg", leg))
    if draw.chance(0.85):
        head = top + draw.between(0.3, 0.9)
        base.nodes.append(root.add("headboard", *_board(draw, width, low, head, -z - thick, thick)))
    if draw.chance(0.4):
        foot = top + draw.between(0.05, 0.4)
        if not any(side[2] > 0 for side in sides):
            base.nodes.append(root.add("footboard", *_board(draw, width, low, foot, z + thick, thick)))
    mattress = rounded_box((0.97 * width, 0.2, 0.98 * length), 0.08, "y", (0, top + 0.1, 0))
    if lifts:
        platform = box_between((-x + board, top, -z + board), (x - board, top + board, z - board))
        node = root.add("lid", platform)
        node.pieces += [mattress] if draw.chance(0.8) else []
        if draw.chance(0.4):
            strap = pull(draw, 0.3, (0, top + board / 2, z - board), vertical=False, thickness=0.02, reach=0.05)
            node.pieces += strap
        opens = draw.between(30.0, 70.0)
        motion = hinge((0, top, -z + board), -X, 0.0, opens, rest=draw.pick([0.0, draw.between(0.3, 1.0) * opens], [3, 1]))
        links.append(Link("lid", [node], base, motion, leaf_name="rotation_lid"))
        return links
    if draw.chance(0.85):
        base.nodes.append(root.add("mattress", mattress))
        for side in draw.pick([(0.0,), (-1.0, 1.0), ()]):
            pillow = rounded_box((0.4 * width, 0.1, 0.35), 0.1, "y", (side * 0.24 * width, top + 0.25, -z + 0.25))
            base.nodes.append(root.add("pillow", pillow))
    fronts = Fronts.random(draw, board)
    for side in sides:
        room = length if side[0] else width
        count = draw.integer(1, 3) if side[0] else draw.integer(1, 2)
        span = draw.pick([0.98, draw.between(0.5, 0.95)]) * room
        wide = span / count
        reach = min(deep, 0.3 * length) if side[2] else deep

        def drawers(carcass: Link, count: int = count, wide: float = wide, reach: float = reach) -> list[Link]:
            cells = [wide * (index + 0.5 - count / 2) for index in range(count)]
            height = tall - 2 * board
            border = (0.5 * board, 0.5 * board, board, board)
            openings = [Opening(x, low + tall / 2, wide - board, height, reach - 2 * board, 0.0, border) for x in cells]
            return [add_drawer(draw, root, carcass, opening, fronts) for opening in openings]

        links += on_side(base, facing(side, Y, side * (x if side[0] else z)), drawers)
    return links


def _nursing_bed(draw: Draw, root: Node, width: float, length: float) -> list[Link]:
    """A bed on a frame with casters, with sections that fold up and rails at its sides."""
    x, z, level = width / 2, length / 2, draw.between(0.4, 0.7)
    rod = draw.ratio(0.015, 0.04)
    beams = [box_between((s * 0.85 * x - rod, level - 2 * rod, -z), (s * 0.85 * x + rod, level, z)) for s in (-1, 1)]
    beams += [box((1.8 * x, 2 * rod, 2 * rod), (0, level - rod, place)) for place in np.linspace(-z + rod, z - rod, 4)]
    base = Link("bed_frame", [root.add("bed_frame", *([join(*beams)] if draw.chance(0.5) else beams))])
    links = [base]
    kind = draw.pick(["casters", "legs", "column"], [4, 2, 1])
    if kind == "casters":
        lower = box((1.5 * x, 2 * rod, 1.7 * z), (0, 0.2, 0))
        posts = [
            box_between((s * 0.6 * x - rod, 0.2, t * 0.7 * z - rod), (s * 0.6 * x + rod, level - 2 * rod, t * 0.7 * z + rod))
            for s in (-1, 1)
            for t in (-1, 1)
        ]
        base.nodes.append(root.add("base", lower, *posts))
        links += add_casters(draw, root, base, 0.65 * x, 0.8 * z, 0.2 - rod)
    elif kind == "legs":
        for leg in legs(draw, 0.85 * x, 0.9 * z, 0.0, level - 2 * rod, 2 * rod):
            base.nodes.append(root.add("leg", leg))
    else:
        base.nodes.append(root.add("base", box((x, level - 2 * rod, z), (0, (level - 2 * rod) / 2, 0))))
    thick = draw.ratio(0.02, 0.16)
    links += _sections(draw, root, base, x, z, level, thick)
    for place, rise, name in ((-z, draw.between(0.3, 0.7), "headboard"), (z, draw.between(0.2, 0.5), "footboard")):
        if draw.chance(0.85):
            end = place + np.sign(place) * 2 * rod
            node = root.add(name, *_board(draw, 1.9 * x, level - 4 * rod, level + rise, end, rod))
            base.nodes.append(node)
    if draw.chance(0.8):
        links += _rails(draw, root, base, x, z, level, rod)
    if draw.chance(0.25):
        crank_at = np.array([draw.between(-0.5, 0.5) * x, level - 3 * rod, z + 4 * rod])
        arm = np.array([(0, 0, 0), (0, 0, 0.08), (0, -0.12, 0.08), (0, -0.12, 0.18)]) + crank_at
        node = root.add(draw.pick(["crank", "handle"]), sweep(rounded_path(arm, 0.01), 0.4 * rod, 8))
        links.append(Link("crank", [node], base, spinner(crank_at, Z)))
    return links


def _sections(draw: Draw, root: Node, base: Link, x: float, z: float, level: float, thick: float) -> list[Link]:
    """The lying surface: a back section that folds up about its lower edge, a fixed seat, and sometimes leg sections."""
    back_end = -z + draw.between(0.35, 0.5) * 2 * z
    leg_start = back_end + draw.between(0.1, 0.25) * 2 * z
    gap = 0.005
    soft = draw.pick([0.0, draw.between(0.08, 0.16)])

    def section(name: str, low: float, high: float) -> Node:
        pieces = [box_between((-0.93 * x, level, low + gap), (0.93 * x, level + thick, high - gap))]
        if soft:
            pieces.append(box_between((-0.9 * x, level + thick, low + gap), (0.9 * x, level + thick + soft, high - gap)))
        return root.add(name, *pieces)

    names = draw.pick([("backrest", "seat", "legrest"), ("back", "surface", "footrest"), ("mattress", "mattress", "mattress")])
    pivot = level + draw.pick([0.0, 0.5, 1.0]) * thick
    opens = draw.between(45.0, 85.0)
    rest = draw.pick([0.0, draw.between(0.2, 1.0) * opens])
    back = section(names[0], -z, back_end)
    links = [Link("backrest", [back], base, hinge((0, pivot, back_end), X, 0.0, opens, rest=rest), leaf_name="backrest")]
    base.nodes.append(section(names[1], back_end, leg_start))
    if draw.chance(0.3):
        base.nodes.append(section(names[2], leg_start, z))
        return links
    lifts = draw.between(15.0, 45.0)
    knee = leg_start + draw.between(0.4, 0.6) * (z - leg_start)
    shown = draw.pick([0.0, draw.between(0.2, 1.0) * lifts])
    motion = hinge((0, pivot, leg_start), -X, 0.0, lifts, rest=shown)
    if draw.chance(0.5):
        links.append(Link("legrest", [section(names[2], leg_start, z)], base, motion))
        return links
    thigh = Link("legrest", [section(names[2], leg_start, knee)], base, motion)
    shin = Link("footrest", [section(names[2], knee, z)], thigh, hinge((0, pivot, knee), X, 0.0, 1.3 * lifts, rest=shown))
    return [*links, thigh, shin]


def _rails(draw: Draw, root: Node, base: Link, x: float, z: float, level: float, rod: float) -> list[Link]:
    """One or two rails at each side that slide down, or fold down about their lower edge or about their posts' feet."""
    kind = draw.pick(["slide", "fold", "fixed"], [5, 3, 1])
    halves = draw.pick([((-0.85, 0.85),), ((-0.9, -0.05), (0.05, 0.9)), ((-0.6, 0.2),)], [2, 2, 2])
    tall = draw.between(0.25, 0.45)
    look = draw.pick(["bars", "plate", "levels"], [3, 1, 2])
    links: list[Link] = []
    for sign in (-1.0, 1.0):
        for start, end in halves:
            at, low, high = sign * (x + 2 * rod), start * z, end * z
            bottom, top = level + 0.02, level + 0.02 + tall
            if look == "plate":
                pieces = [box_between((at - rod / 2, bottom, low), (at + rod / 2, top, high))]
            else:
                corners = np.array([(at, bottom, low), (at, top, low), (at, top, high), (at, bottom, high)])
                pieces = [sweep(rounded_path(corners, 0.2 * tall), 0.6 * rod, 8)]
                pieces.append(cylinder(0.5 * rod, high - low, "z", (at, bottom, (low + high) / 2), 8))
                if look == "bars":
                    places = np.linspace(low, high, max(3, int((high - low) / 0.15)))[1:-1]
                    pieces += [cylinder(0.4 * rod, tall, "y", (at, (bottom + top) / 2, place), 8) for place in places]
                else:
                    levels = np.linspace(bottom, top, draw.integer(3, 5))[1:-1]
                    pieces += [cylinder(0.4 * rod, high - low, "z", (at, y, (low + high) / 2), 8) for y in levels]
            node = root.add(draw.pick(["rail", "side_rail", "guard"]), *pieces)
            if kind == "fixed":
                base.nodes.append(node)
                continue
            if kind == "slide":
                travel = tall * draw.between(0.6, 1.0)
                rest = draw.pick([0.0, draw.between(0.2, 1.0) * travel], [3, 1])
                motion = slider(-Y, 0.0, travel, rest=rest)
            else:
                motion = hinge((at + sign * rod, bottom, 0), -sign * Z, 0.0, draw.between(120.0, 180.0))
            links.append(Link("rail", [node], base, motion))
    return links
