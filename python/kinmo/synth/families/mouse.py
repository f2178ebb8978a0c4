"""Computer mice with a wheel and buttons, with or without a cable."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, box, cylinder, dome, move, rounded_box, rounded_path, sweep
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Mouse whose wheel turns and whose buttons tip or slide down.

    Built with the buttons to the rear (-z), as it lies in front of its user.
    """
    width, height, length = draw.between(0.5, 0.75), draw.between(0.25, 0.45), draw.between(0.9, 1.3)
    arched = draw.chance(0.7)
    front = -0.5 * length
    body = Node("base_body", pieces=_back(draw, width, height, length, arched))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    if draw.chance(0.5):
        path = [(0, 0.08, front), (0, 0.05, front - 0.3), (0.2, 0.03, front - 0.5), (0.1, 0.03, front - draw.between(0.6, 0.9))]
        body.pieces.append(sweep(rounded_path(np.array(path), 0.15), 0.02, 8))
    links = [base]
    slot = draw.between(0.06, 0.12)
    tips = draw.chance(0.6)
    # A key that tips joins the back and is free below. A key that slides stands clear of the back.
    top = 0.7 * height + (draw.between(0.035, 0.06) if tips else 0.02)
    reach = (0.43 if tips else draw.between(0.3, 0.37)) * length
    for side in (-1.0, 1.0):
        wide = 0.5 * (width - slot) * 0.95
        key = rounded_box((wide, 0.05, reach), 0.05, "y", (side * 0.5 * (wide + slot), top, front + 0.5 * reach))
        tipped = hinge((side * 0.25 * width, top, front + reach), X, -5.0, 0.0)
        motion = tipped if tips else slider((0, -1, 0), 0.0, 0.02)
        links.append(Link("button", [Node("button", pieces=[key])], base, motion))
    radius = draw.between(0.08, 0.14)
    at = (0, top - 0.2 * radius, front + draw.between(0.3, 0.6) * reach)
    wheel = cylinder(radius, 0.7 * slot, "x", at, draw.pick([16, 24]))
    links.append(Link("wheel", [Node("wheel", pieces=[wheel])], base, spinner((draw.pick([0.0, 0.2]), at[1], at[2]), X)))
    if draw.chance(0.4):
        side = draw.sign()
        for index in range(2):
            place = (side * 0.5 * width, 0.5 * height, 0.05 + 0.15 * index)
            key = box((0.04, 0.05, 0.12), place)
            links.append(Link("button", [Node("button", pieces=[key])], base, slider((-side, 0, 0), 0.0, 0.015)))
    return SynthObject.flat("Mouse", links)


def _back(draw: Draw, width: float, height: float, length: float, arched: bool) -> list[Mesh]:
    """A base plate with a palm rest behind the buttons."""
    plate = rounded_box((width, 0.7 * height, length), draw.between(0.1, 0.45) * width, "y", (0, 0.35 * height, 0), 6)
    if not arched:
        return [plate, rounded_box((width, 0.3 * height, 0.58 * length), 0.2, "y", (0, 0.85 * height, 0.2 * length))]
    return [plate, move(dome((0.5 * width, 0.4 * height, 0.3 * length)), (0, 0.65 * height, 0.2 * length))]
