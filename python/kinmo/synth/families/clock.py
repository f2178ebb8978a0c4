"""Clocks with hands, pendulums, cases with doors, knobs and buttons."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, ellipsoid, extrude, move, scale, torus, tube, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Clock with two or three hands that turn about the centre of the dial.

    Variants: a wall clock, an alarm clock (a button slides, a knob and a handle turn), a pendulum clock, and a tall case clock
    with a hinged door.
    """
    root = Node("clock")
    kind = draw.pick(["wall", "alarm", "pendulum", "tall"], [4, 3, 2, 2])
    radius, depth = 0.5, draw.between(0.06, 0.2) if kind == "wall" else draw.between(0.2, 0.5)
    front = 0.5 * depth
    unit = root.add(
        {"wall": "wall_clock", "alarm": "table_clock", "pendulum": "pendulum_clock", "tall": "pendulum_clock"}[kind]
    )
    body = unit.add("clock_body")
    surface = body.add("surface")
    square = draw.chance(0.3)
    face_depth = draw.between(0.0, 0.03)
    if square:
        surface.add("surface_base", box((1.8 * radius, 1.8 * radius, 0.02), (0, 0, front - face_depth)))
    else:
        surface.add("surface_base", cylinder(0.97 * radius, 0.02, "z", (0, 0, front - face_depth), 32))
    frame = body.add("frame", *_case(draw, square, radius, depth))
    base = Link("clock_body", [surface.children[0], frame], kind=draw.pick([JointType.STATIC, JointType.FREE, JointType.HEAVY]))
    links = [base, *_hands(draw, surface, base, radius, front - face_depth + 0.012)]
    if draw.chance(0.4):
        numbers = [turn(box((0.02, 0.08, 0.01), (0, 0.85 * radius, front - face_depth)), Z, -30.0 * i) for i in range(12)]
        base.nodes.append(surface.add("number", *numbers))
    if kind == "alarm":
        links += _alarm(draw, body, base, radius, depth)
    elif kind in ("pendulum", "tall"):
        links += _pendulum(draw, unit, frame, base, depth, tall=kind == "tall")
    return SynthObject("Clock", root, links)


def _case(draw: Draw, square: bool, radius: float, depth: float) -> list[Mesh]:
    """The case, round or square."""
    wall = draw.between(0.03, 0.1)
    if square:
        half = 0.9 * radius
        middles = [s * (half + wall / 2) for s in (-1, 1)]
        sides = [box_between((x - wall / 2, -half, -depth / 2), (x + wall / 2, half, depth / 2)) for x in middles]
        ends = [turn(side, Z, 90.0) for side in sides]
        return [*sides, *ends, box((2 * half, 2 * half, 0.02), (0, 0, -depth / 2))]
    ring = tube(radius + wall, radius, depth, "z", (0, 0, 0), 32)
    if draw.chance(0.3):
        ring = torus(radius + wall, wall, "z", (0, 0, 0.3 * depth), 32, 10)
    return [ring, cylinder(radius, 0.4 * depth, "z", (0, 0, -0.3 * depth), 32)]


def _hands(draw: Draw, surface: Node, base: Link, radius: float, z: float) -> list[Link]:
    """Two or three hands in separate layers, all about the centre of the dial."""
    links = []
    group = surface.add("hand") if draw.chance(0.5) else surface
    for index in range(draw.pick([2, 3], [1, 1])):
        length = radius * (draw.between(0.45, 0.6), draw.between(0.7, 0.85), draw.between(0.75, 0.9))[index]
        wide = radius * (draw.between(0.05, 0.12), draw.between(0.03, 0.08), 0.015)[index]
        tail = length * draw.pick([0.05, draw.between(0.1, 0.3)])
        if draw.chance(0.5):
            hand = box_between((-wide / 2, -tail, 0), (wide / 2, length, 0.008))
        else:
            right = np.array([[0.3 * wide, -tail], [wide, 0.3 * length]])
            outline = np.concatenate([right, [[0.0, length]], (right * (-1, 1))[::-1]])
            hand = extrude(outline, 0.008, "z", (0, 0, 0.004))
        level = z + 0.012 * index
        pieces = [turn(move(hand, (0, 0, level)), Z, draw.between(0.0, 360.0))]
        if draw.chance(0.5):
            pieces.append(cylinder(1.2 * wide, 0.01, "z", (0, 0, level), 14))
        name = ("hour_hand", "minute_hand", "second_hand")[index]
        motion = spinner((0, 0, draw.pick([0.0, level])), Z * draw.sign())
        links.append(Link(draw.pick(["hand", name]), [group.add("hand", *pieces)], base, motion))
    return links


