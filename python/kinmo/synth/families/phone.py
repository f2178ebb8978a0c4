"""Phones with keys, side keys, and halves that fold or slide."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.keypads import keypad, side_keys
from kinmo.synth.details.resting_details import add_resting, let_rest
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, facing, rotation_about, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider

RESTING_KEYS_SHARE = 0.15
"""Share of phones with a moving half whose keys do not move."""


def build(draw: Draw) -> SynthObject:
    """Phone.

    Variants: a bar phone, a flip phone (one half hinged), a slide phone (a cover slides), and a smartphone with one button.
    Keys mostly slide in. Ports, grilles, lamps and stickers rest. Built standing, keys to +z.
    """
    kind = draw.pick(["bar", "flip", "slide", "smart"], [2, 3, 2, 2])
    width, height, depth = draw.between(0.35, 0.6), draw.between(0.9, 1.5), draw.between(0.06, 0.22)
    round_edge = draw.between(0.01, 0.25) * width
    body = Node("base_body", pieces=[rounded_box((width, height, depth), round_edge, "z")])
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    links = [base]
    front = 0.5 * depth
    if kind == "smart":
        body.pieces.append(box((0.9 * width, 0.8 * height, 0.004), (0, 0, front)))
        home = cylinder(0.07 * width, 0.012, "z", (0, -0.45 * height, front), 18)
        links.append(Link("button", [Node("button", pieces=[home])], base, slider((0, 0, -1), 0.0, 0.006)))
    else:
        whole = kind in ("flip", "slide")
        share = draw.between(0.75, 0.95) if whole else draw.between(0.4, 0.55)
        keys = keypad(draw, base, width, height, front, share)
        if whole and draw.chance(RESTING_KEYS_SHARE):
            let_rest(keys, base)
        else:
            links += keys
        if kind == "bar":
            body.pieces.append(box((0.8 * width, 0.3 * height, 0.006), (0, 0.3 * height, front)))
    if kind == "flip":
        links.append(_flap(draw, base, width, height, depth))
    elif kind == "slide":
        cover = Node("lid", pieces=[rounded_box((width, height, 0.6 * depth), round_edge, "z", (0, 0, front + 0.35 * depth))])
        travel = height * draw.between(0.3, 0.55)
        rest = draw.pick([0.0, travel, draw.between(0.0, travel)])
        links.append(Link("slider", [cover], base, slider(Y, 0.0, travel, rest=rest)))
    if draw.chance(0.5):
        links += side_keys(draw, base, width, height)
    if draw.chance(0.4):
        base.nodes += _details(draw, (width, height, depth))
    shape = SynthObject.flat("Phone", links)
    if draw.chance(0.3):
        shape.move(rotation_about(X, -90.0))
    return shape


def _details(draw: Draw, size: tuple[float, float, float]) -> list[Node]:
    """Leaves of ports in the lower end, and of lenses, stickers and grilles on the back."""
    group, (x, y, z) = Node("details"), 0.5 * np.array(size)
    for kind, wide in (("port", 0.3), ("grille", 0.25), ("lamp", 0.12), ("sticker", 0.5), ("screw", 0.06)):
        if kind == "port":
            frames = [facing(-Y, Z, (right * x, -y, 0)) for right in draw.pick([(0.0,), (-0.5, 0.1), (-0.5, 0.0, 0.5)])]
        else:
            above, right = draw.between(-0.85, 0.85) * y, draw.between(-0.5, 0.5) * x
            frames = [facing(-Z, Y, (right, above - 0.2 * index * x, -z)) for index in range(draw.integer(1, 3))]
        if draw.chance(0.5):
            add_resting(draw, group, kind, min(wide * x, 1.2 * z) if kind == "port" else wide * x, frames)
    return group.children


def _flap(draw: Draw, base: Link, width: float, height: float, depth: float) -> Link:
    """The second half of a flip phone, hinged along its upper edge or, rarely, at its side."""
    thick = depth * draw.between(0.6, 1.0)
    upright = draw.chance(0.15)
    gap = 0.01
    lid = rounded_box((width, height, thick), 0.05, "z", (0, 0, 0.5 * (depth + thick) + gap))
    inset = draw.between(-0.03, 0.04)
    line = 0.5 * depth + draw.pick([0.0, 0.5 * gap, 0.5 * thick])
    opening = draw.between(100.0, 175.0)
    rest = draw.pick([0.0, draw.between(30.0, opening)], [1, 3])
    if upright:
        motion = hinge((-0.5 * width + inset, 0, line), Y, -opening, 0.0, rest=-rest)
        pin = cylinder(0.3 * depth, 0.5 * height, "y", (-0.5 * width + inset, 0, line), 12)
    else:
        # The flap's lower edge swings up to the front.
        motion = hinge((0, 0.5 * height - inset, line), X, -opening, 0.0, rest=-rest)
        pin = cylinder(0.3 * depth, 0.5 * width, "x", (0, 0.5 * height - inset, line), 12)
    return Link("lid", [Node("lid", pieces=[lid, pin] if draw.chance(0.5) else [lid])], base, motion)
