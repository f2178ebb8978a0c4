"""Pens with caps, push buttons, twisting barrels and clips."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, dome, ellipsoid, lathe, move, rotation_about, tube
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, screw, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Pen.

    Variants: a cap that slides off or screws, a button that slides in, and an upper barrel that turns or screws. Built upright
    with the tip down and the barrel's lower end at y = 0.
    """
    length, radius = draw.between(1.0, 1.6), draw.between(0.05, 0.12)
    sides = draw.pick([6, 12, 20, 28], [1, 1, 3, 3])
    root = Node("pen")
    barrel = root.add("body", *_barrel(draw, length, radius, sides))
    base = Link("body", [barrel], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    links = [base]
    kind = draw.pick(["cap", "button", "twist"], [4, 4, 2])
    if kind == "cap":
        links.append(_cap(draw, root, base, radius, sides))
        if draw.chance(0.3):
            links.append(_button(draw, root, base, length, radius))
    elif kind == "button":
        links.append(_button(draw, root, base, length, radius))
        barrel.pieces += [_clip(draw, length, radius)] if draw.chance(0.7) else []
    else:
        share = draw.between(0.35, 0.6)
        upper = root.add(
            "upper_body", cylinder(1.03 * radius, share * length, "y", (0, length * (1 - share / 2) + 0.01, 0), sides)
        )
        upper.pieces += [_clip(draw, length, radius)] if draw.chance(0.7) else []
        at = (0, draw.pick([0.0, length]), 0)
        motion = spinner(at, Y) if draw.chance(0.4) else screw(at, Y, 0.0, draw.between(0.05, share * length), turns=None)
        links.append(Link("upper_body", [upper], base, motion))
    shape = SynthObject("Pen", root, links)
    posture = draw.pick(["upright", "tip up", "along x", "along z"], [4, 2, 2, 2])
    if posture != "upright":
        axis, angle = {"tip up": (X, 180.0), "along x": (Z, 90.0), "along z": (X, 90.0)}[posture]
        shape.move(rotation_about(axis, angle))
    return shape


def _barrel(draw: Draw, length: float, radius: float, sides: int) -> list[Mesh]:
    """The barrel with its tip, sometimes with a grip."""
    tip = draw.between(0.1, 0.25)
    swell = draw.between(0.85, 1.1)
    point = [[0, -tip], [0.015, -tip], [0.03, -0.6 * tip]]
    profile = np.array([*point, [0.8 * radius, 0], [swell * radius, 0.3 * length], [radius, length], [0, length]])
    pieces = [lathe(profile, sides)]
    if draw.chance(0.4):
        y = draw.between(0.1, 0.8) * length
        pieces.append(tube(1.15 * radius, 0.9 * radius, draw.between(0.02, 0.25), "y", (0, y, 0), sides))
    return pieces


def _cap(draw: Draw, root: Node, base: Link, radius: float, sides: int) -> Link:
    """A cap over the tip that slides off downwards, or screws off."""
    reach, wall = draw.between(0.35, 0.6), draw.between(0.01, 0.025)
    low = reach - draw.between(0.05, 0.15)
    sleeve = tube(1.1 * radius + wall, 1.1 * radius, reach, "y", (0, 0.5 * reach - low, 0), sides)
    end = draw.pick(["flat", "round"])
    if end == "flat":
        closed = cylinder(1.1 * radius + wall, 0.02, "y", (0, -low, 0), sides)
    else:
        closed = dome((1.1 * radius + wall, 0.1, 1.1 * radius + wall), segments=sides)
        closed = move(Mesh(closed.vertices * (1, -1, 1), closed.faces[:, ::-1]), (0, -low, 0))
    pieces = [sleeve, closed]
    if draw.chance(0.6):
        pieces.append(box((0.05, 0.9 * reach, 0.02), (0, 0.5 * reach - low, 1.1 * radius + wall + 0.03)))
        pieces.append(box((0.05, 0.03, 0.05), (0, -low + 0.05, 1.1 * radius + wall + 0.015)))
    off = reach * draw.between(0.8, 1.5)
    rest = -off * draw.between(0.2, 1.0) if draw.chance(0.25) else 0.0
    if draw.chance(0.25):
        motion = screw((0, 0, 0), Y, -off, 0.0, turns=draw.pick([None, 360.0]), rest=rest)
    else:
        motion = slider(Y, -off, 0.0, rest=rest) if draw.chance(0.6) else slider((0, -1, 0), 0.0, off, rest=-rest)
    return Link("cap", [root.add("cap", *pieces)], base, motion)


def _button(draw: Draw, root: Node, base: Link, length: float, radius: float) -> Link:
    """A button at the upper end that slides in."""
    out, wide = draw.between(0.05, 0.15), radius * draw.between(0.4, 0.8)
    knob = cylinder(wide, out, "y", (0, length + 0.5 * out, 0), 14)
    pieces = [knob, ellipsoid((wide, 0.3 * wide, wide), (0, length + out, 0), 14, 6)] if draw.chance(0.4) else [knob]
    travel = out * draw.between(0.3, 0.8)
    motion = slider(Y, -travel, 0.0) if draw.chance(0.6) else slider((0, -1, 0), 0.0, travel)
    return Link("button", [root.add("button", *pieces)], base, motion)


def _clip(draw: Draw, length: float, radius: float) -> Mesh:
    """A clip at the upper end."""
    reach = draw.between(0.25, 0.4) * length
    return box((0.04, reach, 0.02), (0, length - 0.5 * reach, radius + draw.between(0.015, 0.04)))
