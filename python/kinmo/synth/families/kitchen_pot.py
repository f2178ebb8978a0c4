"""Pots, pans and kettles: a lid that lifts off or folds up, and on kettles a bow that turns."""

from __future__ import annotations

import numpy as np

from kinmo.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.model import JointName, Link, Node, SynthObject, hinge, slider
from kinmo.synth.primitives import (
    X,
    Y,
    arc_path,
    box,
    cylinder,
    ellipsoid,
    lathe,
    move,
    rounded_path,
    sweep,
    torus,
    turn,
)


def build(draw: Draw) -> SynthObject:
    radius, height = 0.5, draw.between(0.25, 0.95)
    mouth = radius * draw.pick([1.0, draw.between(0.55, 0.95), draw.between(1.0, 1.1)])
    segments = draw.pick([12, 20, 28, 36])
    root = Node("KitchenPot")
    body = Node("base_body", pieces=_vessel(draw, radius, mouth, height, segments))
    base = Link("base_body", [body], kind=draw.pick([JointName.FREE, JointName.STATIC, JointName.HEAVY], [4, 1, 1]))
    lid, crown = _lid(draw, mouth, height, segments)
    links = [base]
    if draw.chance(0.15):
        # A lid on a hinge at the rim.
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
        body.pieces.append(_beak(draw, mouth, height))
        bow = _bow(draw, base, mouth, height, crown)
        links.append(bow)
    else:
        body.pieces += _loops(draw, radius, height) if kind == "loops" else [_long_handle(draw, radius, height)]
    root.children = [node for link in links[1:] for node in link.nodes] + [body]
    return SynthObject("KitchenPot", root, links)


def _vessel(draw: Draw, radius: float, mouth: float, height: float, segments: int) -> list[Mesh]:
    wall = draw.between(0.01, 0.04)
    foot = radius * draw.between(0.75, 1.0)
    belly = draw.between(0.3, 0.7)
    outer = np.array([[foot, 0], [radius, belly * 0.3 * height], [radius, belly * height], [mouth, height]])
    inner = outer[::-1] - (wall, 0.0)
    inner[:, 1] = np.maximum(inner[:, 1], wall)
    pieces = [lathe(np.concatenate([[[0.0, 0.0]], outer, inner, [[0.0, wall]]]), segments)]
    if draw.chance(0.5):
        pieces.append(torus(mouth, draw.between(0.01, 0.025), "y", (0, height, 0), segments, 6))
    if draw.chance(0.15):
        pieces += [cylinder(0.04, 0.1, "y", (0.3 * np.cos(a), -0.05, 0.3 * np.sin(a)), 10) for a in (0.5, 2.6, 4.7)]
    return pieces


def _lid(draw: Draw, mouth: float, height: float, segments: int) -> tuple[Node, float]:
    """The lid, resting on the rim, and the height of its top."""
    rise, edge = draw.between(0.02, 0.3) * mouth, mouth * draw.between(0.97, 1.06)
    share = np.linspace(0.0, 1.0, 7)
    skin = np.stack([edge * np.cos(0.5 * np.pi * share), rise * np.sin(0.5 * np.pi * share)], axis=1)
    profile = np.concatenate([[[0.0, -0.005], [edge, -0.005]], skin])
    profile[-1, 0] = 0.0
    pieces = [move(lathe(profile, segments), (0, height + 0.005, 0))]
    if draw.chance(0.3):
        pieces.append(cylinder(0.95 * mouth, 0.05, "y", (0, height - 0.02, 0), segments))
    top, size = height + rise, draw.between(0.05, 0.12)
    kind = draw.pick(["knob", "ball", "bow", "ring"], [3, 1, 2, 1])
    if kind == "knob":
        turned = np.array([[0, 0], [0.4, 0], [0.4, 0.6], [1, 0.8], [1, 1.1], [0, 1.3]]) * size
        pieces.append(move(lathe(turned, 18), (0, top, 0)))
    elif kind == "ball":
        pieces.append(ellipsoid((size, size, size), (0, top + 0.8 * size, 0)))
    else:
        wide = draw.between(1.0, 2.2) * size
        path = arc_path((0, top - 0.01, 0), wide, 0.0, 180.0, "z", 12, aspect=draw.between(0.5, 1.0))
        if kind == "bow":
            corners = [(-wide, top - 0.01, 0), (-wide, top + size, 0), (wide, top + size, 0), (wide, top - 0.01, 0)]
            path = rounded_path(np.array(corners), 0.5 * size)
        pieces.append(turn(sweep(path, draw.between(0.012, 0.03), 8), Y, draw.pick([0.0, 90.0])))
    return Node("lid", pieces=pieces), top + 1.5 * size


