"""Swivel chairs and stools with casters, levers, backs and other moving parts."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.seat_extras import add_foot_rest, add_moving_arms, add_writing_board
from kinmo.synth.details.wheels import add_caster
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, box, cylinder, move, rotation, rounded_box, rounded_path, sweep, torus, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, screw, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Chair or stool whose seat turns on its column, screws up it, slides up, tips or is fixed.

    Casters swivel and roll. A back tips, a headrest rises, levers tip, a knob turns, armrests slide or turn up, a footrest
    folds or slides, a ring for the feet slides, and a writing board turns.
    """
    root = Node("chair")
    stool = draw.chance(0.3)
    seat_y, seat_radius = draw.ratio(0.5, 1.3), draw.ratio(0.33, 0.65)
    foot = root.add("chair_base").add("star_leg_base")
    base = Link("chair_base", [], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    hub = _foot(draw, foot, base, links, seat_y)
    moving = _seat(draw, root, seat_y, seat_radius, is_round=draw.chance(0.75 if stool else 0.2))
    _column(draw, foot, base, moving, hub, seat_y)
    lift = draw.ratio(0.05, 0.35) * (seat_y - hub)
    kind = draw.pick(["swivel", "screw", "lift", "limited", "tilt", "fixed"], [5, 3, 1.5, 1, 0.7, 0.8])
    origin = (0, draw.pick([0.0, seat_y]), 0)
    motion = {
        "swivel": spinner(origin, Y),
        "screw": screw(origin, Y * draw.sign(), -0.5 * lift, 0.5 * lift, turns=draw.pick([None, None, 360.0])),
        "lift": slider(Y, 0.0, lift),
        "limited": hinge(origin, Y, *draw.pick([(-180.0, 180.0), (-90.0, 90.0), (0.0, 360.0)])),
        "tilt": hinge((0, seat_y - 0.03, draw.between(-0.3, 0.3) * seat_radius), X, -draw.between(5, 20), draw.between(2, 10)),
        "fixed": None,
    }[kind]
    carrier = base
    if kind in ("swivel", "tilt") and draw.chance(0.25):
        # The column slides up out of the foot, and the seat turns on it.
        tube = foot.add("central_support", cylinder(0.03, seat_y - hub, "y", (0, 0.5 * (seat_y + hub), 0), 16))
        carrier = Link("column", [tube], base, slider(Y, draw.pick([0.0, -0.5 * lift]), lift))
        links.append(carrier)
    seat = Link("seat", moving, carrier, motion)
    if motion is None and len(links) == 1:
        motion = seat.motion = spinner(origin, Y)
    if motion is None:
        seat = base
        base.nodes += moving
    else:
        links.append(seat)
    if stool and seat_y - hub > 0.4 and draw.chance(0.3):
        _foot_ring(draw, foot, base, links, hub + draw.between(0.15, 0.6) * (seat_y - hub))
    if not stool or draw.chance(0.3):
        _back(draw, root, links, seat, seat_y, seat_radius)
    if not stool and draw.chance(0.5):
        if draw.chance(0.3):
            links += add_moving_arms(draw, root, seat, seat_y, seat_radius)
        else:
            seat.nodes.append(root.add("chair_arm", *_arms(draw, seat_y, seat_radius)))
    elif not stool and draw.chance(0.2):
        links.append(add_writing_board(draw, root, seat, seat_y, seat_radius))
    if not stool and draw.chance(0.15):
        links.append(add_foot_rest(draw, root, seat, seat_y, seat_radius))
    for side in draw.pick([(), (draw.sign(),), (-1.0, 1.0)], [6, 3, 1]):
        links.append(_control(draw, root, seat, side, seat_y, seat_radius))
    return SynthObject("Chair", root, links)


def _column(draw: Draw, foot: Node, base: Link, moving: list[Node], hub: float, top: float) -> None:
    """Add the column between the foot and the seat, in one or two stages, to the seat or to the foot or to both."""
    thick, middle = draw.ratio(0.02, 0.07), draw.between(0.3, 0.7)
    split = hub + middle * (top - hub)

    def stage(radius: float, low: float, high: float) -> Mesh:
        return cylinder(radius, high - low, "y", (0, 0.5 * (low + high), 0), 16)

    kind = draw.pick(["seat", "foot", "both"])
    if kind == "seat":
        moving.append(foot.add("mechanical_control", stage(thick, hub + 0.01, top)))
    elif kind == "foot":
        base.nodes.append(foot.add("central_support", stage(1.1 * thick, hub, top - 0.04)))
    else:
        base.nodes.append(foot.add("central_support", stage(draw.between(1.2, 1.8) * thick, hub, split)))
        moving.append(foot.add("mechanical_control", stage(thick, split - draw.between(0.0, 0.8) * (split - hub), top)))


def _foot_ring(draw: Draw, foot: Node, base: Link, links: list[Link], level: float) -> None:
    """Add a ring for the feet around the column, fixed or sliding up."""
    size, rod = draw.between(0.2, 0.36), draw.between(0.01, 0.025)
    spokes = [cylinder(0.8 * rod, 2 * size, axis, (0, level, 0), 8) for axis in draw.pick([("x",), ("x", "z")])]
    node = foot.add("foot_ring", torus(size, rod, "y", (0, level, 0)), *spokes, cylinder(0.08, 0.06, "y", (0, level, 0), 14))
    if draw.chance(0.4):
        links.append(Link("foot_ring", [node], base, slider(Y, -0.08, draw.between(0.05, 0.15))))
    else:
        base.nodes.append(node)


def _control(draw: Draw, root: Node, seat: Link, side: float, y: float, radius: float) -> Link:
    """Add a lever below the seat that tips, or a knob that turns."""
    at = (side * 0.05, y - 0.06, draw.between(-0.4, 0.4) * radius)
    reach = radius * draw.between(0.6, 1.1)
    if draw.chance(0.2):
        low = (side * reach * 0.7, at[1], at[2])
        node = root.add(
            "knob", cylinder(0.05, 0.1, "x", low, 14), cylinder(0.015, 0.7 * reach, "x", (0.5 * low[0], *low[1:]), 8)
        )
        return Link("knob", [node], seat, spinner(low, X))
    end = (side * reach, at[1] - draw.between(0.0, 0.05), at[2] + draw.between(-0.05, 0.1))
    rod = sweep(np.array([at, end]), 0.012, 8)
    paddle = box((draw.between(0.05, 0.15), 0.015, 0.04), end)
    control = hinge(at, draw.pick([(0, 0, 1), (1, 0, 0), (0, 1, 0)], [3, 3, 1]), -10.0, 10.0)
    return Link("lever", [root.add("lever", rod, paddle)], seat, control)


def _foot(draw: Draw, foot: Node, base: Link, links: list[Link], seat_y: float) -> float:
    """Add star legs with or without casters, a disc, or straight legs; returns the height at which the column starts."""
    kind = draw.pick(["star", "disc", "slab", "legs"], [6, 2, 0.5, 2])
    if kind in ("disc", "slab"):
        radius, thick = draw.between(0.3, 0.55), draw.ratio(0.02, 0.12)
        plate = cylinder(radius, thick, "y", (0, 0.5 * thick, 0), 32, top_radius=radius * draw.between(0.6, 1.0))
        slab = box((2 * radius, thick, 2 * radius), (0, 0.5 * thick, 0))
        base.nodes.append(foot.add("pedestal", plate if kind == "disc" else slab))
        return thick
    reach = draw.between(0.4, 0.65)
    count = draw.pick([3, 4, 5, 5, 5, 6]) if kind == "star" else draw.pick([3, 4])
    wheel = draw.ratio(0.035, 0.075)
    low = wheel * draw.between(2.15, 2.8) if kind == "star" else 0.0
    high = low + draw.between(0.04, 0.15) if kind == "star" else draw.between(0.4, 0.7) * seat_y
    leg = sweep(np.array([(0, high, 0.02), (0, low + 0.03, reach)]), np.array([0.045, 0.028]), 8)
    if kind == "star" and draw.chance(0.4):
        leg = sweep(rounded_path(np.array([(0, high, 0), (0, high, 0.6 * reach), (0, low + 0.03, reach)]), 0.1), 0.035, 8)
    casters = kind == "star" and draw.chance(0.75)
    turned, rolls, swivels = draw.pick([0.0, 180.0 / count]), draw.chance(0.6), draw.chance(0.9)
    alike = draw.chance(0.3)
    heading, thick = draw.between(0.0, 360.0), wheel * draw.ratio(0.4, 1.0)
    for index, own in enumerate(draw.identical(count)):
        angle = turned + 360.0 * index / count
        base.nodes.append(foot.add("leg", turn(leg, Y, angle)))
        if casters:
            stem = (reach * np.sin(np.radians(angle)), low, reach * np.cos(np.radians(angle)))
            faced = angle + heading if alike else draw.between(0.0, 360.0)
            links += add_caster(own, foot, base, stem, low, wheel, thick, heading=faced, swivels=swivels, rolls=rolls)
    base.nodes.append(foot.add("central_support", cylinder(0.06, 0.12, "y", (0, high, 0), 18)))
    return high


def _seat(draw: Draw, root: Node, y: float, radius: float, *, is_round: bool) -> list[Node]:
    """Add the seat at height `y`; returns its nodes."""
    thick = draw.ratio(0.03, 0.22)
    seat = root.add("chair_seat")
    if is_round:
        cushion = cylinder(radius * 0.85, thick, "y", (0, y + 0.5 * thick, 0), 28, top_radius=radius * draw.between(0.75, 0.85))
        seat.add("seat_surface", cushion)
    else:
        size = (2 * radius, thick, 2 * radius * draw.between(0.8, 1.15))
        seat.add("seat_surface", rounded_box(size, radius * draw.between(0.1, 0.7), "y", (0, y + 0.5 * thick, 0)))
    if draw.chance(0.2):
        seat.add("seat_surface", box((1.9 * radius, 0.3 * thick, 1.8 * radius), (0, y + 0.1 * thick, 0)))
    if draw.chance(0.5):
        seat.add("seat_support", box((0.6 * radius, 0.05, 0.7 * radius), (0, y - 0.02, 0)))
    return [seat]


def _back(draw: Draw, root: Node, links: list[Link], seat: Link, y: float, radius: float) -> None:
    """Add a back on a bracket behind the seat, fixed to the seat or tipping."""
    low, tall, lean = y + draw.between(0.05, 0.4), draw.ratio(0.25, 1.2), draw.between(0.0, 20.0)
    z = -0.95 * radius
    back = root.add("chair_back")
    width = 2 * radius * draw.between(0.5, 1.0)
    for panel in _back_panels(draw, width, tall):
        back.add("back_surface", turn(move(panel, (0, low + 0.5 * tall, z)), X, -lean, (0, low, z)))
    under, apart = y - 0.03, draw.pick([0.0, 0.35 * width], [3, 1])
    path = np.array([(0, under, -0.3 * radius), (0, under, z - 0.06), (0, low + 0.4 * tall, z - 0.08)])
    rod = sweep(rounded_path(path, 0.1), draw.between(0.015, 0.045), 8)
    for x in (0.0,) if apart == 0.0 else (-apart, apart):
        back.add("back_support", move(rod, (x, 0, 0)))
    carrier = seat
    if draw.chance(0.35):
        at = (0, draw.pick([y - 0.03, low]), draw.between(-0.95, -0.3) * radius)
        most = draw.pick([20.0, draw.between(10.0, 80.0)])
        rest = draw.pick([0.0, -draw.between(0.0, 1.0) * most], [2, 1])
        forward = draw.pick([5.0, 0.0, draw.between(20.0, 80.0)], [3, 3, 1])
        carrier = Link("back", [back], seat, hinge(at, X, -most, forward, rest=rest))
        links.append(carrier)
    else:
        seat.nodes.append(back)
    if draw.chance(0.2):
        high = low + tall + draw.between(0.05, 0.15)
        head = rounded_box((0.5 * width, draw.between(0.12, 0.25), 0.07), 0.05, "z", (0, high + 0.06, z))
        posts = [box((0.02, 0.3, 0.02), (s * 0.12 * width, high - 0.1, z)) for s in (-1, 1)]
        pieces = [turn(piece, X, -lean, (0, low, z)) for piece in (head, *posts)]
        up = rotation(X, -lean) @ Y
        moves = hinge(rotation(X, -lean) @ (0, high - low, 0) + (0, low, z), X, -30.0, 20.0) if draw.chance(0.3) else None
        links.append(Link("headrest", [root.add("chair_head", *pieces)], carrier, moves or slider(up, 0.0, 0.1)))


def _back_panels(draw: Draw, width: float, height: float) -> list[Mesh]:
    """Meshes of a back, centred: a board, a cushion, a frame with a mesh, slats, or two bars."""
    thick = draw.ratio(0.02, 0.15)
    kind = draw.pick(["board", "pillow", "frame", "slats"], [5, 2, 2, 2])
    if kind == "board":
        return [rounded_box((width, height, thick), draw.between(0.0, 0.25), "z")]
    if kind == "pillow":
        return [rounded_box((width, height, thick), 0.45 * thick, draw.pick(["x", "y"]))]
    if kind == "frame":
        rim = 0.12 * min(width, height)
        bars = [box((rim, height, thick), (s * 0.5 * (width - rim), 0, 0)) for s in (-1, 1)]
        bars += [box((width, rim, thick), (0, s * 0.5 * (height - rim), 0)) for s in (-1, 1)]
        return [*bars, box((width - 1.9 * rim, height - 1.9 * rim, 0.3 * thick))]
    count, upright = draw.integer(2, 6), draw.chance(0.4)
    room = width if upright else height
    places = (np.arange(count) + 0.5 - 0.5 * count) * room / count
    size = (0.6 * room / count, height, thick) if upright else (width, 0.6 * room / count, thick)
    slats = [box(size, (x, 0, 0) if upright else (0, x, 0)) for x in places]
    rail = (width, 0.08 * height, thick) if upright else (0.08 * width, height, 0.8 * thick)
    ends = [(0, s * 0.46 * height, 0) if upright else (s * 0.3 * width, 0, -0.3 * thick) for s in (-1, 1)]
    return slats + [box(rail, at) for at in ends]


def _arms(draw: Draw, y: float, radius: float) -> list[Mesh]:
    """Two fixed armrests: rings, or rods with pads."""
    top = y + draw.between(0.3, 0.45)
    x = radius * draw.between(0.98, 1.1)
    if draw.chance(0.4):
        bow = torus(0.2, 0.025, "x", (0, 0, 0), 20, 8)
        return [move(bow, (s * x, top - 0.15, 0)) for s in (-1, 1)]
    pieces = []
    for side in (-1.0, 1.0):
        path = [(0.5 * side * x, y, 0), (side * x, y, 0), (side * x, top, 0)]
        pieces.append(sweep(rounded_path(np.array(path), 0.08), 0.022, 8))
        pieces.append(rounded_box((0.09, 0.04, 0.45), 0.04, "y", (side * x, top, draw.between(0.0, 0.08))))
    return pieces
