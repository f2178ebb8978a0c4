"""Cameras with lenses, buttons, dials, folding screens, flashes and lens caps."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, move, rounded_box, tube, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, screw, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Camera whose lens has one to three stages.

    Each stage turns, slides or screws relative to the one behind it. Rings turn on stages that do not move. Buttons slide,
    dials and levers turn, switches slide, a screen folds out and may turn on its arm, a flash flips up or rises, a lid at a
    side or below turns, and a lens cap slides off or tips.
    """
    width, height, depth = draw.ratio(0.7, 1.5), draw.ratio(0.45, 1.1), draw.ratio(0.12, 0.8)
    body = Node("base_body", pieces=_housing(draw, width, height, depth))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base, *_lens(draw, base, width, height, 0.5 * depth)]
    links += _top(draw, base, width, height, depth)
    if draw.chance(0.35):
        links += _screen(draw, base, width, height, depth)
    if draw.chance(0.25):
        links.append(_hatch(draw, base, width, height, depth))
    if draw.chance(0.12):
        tall = draw.between(0.1, 0.25)
        head = Node(
            "flash", pieces=[rounded_box((0.2 * width, tall, 0.15), 0.04, "z", (0.1 * width, 0.5 * height + 0.5 * tall, 0))]
        )
        lifted = slider(Y, 0.0, tall, rest=draw.pick([0.0, tall]))
        turned = hinge((0.1 * width, 0.5 * height, 0), Y, -90.0, 90.0)
        links.append(Link("lid", [head], base, draw.pick([lifted, turned])))
    elif draw.chance(0.25):
        wide = 0.25 * width
        flash = Node("flash", pieces=[box((wide, 0.08, 0.15), (0, 0.5 * height + 0.13, 0))])
        opening = draw.between(30.0, 80.0)
        rest = -opening if draw.chance(0.4) else 0.0
        links.append(Link("lid", [flash], base, hinge((0, 0.5 * height + 0.1, -0.07), X, -opening, 0.0, rest=rest)))
    return SynthObject.flat("Camera", links)


def _housing(draw: Draw, width: float, height: float, depth: float) -> list[Mesh]:
    """The body, sometimes with a viewfinder and a grip."""
    pieces = [rounded_box((width, height, depth), draw.between(0.02, 0.15), draw.pick(["y", "z"]))]
    if draw.chance(0.6):
        pieces.append(box((0.3 * width, 0.15, 0.7 * depth), (0, 0.5 * height + 0.05, 0)))
    if draw.chance(0.5):
        pieces.append(box((0.15 * width, 0.9 * height, 0.15), (-0.4 * width, 0, 0.5 * depth)))
    return pieces


def _lens(draw: Draw, base: Link, width: float, height: float, front: float) -> list[Link]:
    """One to three lens stages, each turning, sliding or screwing relative to the one behind; sometimes a cap."""
    x, y = draw.pick([0.0, 0.15 * width]), -0.05 * height
    radius = 0.38 * height * draw.ratio(0.3, 1.25)
    links: list[Link] = []
    holder, z = base, front
    segments = draw.pick([16, 24, 32])
    for _ in range(draw.pick([1, 2, 3], [3, 3, 1])):
        length = draw.ratio(0.04, 0.6)
        middle = (x, y, z + 0.5 * length)
        wall = draw.between(0.7, 0.93)
        solid = cylinder(radius, length, "z", middle, segments, top_radius=radius * draw.between(0.8, 1.1))
        ring = tube(radius, wall * radius, length, "z", middle, segments) if draw.chance(0.75) else solid
        pane = cylinder(wall * radius, 0.02, "z", (x, y, z + draw.between(0.3, 0.95) * length), segments)
        node = Node("lens", pieces=[ring, pane] if draw.chance(0.8) else [ring])
        if draw.chance(0.3):
            node.pieces += _knurls(draw, radius, length, middle)
        if draw.chance(0.25):
            # The stage does not move; a ring on it does.
            holder.nodes.append(node)
            links += _rings(draw, holder, radius, length, (x, y, z))
            z += length
            continue
        origin = (x, y, draw.pick([0.0, z]))
        travel = length * draw.between(0.3, 0.8)
        motion = draw.pick([spinner(origin, Z), slider(Z, -travel, 0.0), screw(origin, Z, -travel, 0.0, turns=None)], [3, 2, 3])
        holder = Link("lens", [node], holder, motion)
        links.append(holder)
        z += length
        radius *= draw.between(0.75, 0.98)
    if draw.chance(0.2) or not links:
        cap = Node("lid", pieces=[cylinder(1.02 * radius, 0.04, "z", (x, y, z + 0.01), segments)])
        off = slider(Z, 0.0, 0.2, rest=draw.pick([0.0, 0.1]))
        tips = hinge((x, y + 1.02 * radius, z), -X, 0.0, draw.between(90.0, 180.0))
        links.append(Link("lid", [cap], holder, draw.pick([off, tips], [3, 1])))
    return links


