"""Round vessels of pots and kettles: bodies, lids, spouts, and swinging bows over them."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, arc_path, cylinder, ellipsoid, lathe, move, rounded_path, sweep, torus, turn
from kinmo.synth.synth_object import Link, Node, hinge


def vessel(draw: Draw, radius: float, mouth: float, height: float, segments: int) -> list[Mesh]:
    """Meshes of a hollow pot from the floor y = 0 to its rim at `height`, with the radii `radius` and `mouth`."""
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


def vessel_lid(draw: Draw, mouth: float, height: float, segments: int) -> tuple[Node, float]:
    """The lid, lying on the rim, and the height of its top."""
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


def beak(draw: Draw, height: float) -> Mesh:
    """The spout of a kettle, to the front."""
    path = [
        (0, 0.35 * height, 0.4),
        (0, 0.6 * height, 0.62),
        (0, draw.between(0.95, 1.1) * height, 0.62 + draw.between(0.1, 0.25)),
    ]
    return sweep(rounded_path(np.array(path), 0.15), np.linspace(0.1, 0.04, 7), 12)


def swinging_bow(draw: Draw, base: Link, mouth: float, height: float, crown: float) -> Link:
    """A kettle's handle over the lid that turns about the line through its ends on the shoulders."""
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
