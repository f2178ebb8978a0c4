"""Closures of bottles, around the y axis: caps, flip tops, nozzles, stoppers, clasps, pumps and trigger sprayers.

Each function adds nodes below `unit` and returns links that hang on `base`. `neck` is the radius of the neck and `top` the
height of its rim.
"""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.lid_hinges import lid_hinge
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    box,
    cylinder,
    ellipsoid,
    extrude,
    lathe,
    move,
    rotation_about,
    rounded_box,
    rounded_outline,
    rounded_path,
    sweep,
    torus,
    tube,
    turn,
)
from kinmo.synth.synth_object import Link, Motion, Node, hinge, screw, slider, spinner

CLOSED_WALL_SHARE = 0.6
"""Share of caps that are solid rather than hollow."""


def cap_pieces(draw: Draw, radius: float, height: float) -> list[Mesh]:
    """Meshes of a cap with its foot at the origin: a drum, cone or dome, ribbed, stepped, with flat sides or a nozzle."""
    segments = draw.pick([8, 16, 24, 32])
    kind = draw.pick(["plain", "tapered", "ribbed", "domed", "stepped", "sided", "nozzle", "knob"], [4, 2, 4, 2, 1, 1, 1, 1])
    if kind == "ribbed":
        return _ribbed(draw, radius, height)
    if kind == "sided":
        across = 2 * radius * draw.between(0.85, 1.0)
        outline = rounded_outline(across, across * draw.between(0.7, 1.0), draw.between(0.0, 0.4) * radius)
        return [extrude(outline, height, "y", (0, 0.5 * height, 0))]
    if kind == "domed":
        share, low = np.linspace(0, 0.5 * np.pi, 6), draw.between(0.1, 0.8)
        skin = np.stack([radius * np.cos(share), height * (low + (1 - low) * np.sin(share))], 1)
        return [lathe(np.concatenate([[[0.0, 0.0], [radius, 0.0]], skin]), segments)]
    if kind == "stepped":
        step, inner = draw.between(0.2, 0.7), draw.between(0.6, 0.9)
        profile = np.array([[0, 0], [1, 0], [1, step], [inner, step], [inner, 1], [0, 1]])
        return [lathe(profile * (radius, height), segments)]
    upper = radius * (draw.between(0.4, 1.15) if kind == "tapered" else 1.0)
    if kind == "plain" and not draw.chance(CLOSED_WALL_SHARE):
        wall = draw.between(0.04, 0.12)
        hollow = np.array([[0, 1 - wall], [1 - wall, 1 - wall], [1 - wall, 0], [1, 0], [1, 1], [0, 1]])
        return [lathe(hollow * (radius, height), segments)]
    pieces = [cylinder(radius, height, "y", (0, 0.5 * height, 0), segments, top_radius=upper)]
    if kind == "nozzle":
        tall = height * draw.ratio(0.3, 2.5)
        pieces.append(
            cylinder(draw.between(0.15, 0.6) * radius, tall, "y", (0, height + 0.5 * tall, 0), 14, top_radius=0.12 * radius)
        )
    elif kind == "knob":
        size = radius * draw.between(0.25, 0.6)
        pieces.append(ellipsoid((size, size, size), (0, height + 0.7 * size, 0)))
    return pieces


def _ribbed(draw: Draw, radius: float, height: float) -> list[Mesh]:
    """A cap with ribs of any number and depth, cut into one mesh or standing on a drum, over the whole height or a part."""
    count, depth = draw.pick([6, 8, 12, 16, 24, 36, 48]), draw.ratio(0.015, 0.15)
    tall = height * draw.pick([1.0, draw.between(0.4, 0.9)])
    if draw.chance(0.6):
        angle = np.linspace(0, 2 * np.pi, 4 * count, endpoint=False)
        wave = np.sign(np.sin(count * angle + 0.1)) if draw.chance(0.5) else np.sin(count * angle)
        reach = radius * (1 + depth * wave)
        pieces = [extrude(np.stack([reach * np.cos(angle), reach * np.sin(angle)], 1), tall, "y", (0, 0.5 * tall, 0))]
        return pieces if tall == height else [*pieces, cylinder(0.95 * radius, height, "y", (0, 0.5 * height, 0), 24)]
    count = min(count, 24)
    rib = box((2 * np.pi * radius / count * 0.4, tall, 2 * depth * radius), (0, 0.5 * tall, radius))
    drum = cylinder(radius, height, "y", (0, 0.5 * height, 0), 24)
    return [drum, *(turn(rib, Y, 360.0 * index / count) for index in range(count))]