def _knurls(draw: Draw, radius: float, length: float, middle: tuple[float, float, float]) -> list[Mesh]:
    """Meshes of ribs around a lens ring."""
    count = draw.integer(8, 24)
    rib = box((0.06 * radius, 0.3 * np.pi * radius / count * 2, 0.6 * length), (radius, 0, 0))
    return [move(turn(rib, Z, 360.0 * index / count), middle) for index in range(count)]


def _rings(draw: Draw, holder: Link, radius: float, length: float, foot: tuple[float, float, float]) -> list[Link]:
    """One or two rings around a stage of the lens that turn or slide along it."""
    links, count = [], draw.integer(1, 2)
    for index in range(count):
        wide = length * draw.between(0.2, 0.8) / count
        at = (foot[0], foot[1], foot[2] + (index + 0.5) * length / count)
        outer = radius * draw.between(1.03, 1.15)
        pieces = [tube(outer, 0.98 * radius, wide, "z", at, 24)]
        if draw.chance(0.4):
            pieces += _knurls(draw, outer, wide, at)
        turns = [
            spinner(at, Z),
            hinge(at, Z, 0.0, draw.pick([90.0, 180.0, 270.0])),
            slider(Z, 0.0, 0.5 * (length / count - wide)),
        ]
        links.append(Link("lens", [Node(draw.pick(["lens", "ring"]), pieces=pieces)], holder, draw.pick(turns, [4, 2, 1])))
    return links


def _hatch(draw: Draw, base: Link, width: float, height: float, depth: float) -> Link:
    """A small lid over a battery or card at a side, below, or at the back, which turns about one of its edges."""
    wide, tall, thick = draw.between(0.3, 0.8) * depth, draw.between(0.2, 0.7) * height, draw.ratio(0.01, 0.04)
    side = draw.sign()
    kind = draw.pick(["side", "below", "back"])
    opens = draw.between(70.0, 150.0)
    if kind == "side":
        x = side * (0.5 * width + 0.5 * thick)
        node = Node("lid", pieces=[box((thick, tall, wide), (x, -0.1 * height, 0))])
        motion = (
            hinge((x, -0.1 * height, -0.5 * wide), side * Y, 0.0, opens)
            if draw.chance(0.6)
            else hinge((x, -0.1 * height - 0.5 * tall, 0), side * Z, -opens, 0.0)
        )
    elif kind == "below":
        y, long = -0.5 * height - 0.5 * thick, draw.between(0.15, 0.4) * width
        at = side * draw.between(0.1, 0.25) * width
        node = Node("lid", pieces=[box((long, thick, wide), (at, y, 0))])
        motion = (
            hinge((at, y, -0.5 * wide), X, 0.0, opens) if draw.chance(0.5) else hinge((at - 0.5 * long, y, 0), -Z, 0.0, opens)
        )
    else:
        z, long = -0.5 * depth - 0.5 * thick, draw.between(0.4, 0.95) * width
        node = Node("lid", pieces=[box((long, 0.9 * height, thick), (0, 0, z))])
        motion = hinge((side * 0.5 * long, 0, z), -side * Y, 0.0, opens)
    return Link("lid", [node], base, motion)


