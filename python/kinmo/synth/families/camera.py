"""Cameras with lenses, buttons, dials, folding screens, flashes and lens caps."""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, rounded_box, tube, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, screw, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Camera whose lens has one to three stages.

    Each stage turns, slides or screws relative to the one behind it. Buttons slide, dials turn, a screen folds out, a flash
    flips up, and a lens cap slides off.
    """
    width, height, depth = draw.between(0.9, 1.3), draw.between(0.6, 0.85), draw.between(0.2, 0.5)
    body = Node("base_body", pieces=_housing(draw, width, height, depth))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base, *_lens(draw, base, width, height, 0.5 * depth)]
    links += _top(draw, base, width, height, depth)
    if draw.chance(0.35):
        links.append(_screen(draw, base, width, height, depth))
    if draw.chance(0.25):
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
    radius = 0.38 * height * draw.between(0.6, 1.0)
    links = []
    holder, z = base, front
    segments = draw.pick([16, 24, 32])
    for _ in range(draw.pick([1, 2, 3], [3, 3, 1])):
        length = draw.between(0.08, 0.35)
        ring = tube(radius, 0.85 * radius, length, "z", (x, y, z + 0.5 * length), segments)
        pane = cylinder(0.85 * radius, 0.02, "z", (x, y, z + 0.7 * length), segments)
        node = Node("lens", pieces=[ring, pane])
        origin = (x, y, draw.pick([0.0, z]))
        travel = length * draw.between(0.3, 0.8)
        motion = draw.pick([spinner(origin, Z), slider(Z, -travel, 0.0), screw(origin, Z, -travel, 0.0, turns=None)], [3, 2, 3])
        holder = Link("lens", [node], holder, motion)
        links.append(holder)
        z += length
        radius *= draw.between(0.75, 0.98)
    if draw.chance(0.2):
        cap = Node("lid", pieces=[cylinder(1.02 * radius, 0.04, "z", (x, y, z + 0.01), segments)])
        links.append(Link("lid", [cap], holder, slider(Z, 0.0, 0.2, rest=draw.pick([0.0, 0.1]))))
    return links


def _top(draw: Draw, base: Link, width: float, height: float, depth: float) -> list[Link]:
    """The shutter button and dials on top, and buttons on the back."""
    links = []
    top = 0.5 * height
    x = -0.38 * width
    for index in range(draw.integer(1, 3)):
        at = (x + 0.0 if index == 0 else draw.sign() * width * draw.between(0.25, 0.4), top, 0.0)
        radius = draw.between(0.03, 0.08)
        if index and draw.chance(0.7):
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


def _screen(draw: Draw, base: Link, width: float, height: float, depth: float) -> Link:
    """A screen at the back that folds out sideways or tips."""
    size = (0.6 * width, 0.6 * height, 0.04)
    node = Node("screen", pieces=[box(size, (0, 0, -0.5 * depth - 0.025))])
    line = -0.5 * depth - draw.pick([0.0, 0.02])
    opening = draw.between(90.0, 170.0)
    rest = draw.between(20.0, opening) if draw.chance(0.4) else 0.0
    if draw.chance(0.6):
        # The edge at +x is fixed; the joint swings the other edge backwards.
        return Link("screen", [node], base, hinge((0.3 * width, 0, line), -Y, 0.0, opening, rest=rest))
    return Link("screen", [node], base, hinge((0, 0.3 * height, line), X, 0.0, opening, rest=rest))