def _screwing(draw: Draw, low: float, rise: float) -> Motion:
    """Screw up to `rise` off a neck, stated along either direction."""
    origin = (0.0, draw.pick([0.0, low]), 0.0)
    turns = draw.pick([180.0, 360.0, None], [4, 1, 1])
    if draw.chance(0.7):
        return screw(origin, Y, 0.0, rise, turns=turns)
    return screw(origin, -Y, -rise, 0.0, turns=turns)


def add_cap(draw: Draw, unit: Node, base: Link, neck: float, top: float, most: float) -> list[Link]:
    """Add a cap, at most `most` high, that screws, lifts off or tips about an edge."""
    kind = draw.pick(["screw", "lift", "tip"], [6, 2, 2])
    height = min(neck * draw.ratio(0.2, 3.0), most)
    pieces = cap_pieces(draw, neck * draw.between(1.02, 1.3), height)
    low = top - draw.pick([height * draw.between(0.4, 0.98), 0.0], [4, 1])
    rise = draw.between(0.4, 1.3) * height
    strap: list[Mesh] = []
    if kind == "screw":
        motion = _screwing(draw, low, rise)
    elif kind == "lift":
        motion = slider(Y, 0.0, rise)
    else:
        at = (0.0, low + draw.pick([0.0, 0.1 * height]), -neck * draw.between(1.0, 1.2))
        opens = draw.between(80.0, 180.0)
        motion = hinge(at, X, -opens, 0.0, rest=-draw.between(0.15, 1.0) * opens if draw.chance(0.4) else 0.0)
        strap = lid_hinge(draw, at, neck, 0.1 * neck)
        facing = draw.pick([0.0, 90.0, 180.0, 270.0], [4, 1, 1, 1])
        motion = motion.moved_by(rotation_about(Y, facing))
        pieces, strap = ([turn(piece, Y, facing) for piece in part] for part in (pieces, strap))
    lid = unit.add(draw.pick(["lid", "closure", "cap"], [6, 2, 1]), *(move(piece, (0, low, 0)) for piece in pieces), *strap)
    return [Link(draw.pick(["lid", "closure"]), [lid], base, motion)]


def add_flip_top(draw: Draw, unit: Node, base: Link, neck: float, top: float, most: float) -> list[Link]:
    """Add a collar on the neck that screws or is fixed, with a lid that tips about its edge or a disc that tips in it."""
    radius, height = neck * draw.between(1.05, 1.4), min(neck * draw.ratio(0.4, 2.0), most)
    share = draw.between(0.3, 0.8)
    low = top - height * draw.between(0.2, 0.7)
    split = low + share * height
    collar = Link("closure", [unit.add("closure", *_moved(collar_pieces(draw, radius, share * height), low))], base)
    links = [collar]
    if draw.chance(0.5):
        collar.motion = _screwing(draw, low, share * height)
    facing = draw.pick([0.0, 90.0, 180.0, 270.0], [4, 1, 1, 1])
    if draw.chance(0.7):
        lid = collar_pieces(draw, radius, (1 - share) * height)
        at = (0.0, split, -radius * draw.between(0.9, 1.05))
        opens = draw.between(80.0, 175.0)
        motion = hinge(at, X, -opens, 0.0, rest=-draw.between(0.2, 1.0) * opens if draw.chance(0.4) else 0.0)
        pieces = [*_moved(lid, split), *lid_hinge(draw, at, radius, 0.1 * radius)]
        if draw.chance(0.5):
            spout = draw.between(0.1, 0.3) * radius
            collar.nodes[0].pieces.append(cylinder(spout, 0.3 * (1 - share) * height, "y", (0, split, 0), 12))
    else:
        thick = (1 - share) * height * draw.between(0.15, 0.6)
        pieces = [cylinder(0.8 * radius, thick, "y", (0, split + 0.4 * thick, 0), 24)]
        tips = draw.between(12.0, 35.0)
        motion = hinge((0, split + 0.4 * thick, 0), X * draw.sign(), *draw.pick([(0.0, tips), (-tips, 0.0)]))
    node = unit.add(draw.pick(["lid", "flip_lid", "head"], [4, 1, 1]), *(turn(piece, Y, facing) for piece in pieces))
    return [*links, Link("lid", [node], collar, motion.moved_by(rotation_about(Y, facing)))]