def _top(draw: Draw, base: Link, width: float, height: float, depth: float) -> list[Link]:
    """The shutter button and dials on top, and buttons on the back."""
    links = []
    top = 0.5 * height
    x = -0.38 * width
    for index in range(draw.integer(1, 4)):
        at = (x + 0.0 if index == 0 else draw.sign() * width * draw.between(0.18, 0.42), top, 0.0)
        radius = draw.ratio(0.02, 0.1)
        if index and draw.chance(0.2):
            tab = box((0.08, 0.04, 0.05), (at[0], top + 0.02, draw.between(-0.2, 0.2) * depth))
            along_x = draw.chance(0.7)
            shifts = slider(X, -0.04, 0.04) if along_x else hinge((at[0] - 0.1, top, 0), Y, -20.0, 20.0)
            links.append(Link("slider", [Node(draw.pick(["slider", "switch", "lever"]), pieces=[tab])], base, shifts))
        elif index and draw.chance(0.7):
            pieces = [turn(piece, X, -90.0, at) for piece in dial(draw, radius, draw.between(0.03, 0.08), at)]
            links.append(Link("knob", [Node("knob", pieces=pieces)], base, spinner((at[0], 0.0, 0.0), Y)))
        elif index < 2:
            deep = draw.between(0.02, 0.05)
            pressed = cylinder(radius, deep, "y", (at[0], top + 0.4 * deep, 0.2 * depth), 16)
            links.append(Link("button", [Node("button", pieces=[pressed])], base, slider(Y, -0.5 * deep, 0.0)))
    for index in range(draw.pick([0, 0, 2, 4])):
        at = (0.4 * width, 0.25 * height - 0.15 * index * height, 0.5 * depth)
        pressed = turn(button(draw, 0.07, 0.05, 0.02, at), Y, 180.0)
        links.append(Link("button", [Node("button", pieces=[pressed])], base, slider(Z, 0.0, 0.01)))
    return links


def _screen(draw: Draw, base: Link, width: float, height: float, depth: float) -> list[Link]:
    """A screen at the back that folds out sideways, sometimes on an arm that it turns on, or that tips."""
    size = (0.6 * width, 0.6 * height, draw.ratio(0.02, 0.08))
    node = Node("screen", pieces=[box(size, (0, 0, -0.5 * depth - 0.5 * size[2]))])
    line = -0.5 * depth - draw.pick([0.0, 0.02])
    opening = draw.between(90.0, 170.0)
    rest = draw.between(20.0, opening) if draw.chance(0.4) else 0.0
    if draw.chance(0.6):
        # The edge at +x is fixed; the joint swings the other edge backwards.
        motion = hinge((0.3 * width, 0, line), -Y, 0.0, opening, rest=rest)
        if draw.chance(0.6):
            return [Link("screen", [node], base, motion)]
        arm = Node("frame", pieces=[box((0.04, 0.4 * height, size[2]), (0.31 * width, 0, -0.5 * depth - 0.5 * size[2]))])
        swinging = Link("frame", [arm], base, motion)
        turning = hinge((0, 0, -0.5 * depth - 0.5 * size[2]), X, *draw.pick([(-180.0, 0.0), (-90.0, 180.0), (0.0, 270.0)]))
        return [swinging, Link("screen", [node], swinging, turning)]
    edge = draw.pick([0.3, -0.3], [3, 1]) * height
    return [Link("screen", [node], base, hinge((0, edge, line), np.sign(edge) * X, 0.0, opening, rest=rest))]
