"""Swivel chairs and stools with casters, levers, backs and other moving parts."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.seat_extras import add_foot_rest, add_moving_arms, add_writing_board
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, box, cylinder, dome, move, rounded_box, rounded_path, sweep, torus, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, screw, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Chair or stool whose seat turns on its column, screws up it, or slides up.

    Casters swivel and roll. A back tips, a lever tips, armrests slide or turn up, a footrest folds or slides, and a writing
    board turns.
    """
    root = Node("chair")
    stool = draw.chance(0.3)
    seat_y, seat_radius = draw.between(0.8, 1.1), draw.between(0.4, 0.55)
    foot = root.add("chair_base").add("star_leg_base")
    base = Link("chair_base", [], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    hub = _foot(draw, foot, base, links, seat_y)
    moving = _seat(draw, root, seat_y, seat_radius, is_round=stool or draw.chance(0.2))
    if draw.chance(0.5):
        column = cylinder(0.04, seat_y - hub - 0.02, "y", (0, 0.5 * (seat_y + hub), 0), 16)
        moving.append(foot.add("mechanical_control", column))
    else:
        base.nodes.append(
            foot.add("central_support", cylinder(0.045, seat_y - 0.05 - hub, "y", (0, 0.5 * (seat_y + hub), 0), 16))
        )
    lift = draw.between(0.1, 0.3)
    kind = draw.pick(["swivel", "screw", "lift", "limited"], [5, 3, 1, 1])
    origin = (0, draw.pick([0.0, seat_y]), 0)
    motion = {
        "swivel": spinner(origin, Y),
        "screw": screw(origin, Y * draw.sign(), -0.5 * lift, 0.5 * lift, turns=draw.pick([None, None, 360.0])),
        "lift": slider(Y, 0.0, lift),
        "limited": hinge(origin, Y, -180.0, 180.0),
    }[kind]
    carrier = base
    if kind == "swivel" and draw.chance(0.25):
        # The column slides up out of the foot, and the seat turns on it.
        tube = foot.add("central_support", cylinder(0.03, seat_y - hub, "y", (0, 0.5 * (seat_y + hub), 0), 16))
        carrier = Link("column", [tube], base, slider(Y, draw.pick([0.0, -0.5 * lift]), lift))
        links.append(carrier)
    seat = Link("seat", moving, carrier, motion)
    links.append(seat)
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
    if draw.chance(0.35):
        at = (draw.sign() * 0.05, seat_y - 0.08, 0.0)
        rod = sweep(np.array([at, (np.sign(at[0]) * 0.9 * seat_radius, at[1] - 0.02, 0.05)]), 0.012, 8)
        knob = box((0.1, 0.015, 0.04), (np.sign(at[0]) * 0.9 * seat_radius, at[1] - 0.02, 0.05))
        control = hinge(at, draw.pick([(0, 0, 1), (1, 0, 0)]), -10.0, 10.0)
        links.append(Link("lever", [root.add("lever", rod, knob)], seat, control))
    return SynthObject("Chair", root, links)


def _foot(draw: Draw, foot: Node, base: Link, links: list[Link], seat_y: float) -> float:
    """Add star legs with or without casters, a disc, or straight legs; returns the height at which the column starts."""
    kind = draw.pick(["star", "disc", "legs"], [6, 2, 2])
    if kind == "disc":
        radius = draw.between(0.35, 0.5)
        base.nodes.append(foot.add("pedestal", cylinder(radius, 0.04, "y", (0, 0.02, 0), 32)))
        return 0.04
    count, reach = (draw.pick([4, 5, 5, 5, 6]), draw.between(0.45, 0.6)) if kind == "star" else (draw.pick([3, 4]), 0.45)
    wheel = draw.between(0.05, 0.075)
    low = 2.2 * wheel if kind == "star" else 0.0
    high = low + 0.08 if kind == "star" else 0.55 * seat_y
    leg = sweep(np.array([(0, high, 0.02), (0, low + 0.03, reach)]), np.array([0.045, 0.028]), 8)
    if kind == "star" and draw.chance(0.4):
        leg = sweep(rounded_path(np.array([(0, high, 0), (0, high, 0.6 * reach), (0, low + 0.03, reach)]), 0.1), 0.035, 8)
    casters = kind == "star" and draw.chance(0.75)
    turned = draw.pick([0.0, 180.0 / count])
    for index in range(count):
        angle = turned + 360.0 * index / count
        base.nodes.append(foot.add("leg", turn(leg, Y, angle)))
        if casters:
            _caster(draw, foot, base, links, reach, low, wheel, angle)
    base.nodes.append(foot.add("central_support", cylinder(0.06, 0.12, "y", (0, high, 0), 18)))
    return high


def _caster(
    draw: Draw, foot: Node, base: Link, links: list[Link], reach: float, low: float, wheel: float, angle: float
) -> None:
    """Add a caster at the end of a leg: a fork that swivels about a vertical line, and wheels that roll."""
    trail, heading = 0.5 * wheel, draw.between(0.0, 360.0)
    node = foot.add("wheel")
    stem = cylinder(0.012, low - wheel, "y", (0, 0.5 * (low + wheel), 0), 8)
    hood = move(dome((wheel, 1.1 * wheel, 0.3 * wheel), segments=12), (-trail, wheel, 0))
    wheels = [cylinder(wheel, 0.35 * wheel, "z", (-trail, wheel, s * 0.4 * wheel), 18) for s in (-1, 1)]

    def place(mesh: Mesh) -> Mesh:
        return turn(move(turn(mesh, Y, heading), (0, 0, reach)), Y, angle)

    at = place(Mesh(np.zeros((1, 3)), np.zeros((0, 3), np.uint32))).vertices[0]
    fork = Link("caster", [node.add("caster_stem", place(stem), place(hood))], base, spinner(at, Y))
    links.append(fork)
    rolling = node.add("wheel", *map(place, wheels))
    center = place(Mesh(np.array([[-trail, wheel, 0.0], [-trail, wheel, 1.0]]), np.zeros((0, 3), np.uint32))).vertices
    if draw.chance(0.5):
        links.append(Link("wheel", [rolling], fork, spinner(center[0], center[1] - center[0])))
    else:
        fork.nodes.append(rolling)


def _seat(draw: Draw, root: Node, y: float, radius: float, *, is_round: bool) -> list[Node]:
    """Add the seat at height `y`; returns its nodes."""
    thick = draw.between(0.05, 0.16)
    seat = root.add("chair_seat")
    if is_round:
        cushion = cylinder(radius * 0.85, thick, "y", (0, y + 0.5 * thick, 0), 28, top_radius=radius * draw.between(0.75, 0.85))
        seat.add("seat_surface", cushion)
    else:
        size = (2 * radius, thick, 2 * radius * draw.between(0.9, 1.05))
        seat.add("seat_surface", rounded_box(size, radius * draw.between(0.1, 0.7), "y", (0, y + 0.5 * thick, 0)))
    if draw.chance(0.5):
        seat.add("seat_support", box((0.6 * radius, 0.05, 0.7 * radius), (0, y - 0.02, 0)))
    return [seat]


def _back(draw: Draw, root: Node, links: list[Link], seat: Link, y: float, radius: float) -> None:
    """Add a back on a bracket behind the seat, fixed to the seat or tipping."""
    low, tall, lean = y + draw.between(0.15, 0.35), draw.between(0.5, 1.0), draw.between(3.0, 15.0)
    z = -0.95 * radius
    back = root.add("chair_back")
    size = (2 * radius * draw.between(0.7, 1.0), tall, 0.08)
    panel = rounded_box(size, draw.between(0.03, 0.2), "z", (0, low + 0.5 * tall, z))
    back.add("back_surface", turn(panel, X, -lean, (0, low, z)))
    under = y - 0.03
    path = np.array([(0, under, -0.3 * radius), (0, under, z - 0.06), (0, low + 0.4 * tall, z - 0.08)])
    back.add("back_support", sweep(rounded_path(path, 0.1), draw.between(0.02, 0.04), 8))
    if draw.chance(0.3):
        at = (0, y - 0.03, draw.between(-0.95, -0.3) * radius)
        rest = draw.pick([0.0, -draw.between(0.0, 15.0)])
        links.append(Link("back", [back], seat, hinge(at, X, -20.0, 5.0, rest=rest)))
    else:
        seat.nodes.append(back)


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