def add_nozzle_top(draw: Draw, unit: Node, base: Link, neck: float, top: float, most: float) -> list[Link]:
    """Add a collar on the neck that screws or is fixed, with a nozzle that pulls up, screws up or turns."""
    radius, height = neck * draw.between(1.02, 1.3), min(neck * draw.ratio(0.3, 1.5), 0.6 * most)
    low = top - height * draw.between(0.3, 0.9)
    collar = Link("closure", [unit.add("closure", *_moved(collar_pieces(draw, radius, height), low))], base)
    if draw.chance(0.5):
        collar.motion = _screwing(draw, low, height)
    thin, tall = radius * draw.between(0.2, 0.7), min(neck * draw.ratio(0.3, 2.0), most)
    foot = low + height
    profile = np.array([[0, -0.3], [0.8, -0.3], [0.8, 0.5], [1, 0.6], [1, 0.9], [0.6, 1], [0, 1]]) * (thin, tall)
    pieces = [move(lathe(profile, draw.pick([10, 16, 24])), (0, foot, 0))]
    up = draw.between(0.2, 0.6) * tall
    origin = (0.0, draw.pick([0.0, foot]), 0.0)
    motion = draw.pick(
        [slider(Y, 0.0, up), screw(origin, Y, 0.0, up, turns=draw.pick([180.0, None])), spinner(origin, Y)], [4, 2, 1]
    )
    return [collar, Link("nozzle", [unit.add(draw.pick(["nozzle", "lid", "mouth"]), *pieces)], collar, motion)]


def add_stopper(draw: Draw, unit: Node, base: Link, neck: float, top: float, most: float) -> list[Link]:
    """Add a cork or a glass stopper with a head that lifts out of the neck, or a dropper with a bulb that screws off."""
    plug, head = 0.82 * neck, neck * draw.between(0.7, 1.6)
    deep, tall = min(neck * draw.ratio(0.4, 2.0), 0.3 * most), min(neck * draw.ratio(0.4, 2.5), most)
    if draw.chance(0.3):
        pipette = cylinder(0.15 * neck, 2.0 * deep, "y", (0, top - deep, 0), 10)
        bulb = ellipsoid((0.6 * neck, 0.5 * tall, 0.6 * neck), (0, top + 0.6 * tall, 0))
        grip = _moved(collar_pieces(draw, 1.1 * neck, 0.4 * tall), top - 0.2 * tall)
        node = unit.add(draw.pick(["lid", "closure", "cap"]), *grip, bulb, pipette)
        return [Link("lid", [node], base, _screwing(draw, top, draw.between(0.3, 0.6) * tall))]
    pieces = [cylinder(plug, deep, "y", (0, top - 0.5 * deep, 0), 20, top_radius=draw.between(0.9, 1.0) * neck)]
    if draw.chance(0.75):
        ball = ellipsoid((head, 0.5 * tall, head), (0, top + 0.45 * tall, 0), 20, 10)
        pieces.append(ball if draw.chance(0.4) else move(cap_pieces(draw, head, tall)[0], (0, top, 0)))
    else:
        pieces.append(cylinder(0.95 * neck, 0.5 * tall, "y", (0, top + 0.25 * tall, 0), 20))
    node = unit.add(draw.pick(["lid", "stopper", "closure"]), *pieces)
    return [Link("lid", [node], base, slider(Y, 0.0, deep * draw.between(0.8, 1.5)))]


def add_swing_top(draw: Draw, unit: Node, base: Link, neck: float, top: float) -> list[Link]:
    """Add a stopper on a wire bow that swings about a line through the neck."""
    head, wire = neck * draw.between(0.9, 1.15), neck * draw.between(0.05, 0.1)
    pin = top - neck * draw.between(0.4, 1.0)
    out, crown = 1.1 * neck + wire, top + 0.5 * neck
    path = rounded_path(np.array([(-out, pin, 0), (-out, crown, 0), (out, crown, 0), (out, pin, 0)]), 0.3 * neck)
    pieces = [sweep(path, wire, 6), cylinder(head, 0.7 * neck, "y", (0, top + 0.35 * neck, 0), 20, top_radius=0.7 * head)]
    base.nodes[0].pieces.append(torus(1.05 * neck, 1.3 * wire, "y", (0, pin, 0), 20, 6))
    opens = draw.between(90.0, 150.0)
    motion = hinge((draw.pick([0.0, out]), pin, 0), X * draw.sign(), 0.0, opens, rest=draw.pick([0.0, opens], [3, 1]))
    return [Link("lid", [unit.add(draw.pick(["lid", "closure", "stopper"]), *pieces)], base, motion)]