def _loops(draw: Draw, radius: float, height: float) -> list[Mesh]:
    wide, reach = draw.between(0.12, 0.25), draw.between(0.1, 0.25)
    y, rod = height * draw.between(0.65, 0.95), draw.between(0.015, 0.035)
    tilt = draw.between(-10.0, 40.0)
    corners = [(0.95 * radius, 0, -wide), (radius + reach, 0, -wide), (radius + reach, 0, wide), (0.95 * radius, 0, wide)]
    loop = turn(sweep(rounded_path(np.array(corners), 0.6 * reach), rod, 8), (0, 0, 1), tilt, (radius, 0, 0))
    if draw.chance(0.2):
        loop = box((2 * reach, 2 * rod, wide), (radius + 0.5 * reach, 0, 0))
    return [turn(move(loop, (0, y, 0)), Y, spun) for spun in (0.0, 180.0)]


def _long_handle(draw: Draw, radius: float, height: float) -> Mesh:
    y, length = height * draw.between(0.7, 0.95), draw.between(0.5, 1.0)
    path = [(0.95 * radius, y, 0), (radius + 0.4 * length, y + draw.between(0.0, 0.15), 0), (radius + length, y + 0.1, 0)]
    rod = sweep(rounded_path(np.array(path), 0.3), draw.between(0.025, 0.05), 10)
    return turn(rod, Y, draw.pick([0.0, 180.0, -90.0]))


def _beak(draw: Draw, mouth: float, height: float) -> Mesh:
    """The spout of a kettle, to the front."""
    path = [
        (0, 0.35 * height, 0.4),
        (0, 0.6 * height, 0.62),
        (0, draw.between(0.95, 1.1) * height, 0.62 + draw.between(0.1, 0.25)),
    ]
    return sweep(rounded_path(np.array(path), 0.15), np.linspace(0.1, 0.04, 7), 12)


def _bow(draw: Draw, base: Link, mouth: float, height: float, crown: float) -> Link:
    """A kettle's handle over the lid, turning about the line through its ends on the shoulders."""
    reach, low = mouth * draw.between(0.95, 1.1), height * draw.between(0.85, 1.0)
    rise = (crown - low) * draw.between(1.1, 1.6) + 0.1
    if draw.chance(0.5):
        path = arc_path((0, low, 0), reach, 0.0, 180.0, "z", 16, aspect=rise / reach)
    else:
        corners = [(reach, low, 0), (0.9 * reach, low + rise, 0), (-0.9 * reach, low + rise, 0), (-reach, low, 0)]
        path = rounded_path(np.array(corners), 0.25 * reach)
    rod = draw.between(0.012, 0.03)
    node = Node("handle", pieces=[sweep(path, rod, 8)])
    if draw.chance(0.5):
        node.pieces.append(cylinder(2 * rod, 0.7 * reach, "x", (0, low + rise, 0), 12))
    down = draw.between(50.0, 80.0)
    rest = draw.pick([0.0, draw.sign() * down, draw.between(-down, down)], [4, 2, 1])
    return Link("handle", [node], base, hinge((0, low, 0), X, -down, down, rest=rest))
