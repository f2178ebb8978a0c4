"""Lamps with chains of arms, tipping shades, switches and dimmers."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, ellipsoid, lathe, move, rotation, rounded_box, sweep, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Desk, floor or wall lamp with one to three arms in a chain.

    Each arm turns relative to the one before it. The shade tips or is fixed, a dimmer turns, and a button slides.
    """
    root = Node("lamp")
    kind = draw.pick(["desk", "floor", "wall"], [5, 2, 2])
    group = root.add({"desk": "table_lamp", "floor": "street_lamp", "wall": "wall_lamp"}[kind])
    unit = group.add("lamp_unit") if draw.chance(0.7) else group
    foot = group.add("lamp_base", *_foot(draw, kind))
    base = Link("lamp_base", [foot], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    start = np.array([0.0, 0.06, 0.0]) if kind != "floor" else np.array([0.0, draw.between(1.2, 1.8), 0.0])
    if kind == "wall":
        start = np.array([0.0, 0.0, 0.08])
    if kind == "floor":
        foot.pieces.append(cylinder(0.025, start[1], "y", (0, 0.5 * start[1], 0), 12))
    swings_first = draw.chance(0.4)
    holder, at = _chain(draw, unit, links, base, start, wall=kind == "wall", swings_first=swings_first)
    _shade(draw, unit, links, holder, at)
    if kind == "desk" and draw.chance(0.35):
        links.append(_switch(draw, root, base))
    return SynthObject("Lamp", root, links)


def _foot(draw: Draw, kind: str) -> list[Mesh]:
    """The foot: a wall plate, a clamp, a disc or a rounded plate."""
    if kind == "wall":
        plate = draw.pick([cylinder(0.15, 0.05, "z", (0, 0, 0.0), 24), box((0.25, 0.35, 0.05))])
        return [plate, cylinder(0.03, 0.08, "z", (0, 0, 0.04), 12)]
    wide = draw.between(0.18, 0.35)
    if kind == "desk" and draw.chance(0.2):
        # A clamp for a table's edge.
        return [
            box((0.12, 0.05, 0.2), (0, 0.03, 0)),
            box((0.12, 0.25, 0.04), (0, -0.08, -0.1)),
            box((0.12, 0.04, 0.2), (0, -0.2, 0)),
        ]
    disc = cylinder(wide, 0.05, "y", (0, 0.025, 0), 28, top_radius=wide * draw.between(0.5, 1.0))
    return [
        draw.pick([disc, rounded_box((2 * wide, 0.05, 1.5 * wide), 0.08, "y", (0, 0.025, 0))]),
        cylinder(0.04, 0.04, "y", (0, 0.06, 0), 14),
    ]


def _chain(
    draw: Draw, unit: Node, links: list[Link], base: Link, start: np.ndarray, *, wall: bool, swings_first: bool
) -> tuple[Link, np.ndarray]:
    """Add arms in the plane x = 0, from joint to joint; returns the last arm's link and its end [3]."""
    holder, at = base, start
    count = draw.pick([1, 2, 3], [2, 5, 1])
    rod = draw.between(0.012, 0.03)
    # Arms lean to the front and to the back in turn.
    side = draw.sign()
    twin = draw.chance(0.25)
    for index in range(count):
        lean = side * draw.between(15.0, 60.0) if index % 2 == 0 else -side * draw.between(30.0, 85.0)
        lean = lean if not wall or index else draw.between(70.0, 100.0)
        length = draw.between(0.4, 0.8)
        path = rotation(X, lean) @ np.array([0.0, length, 0.0])
        end = at + path
        offsets = [-1.8 * rod, 1.8 * rod] if twin else [0.0]
        pieces = [sweep(np.stack([at, end]) + dx * X, rod, draw.pick([6, 8, 12])) for dx in offsets]
        level = swings_first and index == 0
        knuckle = rod * draw.between(1.5, 2.6)
        if draw.chance(0.8):
            pieces.append(cylinder(knuckle, 4.5 * rod, "y" if level else "x", tuple(at), 14))
        axis = Y if level else X
        low, high = draw.pick([(-90.0, 90.0), (-45.0, 45.0), (-30.0, 80.0)])
        node = unit.add("lamp_arm", *pieces) if draw.chance(0.5) else unit.add("lamp_arm").add("arm", *pieces)
        motion = hinge(at, axis * draw.sign(), low, high) if not level or draw.chance(0.7) else spinner(at, axis)
        holder = Link("lamp_arm", [node], holder, motion)
        links.append(holder)
        at = end
    return holder, at


def _shade(draw: Draw, unit: Node, links: list[Link], holder: Link, at: np.ndarray) -> None:
    """Add the head with its bulb, tipping about a horizontal line at the end of the last arm, or fixed to it."""
    long, wide = draw.between(0.2, 0.4), draw.between(0.1, 0.22)
    narrow = wide * draw.between(0.25, 0.8)
    kind = draw.pick(["cone", "bowl", "bar"], [4, 2, 2])
    if kind == "bar":
        shade = box((draw.between(0.08, 0.6), 0.05, long), (0, 0, 0.4 * long))
    else:
        inner = 0.95
        outer = [[narrow, 0], [narrow, 0.2 * long], [wide, long]]
        if kind == "bowl":
            outer = [[0.3 * wide, 0], [0.8 * wide, 0.3 * long], [wide, 0.8 * long]]
        profile = np.array([[0.0, 0.0], *outer, *([r * inner, y] for r, y in outer[::-1]), [0.0, 0.02]])
        shade = move(turn(lathe(profile, draw.pick([16, 24])), X, 90.0), (0, 0, -0.1 * long))
    nod = draw.between(0.0, 90.0)
    head = unit.add("lamp_head")
    head.add("lamp_shade", move(turn(shade, X, nod), at))
    if kind != "bar" and draw.chance(0.6):
        bulb = ellipsoid((0.3 * wide, 0.3 * wide, 0.4 * wide), (0, 0, 0.55 * long), 12, 8)
        head.add("light_bulb", move(turn(bulb, X, nod), at))
    if draw.chance(0.75):
        axis = draw.pick([X, -X, rotation(X, nod) @ Z], [4, 4, 1])
        links.append(Link("lamp_head", [head], holder, hinge(at, axis, -draw.between(30.0, 90.0), draw.between(30.0, 90.0))))
    else:
        holder.nodes.append(head)


def _switch(draw: Draw, root: Node, base: Link) -> Link:
    """A button or dial on top of the foot."""
    at = (draw.between(-0.1, 0.1), 0.05, 0.13)
    if draw.chance(0.5):
        knob = [turn(piece, X, -90.0, at) for piece in dial(draw, 0.03, 0.03, at)]
        return Link("knob", [root.add("knob", *knob)], base, spinner(at, Y))
    pressed = cylinder(0.025, 0.02, "y", (at[0], at[1] + 0.008, at[2]), 14)
    return Link("button", [root.add("button", pressed)], base, slider(Y, -0.012, 0.0))