def add_pump(draw: Draw, unit: Node, base: Link, neck: float, top: float) -> list[Link]:
    """Add a pump: a collar that may screw, and a head that slides down, sometimes under a cover that lifts off."""
    collar_height, travel = neck * draw.ratio(0.3, 1.2), neck * draw.ratio(0.4, 1.8)
    radius = neck * draw.between(1.0, 1.3)
    closure = Link(
        "closure", [unit.add("closure", *_moved(collar_pieces(draw, radius, collar_height), top - 0.5 * collar_height))], base
    )
    if draw.chance(0.5):
        closure.motion = screw((0, top, 0), Y, 0.0, collar_height, turns=draw.pick([180.0, None]))
    foot = top + 0.5 * collar_height
    stem_top = foot + travel + 0.15 * neck
    thick = neck * draw.between(0.12, 0.35)
    head = [cylinder(thick, stem_top - foot + 0.5 * travel, "y", (0, 0.5 * (stem_top + foot - 0.5 * travel), 0), 12)]
    head += [move(piece, (0, stem_top, 0)) for piece in _pump_head(draw, neck, thick)]
    heading = draw.pick([0.0, 90.0, 180.0, 270.0, draw.between(0.0, 360.0)])
    pressed = slider(Y, -travel, 0.0) if draw.chance(0.7) else slider(-Y, 0.0, travel)
    node = unit.add(draw.pick(["head", "lid", "pump"]), *(turn(piece, Y, heading) for piece in head))
    links = [closure, Link("pump", [node], closure, pressed)]
    if draw.chance(0.12):
        tall = max(piece.vertices[:, 1].max() for piece in head) + 0.1 * neck - foot
        wide = 1.05 * max(np.linalg.norm(piece.vertices[:, [0, 2]], axis=1).max() for piece in head)
        cover = cylinder(wide, tall, "y", (0, foot + 0.5 * tall, 0), 24, capped=False)
        lid = cylinder(wide, 0.05 * neck, "y", (0, foot + tall, 0), 24)
        links.append(Link("cover", [unit.add(draw.pick(["cover", "lid"]), cover, lid)], base, slider(Y, 0.0, 0.9 * tall)))
    return links


def _pump_head(draw: Draw, neck: float, thick: float) -> list[Mesh]:
    """A head on the stem's end at the origin: with a spout to +z, or a button."""
    kind = draw.pick(["spout", "wedge", "button", "saddle"], [4, 2, 2, 1])
    size = neck * draw.between(0.4, 0.9)
    if kind == "button":
        tall = size * draw.ratio(0.5, 2.0)
        pieces = [cylinder(size, tall, "y", (0, 0.5 * tall, 0), 20, top_radius=size * draw.between(0.8, 1.0))]
        return [*pieces, cylinder(0.15 * size, 0.3 * size, "z", (0, 0.6 * tall, size), 8)] if draw.chance(0.6) else pieces
    reach = neck * draw.ratio(1.0, 4.0)
    if kind == "wedge":
        outline = np.array([[-0.6 * size, 0.0], [reach, 0.1 * size], [reach, 0.35 * size], [-0.6 * size, 0.7 * size]])
        return [extrude(outline[:, ::-1][::-1], 1.1 * size, "x")]
    drop = draw.between(-0.1, 0.35) * reach
    path = np.array([(0, 0.1 * neck, 0), (0, 0.15 * neck, 0.7 * reach), (0, 0.15 * neck - drop, reach)])
    pieces = [cylinder(size, 0.4 * neck, "y", (0, 0.1 * neck, 0), 16), sweep(rounded_path(path, 0.25 * reach), thick, 10)]
    if kind == "saddle":
        pieces.append(box((1.2 * neck, 0.1 * neck, 1.6 * neck), (0, 0.35 * neck, 0)))
    return pieces


