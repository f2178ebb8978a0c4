"""Pots and pans with a lid, and a swinging bow on some."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.vessels import beak, swinging_bow, vessel, vessel_lid
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, box, cylinder, move, rounded_path, sweep, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Pot or pan whose lid lifts off, or folds up on a hinge at the rim.

    Handles are two loops or a long grip. A pot with a spout has a bow that swings.
    """
    radius, height = 0.5, draw.between(0.25, 0.95)
    mouth = radius * draw.pick([1.0, draw.between(0.55, 0.95), draw.between(1.0, 1.1)])
    segments = draw.pick([12, 20, 28, 36])
    body = Node("base_body", pieces=vessel(draw, radius, mouth, height, segments))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY], [4, 1, 1]))
    lid, crown = vessel_lid(draw, mouth, height, segments)
    links = [base]
    if draw.chance(0.15):
        # The lid is hinged at the rim.
        origin = (0, height + 0.01, -mouth * draw.between(0.95, 1.08))
        body.pieces.append(cylinder(0.03, 0.2, "x", origin, 12))
        opening = draw.between(60.0, 110.0)
        rest = -draw.between(10.0, opening) if draw.chance(0.4) else 0.0
        links.append(Link("lid", [lid], base, hinge(origin, X, -opening, 0.0, rest=rest)))
    else:
        lift = draw.pick([0.01, 0.05, draw.between(0.05, 0.5)])
        rest = draw.between(0.0, 0.3) if draw.chance(0.1) else 0.0
        links.append(Link("lid", [lid], base, slider(Y, 0.0, max(lift, rest), rest=rest)))
    kind = draw.pick(["loops", "long", "bow"], [6, 2, 2])
    if kind == "bow":
        body.pieces.append(beak(draw, height))
        bow = swinging_bow(draw, base, mouth, height, crown)
        links.append(bow)
    else:
        body.pieces += _loops(draw, radius, height) if kind == "loops" else [_long_handle(draw, radius, height)]
    return SynthObject.flat("KitchenPot", links)


def _loops(draw: Draw, radius: float, height: float) -> list[Mesh]:
    """Two loop handles."""
    wide, reach = draw.between(0.12, 0.25), draw.between(0.1, 0.25)
    y, rod = height * draw.between(0.65, 0.95), draw.between(0.015, 0.035)
    tilt = draw.between(-10.0, 40.0)
    corners = [(0.95 * radius, 0, -wide), (radius + reach, 0, -wide), (radius + reach, 0, wide), (0.95 * radius, 0, wide)]
    loop = turn(sweep(rounded_path(np.array(corners), 0.6 * reach), rod, 8), (0, 0, 1), tilt, (radius, 0, 0))
    if draw.chance(0.2):
        loop = box((2 * reach, 2 * rod, wide), (radius + 0.5 * reach, 0, 0))
    return [turn(move(loop, (0, y, 0)), Y, spun) for spun in (0.0, 180.0)]


def _long_handle(draw: Draw, radius: float, height: float) -> Mesh:
    """One long handle."""
    y, length = height * draw.between(0.7, 0.95), draw.between(0.5, 1.0)
    path = [(0.95 * radius, y, 0), (radius + 0.4 * length, y + draw.between(0.0, 0.15), 0), (radius + length, y + 0.1, 0)]
    rod = sweep(rounded_path(np.array(path), 0.3), draw.between(0.025, 0.05), 10)
    return turn(rod, Y, draw.pick([0.0, 180.0, -90.0]))
