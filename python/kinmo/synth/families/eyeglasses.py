"""Eyeglasses whose two temples fold in."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    Y,
    arc_path,
    box,
    cylinder,
    extrude,
    move,
    rounded_outline,
    rounded_path,
    scale,
    sweep,
    sweep_outline,
    torus,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge


def build(draw: Draw) -> SynthObject:
    """Eyeglasses with one temple at each end of the frame, hinged about a vertical line.

    Built unfolded: lenses to +z, temples to the rear.
    """
    width, tall = draw.between(0.4, 0.55), draw.between(0.3, 0.5)
    bridge = draw.between(0.1, 0.2)
    rod = draw.between(0.012, 0.03)
    root = Node("eyeglasses")
    body = root.add("body")
    middle = 0.5 * (width + bridge)
    rims, lenses = [], []
    rim, lens = _lens(draw, width, tall, rod)
    for side in (-1.0, 1.0):
        rims.append(move(rim, (side * middle, 0, 0)))
        lenses.append(move(lens, (side * middle, 0, 0)))
    nose = sweep(arc_path((0, 0.05, 0), 0.5 * bridge, 10.0, 170.0, "z", 8, aspect=0.4), rod, 8)
    end = middle + 0.5 * width + draw.between(0.02, 0.06)
    level = tall * draw.between(0.1, 0.45)
    lugs = [box((0.06, 0.05, 0.04), (s * (end - 0.02), level, 0)) for s in (-1, 1)]
    if draw.chance(0.6):
        body.add("lens", *lenses)
        body.add("frame", *rims, nose, *lugs)
    else:
        body.pieces = [*rims, nose, *lugs, *lenses]
    base = Link("body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    links = [base]
    length, back = draw.between(1.0, 1.4), -draw.between(0.0, 0.05)
    both = draw.pick(["open", "folded", "between"], [4, 2, 2])
    for side in (-1.0, 1.0):
        corners = [(0, 0, 0), (0, 0.01, -0.75 * length), (0, -draw.between(0.05, 0.25), -length)]
        path = rounded_path(np.array(corners), 0.15) + np.array([side * end, level, back])
        flat = np.array([[0.3, 1.0], [-0.3, 1.0], [-0.3, -1.0], [0.3, -1.0]])
        arm = sweep(path, rod, 8) if draw.chance(0.4) else sweep_outline(path, flat, 1.6 * rod)
        pieces = [arm, cylinder(0.8 * rod, 0.06, "y", (side * end, level, back), 10)] if draw.chance(0.5) else [arm]
        # The temple at +x folds in towards -x, about +y.
        rest = {"open": 0.0, "folded": 88.0, "between": draw.between(10.0, 80.0)}[both]
        inwards = hinge((side * (end + draw.between(-0.01, 0.01)), 0, back), side * Y, 0.0, 90.0, rest=rest)
        links.append(Link("leg", [root.add("leg", *pieces)], base, inwards))
    return SynthObject("Eyeglasses", root, links)


def _lens(draw: Draw, width: float, tall: float, rod: float) -> tuple[Mesh, Mesh]:
    """A rim and its lens, oval or with rounded corners."""
    if draw.chance(0.5):
        rim = scale(torus(0.5 * width, rod, "z", (0, 0, 0), 24, 6), (1.0, tall / width, 1.0))
        return rim, scale(cylinder(0.49 * width, 0.01, "z", (0, 0, 0), 24), (1.0, tall / width, 1.0))
    outline = rounded_outline(width, tall, 0.25 * tall)
    closed = np.concatenate([outline, outline[:2]])
    path = np.concatenate([closed, np.zeros((len(closed), 1))], axis=1)
    return sweep(path, rod, 6, capped=False), extrude(0.98 * outline, 0.01, "z")