def _alarm(draw: Draw, body: Node, base: Link, radius: float, depth: float) -> list[Link]:
    """Legs, and sometimes a button on top, a knob at the back and a handle of an alarm clock."""
    links = []
    outer = radius + 0.08
    legs = [turn(cylinder(0.04, 0.25, "y", (0, -outer, 0), 10), Z, s * draw.between(25.0, 40.0)) for s in (-1, 1)]
    base.nodes.append(body.add("leg", *legs))
    if draw.chance(0.6):
        depth_pressed = draw.between(0.04, 0.1)
        top = turn(button(draw, draw.between(0.1, 0.4), 0.1, depth_pressed, (0, 0, outer - 0.02)), X, -90.0)
        links.append(Link("button", [body.add("button", top)], base, slider(Y, -0.6 * depth_pressed, 0.0)))
    if draw.chance(0.5):
        at = (draw.between(-0.3, 0.3), draw.between(-0.3, 0.3), 0.5 * depth)
        knob = [turn(p, Y, 180.0) for p in dial(draw, 0.06, 0.08, at)]
        links.append(Link("knob", [body.add("knob", *knob)], base, spinner((-at[0], at[1], 0.0), Z)))
    if draw.chance(0.4):
        bow = scale(torus(0.35, 0.02, "z", (0, 0, 0), 24, 6), (1, 0.6, 1))
        swing = draw.between(40.0, 90.0)
        rest = draw.pick([0.0, draw.between(-swing, swing)])
        origin = (0, 0.85 * outer, 0)
        node = body.add("handle", move(bow, (0, 0.85 * outer + 0.1, 0)))
        links.append(Link("handle", [node], base, hinge(origin, X, -swing, swing, rest=rest)))
    return links


def _pendulum(draw: Draw, unit: Node, frame: Node, base: Link, depth: float, *, tall: bool) -> list[Link]:
    """A pendulum below the dial that swings about a line along z, in a tall case sometimes behind a door."""
    length = draw.between(1.4, 2.6) if tall else draw.between(0.6, 1.2)
    half, low = draw.between(0.4, 0.55), -0.6 - length
    reach = 0.8 * length
    pivot = (0.0, draw.pick([0.0, -0.4]), draw.between(-0.1, 0.1) * depth)
    down = -0.6 - reach
    bob = draw.between(0.1, 0.18)
    rod = box_between((-0.015, down, pivot[2] - 0.008), (0.015, pivot[1], pivot[2] + 0.008))
    disc = cylinder(bob, 0.03, "z", (0, down, pivot[2]), 24)
    if not draw.chance(0.8):
        disc = ellipsoid((bob, bob, 0.04), (0, down, pivot[2]))
    swing = draw.between(6.0, 20.0)
    rest = draw.pick([0.0, draw.between(-swing, swing)])
    bar = Link("pendulum", [unit.add("pendulum", rod, disc)], base, hinge(pivot, Z * draw.sign(), -swing, swing, rest=rest))
    if not tall:
        return [bar]
    wall, z = 0.05, 0.5 * depth
    frame.pieces += [box_between((s * half - wall / 2, low, -z), (s * half + wall / 2, -0.5, z)) for s in (-1, 1)]
    frame.pieces.append(box_between((-half, low, -z), (half, -0.5, -z + wall)))
    frame.pieces.append(box_between((-1.2 * half, low - 0.2, -1.1 * z), (1.2 * half, low, 1.1 * z)))
    if draw.chance(0.4):
        return [bar]
    side = draw.sign()
    door = unit.add("door", box((2 * half - wall, length, 0.03), (0, 0.5 * (low - 0.55), z)))
    rest = draw.between(20.0, 120.0) if draw.chance(0.2) else 0.0
    axis = hinge((side * (half - wall / 2), 0, z), (0, side, 0), 0.0, 120.0, rest=rest)
    return [bar, Link("door", [door], base, axis)]