def add_aerosol(draw: Draw, unit: Node, base: Link, neck: float, top: float, most: float) -> list[Link]:
    """Add a button that is pressed into a fixed collar, sometimes under a cap that lifts off."""
    radius, tall = neck * draw.between(0.3, 0.75), neck * draw.ratio(0.3, 1.2)
    collar = cylinder(neck * draw.between(1.0, 1.3), 0.4 * tall, "y", (0, top + 0.1 * tall, 0), 24, top_radius=neck)
    base.nodes.append(unit.add("closure", collar))
    pieces = [cylinder(radius, tall, "y", (0, top + 0.75 * tall, 0), 16, top_radius=radius * draw.between(0.7, 1.0))]
    if draw.chance(0.6):
        pieces.append(box((0.5 * radius, 0.25 * tall, 0.4 * radius), (0, top + 0.9 * tall, radius)))
    links = [Link("button", [unit.add(draw.pick(["button", "head", "lid"]), *pieces)], base, slider(Y, -0.2 * tall, 0.0))]
    if draw.chance(0.35):
        wide, high = 1.35 * neck * draw.between(1.0, 1.2), min(1.5 * tall, most)
        profile = np.array([[0.93, 0], [1, 0], [1, 1], [0, 1], [0, 0.93], [0.93, 0.93], [0.93, 0]]) * (wide, high)
        cover = move(lathe(profile, 24), (0, top - 0.1 * tall, 0))
        links.append(Link("lid", [unit.add(draw.pick(["lid", "cap"]), cover)], base, slider(Y, 0.0, 0.9 * high)))
    return links


def add_trigger(draw: Draw, unit: Node, base: Link, neck: float, top: float) -> list[Link]:
    """Add a sprayer: a trigger that turns about a horizontal line or slides, and sometimes a nozzle that turns."""
    size = max(neck, 0.1) * draw.between(0.8, 1.6)
    long, wide, tall = size * draw.ratio(1.5, 3.0), size * draw.between(0.35, 0.8), size * draw.between(0.35, 0.8)
    rise = draw.between(1.2, 2.0) * size
    closure = Link(
        "closure", [unit.add("closure", *_moved(collar_pieces(draw, 1.1 * neck, 0.6 * size), top - 0.3 * size))], base
    )
    if draw.chance(0.4):
        closure.motion = screw((0, top, 0), Y, 0.0, 0.6 * size, turns=draw.pick([180.0, None]))
    center = (0, top + rise, 0.5 * long - 0.8 * size)
    head = (
        box((wide, tall, long), center)
        if draw.chance(0.5)
        else rounded_box((wide, tall, long), 0.4 * tall, draw.pick(["x", "z"]), center)
    )
    post = box((0.8 * wide, rise, 0.6 * size), (0, top + 0.5 * rise, -0.2 * size))
    sprayer = Link("sprayer", [unit.add("head", head, post)], closure)
    front = center[2] + 0.5 * long
    pin = (0.0, top + rise - 0.4 * tall, draw.between(0.45, 0.9) * front)
    length = draw.between(0.6, 1.0) * rise
    blade = box((0.6 * wide, length, 0.2 * size), (0, pin[1] - 0.5 * length, pin[2]))
    squeezed = hinge(pin, X, 0.0, draw.between(10.0, 35.0)) if draw.chance(0.8) else slider((0, 0, -1), 0.0, 0.3 * size)
    trigger = unit.add("trigger", turn(blade, X, -draw.between(0.0, 30.0), pin))
    links = [closure, sprayer, Link("trigger", [trigger], sprayer, squeezed)]
    if draw.chance(0.6):
        at = (0.0, top + rise, front + 0.12 * size)
        tip = cylinder(0.5 * tall, 0.3 * size, "z", at, draw.pick([4, 6, 16]))
        links.append(Link("nozzle", [unit.add("nozzle", tip)], sprayer, spinner(at, (0, 0, 1))))
    return links


def collar_pieces(draw: Draw, radius: float, height: float) -> list[Mesh]:
    """Meshes of a collar with its foot at the origin: a drum, or a ribbed drum."""
    if draw.chance(0.35):
        return _ribbed(draw, radius, height)
    if draw.chance(0.3):
        return [tube(radius, 0.8 * radius, height, "y", (0, 0.5 * height, 0), 24)]
    return [
        cylinder(
            radius, height, "y", (0, 0.5 * height, 0), draw.pick([12, 20, 32]), top_radius=draw.between(0.85, 1.0) * radius
        )
    ]


def _moved(pieces: list[Mesh], height: float) -> list[Mesh]:
    return [move(piece, (0, height, 0)) for piece in pieces]
