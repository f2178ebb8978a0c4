"""Doors of furniture besides hinged ones: sliding, hanging and folding doors, roll tops, and parts behind doors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework import add_door, add_drawer
from kinmo.synth.details.casework_fronts import Fronts, Opening, front_panel
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, X, Y, box, box_between, cylinder, extrude, move, tube
from kinmo.synth.synth_object import Link, Node, hinge, slider

SLIDING_LOOKS = ("plain", "framed", "slatted", "raised")
"""Looks of doors that slide."""


def add_sliding_doors(
    draw: Draw, above: Node, carcass: Link, opening: Opening, thickness: float, *, upwards: bool | None = None
) -> list[Link]:
    """Add one to three doors on parallel tracks in an opening, which slide sideways or upwards.

    The first track is within the opening, flush with the carcass, or in front of it. A single door covers a part of the
    opening, sometimes next to a fixed panel.

    Args:
        draw: Source of all random values.
        above: Node that the doors are added below.
        carcass: Link that carries the doors.
        opening: The opening.
        thickness: Thickness of each door.
        upwards: Slide upwards, or else sideways; None for either.

    Returns:
        Links of the doors.
    """
    count = draw.pick([1, 2, 3], [2, 5, 1])
    upwards = draw.chance(0.15) if upwards is None else upwards
    room = opening.height if upwards else opening.width
    share = draw.between(0.4, 0.65) if count == 1 else draw.between(1.0, 1.12) / count
    size = (opening.width, share * room) if upwards else (share * room, opening.height)
    axis, look, inner = Y if upwards else X, draw.pick(SLIDING_LOOKS, [5, 2, 2, 1]), 0.5 * (room - share * room)
    places = [draw.sign() * inner] if count == 1 else list(np.linspace(-inner, inner, count))
    tracks = [index % 2 for index in range(count)] if draw.chance(0.7) else list(range(count))
    face = opening.front + draw.pick([0.0, -thickness, 1.2 * thickness, 2.4 * thickness], [4, 2, 1, 2])
    pitch = 1.5 if look == "raised" else 1.1
    has_handles, links = draw.chance(0.7), []
    for place, track in zip(places, tracks, strict=True):
        at = axis * place + (opening.x, opening.y, face - (pitch * track + 1.0) * thickness)
        node = above.add("cabinet_door")
        node.add("cabinet_door_surface", *(move(piece, at) for piece in front_panel(draw, *size, thickness, look)))
        if has_handles and (track == 0 or draw.chance(0.5)):
            aside = draw.pick([0.0, -0.4, 0.4]) * share * room
            foot = at + axis * aside + (0, 0, thickness)
            node.add("handle", *_sliding_grip(draw, size, foot, thickness, upwards=upwards))
        low, high = (-inner - place), (inner - place)
        if count > 2 and abs(place) < 1e-9 and draw.chance(0.5):
            low, high = draw.pick([(low, 0.0), (0.0, high)])
        links.append(Link("cabinet_door", [node], carcass, slider(axis, low, high), leaf_name="translation_door"))
    if count == 1 and draw.chance(0.5):
        beside = -axis * places[0] + (opening.x, opening.y, face - 2.2 * thickness)
        fixed = front_panel(draw, *size, thickness, look)
        carcass.nodes.append(above.add("vertical_front_panel", *(move(piece, beside) for piece in fixed)))
    if draw.chance(0.4):
        _add_rails(draw, above, carcass, replace(opening, front=face), thickness, upwards=upwards)
    return links


def add_shutter(draw: Draw, above: Node, carcass: Link, opening: Opening, thickness: float) -> Link:
    """Add one rigid panel over a whole opening that slides away: up, down or aside, in grooves or in front of the carcass."""
    upwards = draw.chance(0.65)
    margin = draw.pick([0.0, draw.between(0.0, 0.05)]) * min(opening.width, opening.height)
    ahead = draw.pick([0.0, -thickness, 1.1 * thickness], [3, 2, 3])
    extra = 2 * margin * (1.0 if ahead > 0 else -1.0)
    size = (opening.width + extra, opening.height + extra)
    at = np.array([opening.x, opening.y, opening.front + ahead - thickness])
    look = draw.pick(SLIDING_LOOKS, [4, 2, 6, 1])
    node = above.add(draw.pick(["cabinet_door", "shutter", "door"], [3, 1, 1]))
    panel = front_panel(draw, *size, thickness, look)
    if look == "slatted" and draw.chance(0.5):
        count = draw.integer(5, 16)
        tall = size[1] / count
        gap = draw.pick([1.0, draw.between(0.85, 0.98)])
        slats = [(0, (index + 0.5 - 0.5 * count) * tall, 0.5 * thickness) for index in range(count)]
        panel = [box((size[0], gap * tall, thickness), slat) for slat in slats]
    node.add("cabinet_door_surface", *(move(piece, at) for piece in panel))
    sense = draw.pick([1.0, -1.0], [5, 1]) if upwards else draw.sign()
    axis, room = (Y if upwards else X), size[1 if upwards else 0]
    if draw.chance(0.75):
        place = -sense * draw.between(0.3, 0.45) * room
        foot = at + axis * place + (0, 0, thickness)
        node.add("handle", *_sliding_grip(draw, size, foot, thickness, upwards=upwards))
    if draw.chance(0.6):
        reach = sense * draw.pick([1.0, draw.between(0.2, 1.0)])
        _add_rails(draw, above, carcass, replace(opening, front=opening.front + ahead), thickness, upwards=upwards, reach=reach)
    travel = room * draw.between(0.6, 1.0)
    rest = draw.pick([0.0, draw.between(0.1, 0.9) * travel], [4, 1])
    motion = slider(sense * axis, 0.0, travel, rest=rest)
    return Link("cabinet_door", [node], carcass, motion, leaf_name="translation_door")


def _sliding_grip(draw: Draw, size: tuple[float, float], foot: Point, thickness: float, *, upwards: bool) -> list[Mesh]:
    """Meshes of the grip of a sliding door of `size`: a pull, a recessed dish or frame, or a strip along an edge."""
    small = min(size)
    kind = draw.pick(["pull", "dish", "slot", "strip"], [5, 2, 2, 1])
    if kind == "pull":
        return pull(draw, 0.2 * small, foot, vertical=not upwards, reach=draw.pick([0.1, 0.8]) * thickness, room=small)
    if kind == "dish":
        radius = draw.between(0.04, 0.1) * small
        ring = tube(radius, 0.75 * radius, 0.4 * thickness, "z", foot, 20)
        return [ring, cylinder(0.75 * radius, 0.1 * thickness, "z", foot, 20)][: draw.integer(1, 2)]
    if kind == "slot":
        long, wide = draw.between(0.15, 0.5) * small, draw.between(0.03, 0.08) * small
        plate = (long, wide, 0.15 * thickness) if upwards else (wide, long, 0.15 * thickness)
        return [box(plate, foot)]
    long = draw.between(0.3, 0.98)
    strip = (long * size[0], 0.04 * small, thickness) if upwards else (0.04 * small, long * size[1], thickness)
    center = np.array(foot, float)
    center[0 if upwards else 1] -= draw.pick([0.0, 0.5 * (1 - long)]) * size[0 if upwards else 1]
    return [box(strip, center + (0, 0, 0.3 * thickness))]


def _add_rails(
    draw: Draw, above: Node, carcass: Link, opening: Opening, thickness: float, *, upwards: bool, reach: float = 0.0
) -> None:
    """Add two rails of the carcass along the path of a sliding door. They go on for `reach` openings beyond the opening."""
    room = opening.height if upwards else opening.width
    long, thin = (1.0 + abs(reach)) * room, draw.between(0.3, 1.0) * thickness
    along = (Y if upwards else X) * 0.5 * reach * room
    size = (thin, long, 2 * thickness) if upwards else (long, thin, 2 * thickness)
    across = X * opening.width if upwards else Y * opening.height
    for side in (-1.0, 1.0):
        outside = 0.5 * side * (1.0 + (thin / np.linalg.norm(across) if reach else 0.0))
        at = across * outside + along + (opening.x, opening.y, opening.front - thickness)
        carcass.nodes.append(above.add("rail", box(size, at)))


def add_hung_door(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> Link:
    """Add a door in front of the carcass that hangs on a rail above the opening and slides aside."""
    thick, clear = fronts.thickness, draw.between(0.1, 0.6) * fronts.thickness
    wide, high = opening.width * draw.between(1.0, 1.1), opening.height * draw.between(1.0, 1.06)
    z, side = opening.front + clear, draw.sign()
    node = above.add("cabinet_door")
    panel = front_panel(draw, wide, high, thick, draw.pick(SLIDING_LOOKS))
    node.add("cabinet_door_surface", *(move(piece, (opening.x, opening.y, z)) for piece in panel))
    top = opening.y + 0.5 * high
    if draw.chance(0.7):
        straps = [
            box((0.05 * wide, 0.1 * high, 0.3 * thick), (opening.x + s * 0.35 * wide, top, z + 1.15 * thick)) for s in (-1, 1)
        ]
        node.add("hinge", *straps)
        rail = box((2 * wide, 0.02 * high + 0.3 * thick, 0.5 * clear), (opening.x + side * 0.5 * wide, top + 0.03 * high, z))
        carcass.nodes.append(above.add("rail", rail))
    if fronts.has_handles:
        at = (opening.x - side * 0.42 * wide, opening.y, z + thick)
        node.add("handle", *pull(draw, min(0.3 * high, fronts.handle_length), at, vertical=True))
    travel = wide * draw.between(0.5, 1.0)
    rest = draw.pick([0.0, draw.between(0.1, 1.0) * travel], [4, 1])
    motion = slider(side * X, 0.0, travel, rest=rest)
    return Link("cabinet_door", [node], carcass, motion, leaf_name="translation_door")


def add_folding_door(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> list[Link]:
    """Add a door of two leaves: one hinged on the carcass, the other on the first, both opening outwards."""
    side = draw.pick(["left", "right"])
    out = -1.0 if side == "left" else 1.0
    share = draw.between(0.4, 0.6)
    around = opening.border or (max(-fronts.gap, 0.0),) * 4
    left, right = (around[0], 0.0, *around[2:]), (0.0, *around[1:])
    near = replace(opening, x=opening.x + out * 0.5 * (1 - share) * opening.width, width=share * opening.width)
    far = replace(opening, x=opening.x - out * 0.5 * share * opening.width, width=(1 - share) * opening.width)
    near, far = (replace(half, border=left if half.x < opening.x else right) for half in (near, far))
    bare = replace(fronts, has_handles=False)
    first = add_door(draw, above, carcass, near, bare, side)
    second = add_door(draw, above, first, far, fronts, side)
    z = fronts.back_plane(opening) + fronts.thickness
    seam = (opening.x + out * (0.5 - share) * opening.width, opening.y, z)
    opens = draw.pick([90.0, 170.0, 180.0])
    second.motion = hinge(seam, Y * out, 0.0, opens, rest=draw.pick([0.0, draw.between(0.2, 0.9) * opens], [5, 1]))
    return [first, second]


def add_tipping_bin(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> Link:
    """Add a front with a bin behind it that tips out about its lower edge."""
    link = add_door(draw, above, carcass, opening, fronts, "bottom")
    high, deep = opening.height * draw.between(0.4, 0.75), min(opening.depth, opening.height) * draw.between(0.3, 0.7)
    half, back, low = 0.45 * opening.width, fronts.back_plane(opening), opening.low + 0.03 * opening.height
    wedge = np.array([(low, back), (low, back - 0.2 * deep), (low + high, back - deep), (low + high, back)])
    form = draw.pick(["cheeks", "tub", "block"], [2, 3, 1])
    pieces = [extrude(wedge, 2 * half, "x", (opening.x, 0, 0))]
    if form != "block":
        pieces = [extrude(wedge, 0.03 * half, "x", (opening.x + s * half, 0, 0)) for s in (-1, 1)]
    if form == "tub":
        floor = np.array([(low, back), (low, back - 0.2 * deep), (low + high, back - deep), (low + high, back - 0.95 * deep)])
        thin = np.concatenate([floor[1:], [(low, back - 0.15 * deep)]])
        pieces.append(extrude(thin, 2 * half, "x", (opening.x, 0, 0)))
    link.nodes[0].add("drawer_box", *pieces)
    opens = draw.between(15.0, 50.0)
    assert link.motion is not None
    link.motion = replace(link.motion, b=opens, rest=min(link.motion.rest, opens))
    return link


def add_parts_behind(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> list[Link]:
    """Add one to three drawers, or a smaller door, in an opening behind the door that closes it."""
    deep = max(fronts.thickness, 0.0) + draw.between(0.01, 0.15) * opening.depth
    inner_fronts = replace(fronts, gap=max(fronts.gap, 0.0), has_handles=draw.chance(0.5), handle_length=0.3 * opening.width)
    inner = replace(opening, width=0.96 * opening.width, depth=opening.depth - deep, front=opening.front - deep)
    if draw.chance(0.25):
        part = replace(inner, height=draw.between(0.3, 0.9) * inner.height)
        return [add_door(draw, above, carcass, part, inner_fronts, draw.pick(["left", "right"]))]
    count, links = draw.integer(1, 3), []
    tall = draw.between(0.5, 1.0) * inner.height / count
    for index in range(count):
        part = replace(inner, y=inner.low + (index + 0.5) * tall, height=0.92 * tall)
        links.append(add_drawer(draw, above, carcass, part, inner_fronts))
    return links


def add_roll_top(draw: Draw, above: Node, base: Link, half: float, level: float, rear: float, radius: float) -> Link:
    """Add a curved shutter over a table top that turns up about the line of its centre, between two side panels.

    Args:
        half: Half the width.
        level: Height of the table top.
        rear: Position of the rear edge along z.
        radius: Radius of the curve, which is the depth that the shutter covers.
    """
    thick, count = 0.04 * radius, draw.integer(5, 14)
    angle = 90.0 / count
    chord = 2 * radius * np.sin(np.radians(0.5 * angle)) * draw.pick([1.02, 0.9])
    axis = np.array([0.0, level, rear])
    slats = []
    for index in range(count):
        turned = np.radians((index + 0.5) * angle)
        normal = np.array([0.0, np.sin(turned), np.cos(turned)])
        slat = box((2 * half, chord, thick))
        tilt = np.array([[1.0, 0, 0], [0, normal[2], normal[1]], [0, -normal[1], normal[2]]])
        slats.append(move(slat.rotated(tilt), axis + radius * normal))
    if draw.chance(0.6):
        slats.append(box((0.3 * half, 0.1 * radius, 0.1 * radius), axis + (0, 0.1 * radius, radius + 0.05 * radius)))
    node = above.add(draw.pick(["door", "cover", "shutter"]), *slats)
    cheeks = [
        box_between((s * half - 0.02, level, rear), (s * half + 0.02, level + 1.05 * radius, rear + 0.6 * radius))
        for s in (-1.04, 1.04)
    ]
    base.nodes.append(above.add("vertical_side_panel", *cheeks))
    opens = draw.between(60.0, 90.0)
    motion = hinge(axis, -X, 0.0, opens, rest=draw.pick([0.0, draw.between(0.1, 1.0) * opens], [3, 1]))
    return Link("cover", [node], base, motion, leaf_name="rotation_door")
