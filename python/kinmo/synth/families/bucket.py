"""Buckets and pails with a bow that turns about the line through its two ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.details.turning_handles import FLAT_BAR_OUTLINE
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    arc_path,
    box,
    box_between,
    cylinder,
    ellipsoid,
    lathe,
    move,
    rounded_path,
    sweep,
    sweep_outline,
    torus,
    tube,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge


@dataclass(frozen=True)
class _Plan:
    """Size of a bucket, standing on y = 0.

    Attributes:
        bottom: Half width along x at the bottom.
        top: Half width along x at the rim.
        stretch: Half width along z over that along x.
        height: Height of the rim.
        ears: Height of the bow's ends, which lie on a line along x.
        wall: Thickness of the wall.
    """

    bottom: float
    top: float
    stretch: float
    height: float
    ears: float
    wall: float

    def reach(self, y: float) -> float:
        """Half width along x at a height."""
        return self.bottom + (self.top - self.bottom) * y / self.height


def build(draw: Draw) -> SynthObject:
    """Bucket, round or square, with one or two bows and sometimes a lid.

    A bow stands upright at joint value 0 and lies down to one side or both.
    """
    top = 0.5
    height = draw.between(0.6, 1.5)
    ears = height * draw.pick([draw.between(0.75, 0.95), draw.between(0.95, 1.03)])
    plan = _Plan(top * draw.between(0.6, 1.0), top, draw.between(0.7, 1.0), height, ears, draw.between(0.01, 0.05))
    square = draw.chance(0.08)
    root = Node("Bucket")
    shell = _square_shell(plan) if square else _round_shell(draw, plan)
    body = Node("base_body", pieces=shell)
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY], [6, 1, 1]))
    rod = draw.between(0.008, 0.03)
    gap = draw.pick([0.0, draw.between(-0.01, 0.01), draw.between(0.01, 0.04)])
    reach = plan.reach(ears) + gap + rod
    links = [base]
    for sign in (-1.0, 1.0) if draw.chance(0.07) else (0.0,):
        links.append(_bow(draw, plan, base, reach, rod, sign * draw.between(0.1, 0.3) * plan.stretch * plan.top))
    if draw.chance(0.5):
        body.pieces += _ears(draw, plan, reach, rod)
    nodes = [body, *(node for link in links[1:] for node in link.nodes)]
    root.children = nodes[::-1] if draw.chance(0.8) else nodes
    if draw.chance(0.08):
        lid = root.add("lid", cylinder(1.03 * top, 0.06, "y", (0, height + 0.03, 0), 24))
        links.append(Link("lid", [lid], kind=JointType.JUNK) if draw.chance(0.5) else Link("lid", [lid], base))
    return SynthObject("Bucket", root, links)


def _round_shell(draw: Draw, plan: _Plan) -> list[Mesh]:
    """A round body, sometimes with hoops, a rim, contents or a spout."""
    segments = draw.pick([6, 8, 16, 24, 32], [1, 1, 3, 5, 3])
    belly = draw.pick([0.0, draw.between(-0.05, 0.08)])
    share = np.linspace(0.0, 1.0, 7)
    outer = np.stack([plan.bottom + (plan.top - plan.bottom) * share + belly * np.sin(np.pi * share), plan.height * share], 1)
    inner = outer[::-1] - (plan.wall, 0.0)
    inner = np.maximum(inner, [0.02, plan.wall])
    pieces = [lathe(np.concatenate([[[0.0, 0.0]], outer, inner, [[0.0, plan.wall]]]), segments)]
    if draw.chance(0.5):
        pieces.append(torus(plan.top, draw.between(0.01, 0.03), "y", (0, plan.height, 0), segments))
    for _ in range(draw.pick([0, 1, 2, 3])):
        y = plan.height * draw.between(0.15, 0.97)
        hoop = draw.between(0.01, 0.025)
        pieces.append(
            tube(plan.reach(y) + belly + hoop, plan.reach(y) - 0.01, draw.between(0.01, 0.08), "y", (0, y, 0), segments)
        )
    if draw.chance(0.15):
        pieces.append(cylinder(0.95 * plan.top, 0.01, "y", (0, draw.between(0.5, 0.97) * plan.height, 0), segments))
    if draw.chance(0.1):
        spout = [(0, 0.8 * plan.height, 0.95 * plan.top), (0, plan.height, 1.25 * plan.top)]
        pieces.append(sweep(np.array(spout), np.array([0.02, 0.1]), 8))
    return pieces


def _square_shell(plan: _Plan) -> list[Mesh]:
    """A square body of five plates."""
    x, z, wall = plan.top, plan.top * plan.stretch, plan.wall
    pieces = [box((2 * x, wall, 2 * z), (0, 0.5 * wall, 0))]
    pieces += [box_between((s * x - wall / 2, 0, -z), (s * x + wall / 2, plan.height, z)) for s in (-1, 1)]
    pieces += [box_between((-x, 0, s * z - wall / 2), (x, plan.height, s * z + wall / 2)) for s in (-1, 1)]
    return pieces


def _bow(draw: Draw, plan: _Plan, base: Link, reach: float, rod: float, z: float) -> Link:
    """A bow above the x axis in the plane z, upright at joint value 0. It clears the rim when it lies down."""
    rise = reach * draw.pick([draw.between(1.02, 1.35), draw.between(0.5, 1.0)], [4, 1])
    # If its ends are below the rim, only a high bow passes the rim; a flat bow stops there.
    over = max(plan.height - plan.ears, 0.0) + rod
    rise = max(rise, 1.5 * over)
    if rise > reach and z == 0.0:
        down = 180.0 - math.degrees(math.asin(min(1.0, (reach + rod) / rise))) * draw.between(0.9, 1.0)
    else:
        down = math.degrees(math.acos(min(1.0, over / rise)))
    path = _bow_path(draw, reach, rise)
    if draw.chance(0.25):
        outline = FLAT_BAR_OUTLINE if draw.chance(0.5) else FLAT_BAR_OUTLINE[:, ::-1]
        pieces = [sweep_outline(path, outline, rod * draw.between(3.0, 7.0))]
    else:
        pieces = [sweep(path, rod, draw.pick([6, 8, 12]))]
    if draw.chance(0.3):
        width = reach * draw.between(0.15, 0.35)
        pieces.append(cylinder(rod * draw.between(1.5, 2.5), width, "x", (0, float(path[:, 1].max()), 0), 12))
    if draw.chance(0.4):
        size = rod * draw.between(1.5, 3.0)
        ends = [(side * reach, 0, 0) for side in (-1, 1)]
        pieces += [cylinder(size, 2 * rod, "x", e, 12) if draw.chance(0.5) else ellipsoid((size, size, size), e) for e in ends]
    node = Node("handle", pieces=[move(piece, (0, plan.ears, z)) for piece in pieces])
    rest = draw.pick([0.0, draw.sign() * down, draw.between(-0.9, 0.9) * down], [4, 6, 2])
    span = (-down, down) if draw.chance(0.7) else (min(rest, 0.0), max(rest, 60.0))
    if z:
        # Each bow of a pair lies down to its own side.
        rest = math.copysign(draw.pick([0.0, down]), z)
        span = (0.0, down) if z > 0 else (-down, 0.0)
    origin = (draw.pick([0.0, reach, draw.between(-0.5, 0.5)]), plan.ears, z)
    return Link("handle", [node], base, hinge(origin, (1, 0, 0), *span, rest=rest))


def _bow_path(draw: Draw, reach: float, rise: float) -> NDArray[np.float64]:
    """Path [N, 3] of a bow in the plane z = 0: an arc, a bracket or a bracket with shoulders."""
    kind = draw.pick(["arc", "bracket", "shoulders"], [6, 2, 1])
    if kind == "arc":
        return arc_path((0, 0, 0), reach, 0.0, 180.0, "z", draw.pick([9, 13, 19, 25]), aspect=rise / reach)
    inner = reach * (1.0 if kind == "bracket" else draw.between(0.4, 0.9))
    corners = [(reach, 0, 0), (inner, rise, 0), (-inner, rise, 0), (-reach, 0, 0)]
    return rounded_path(np.array(corners), draw.between(0.05, 0.4) * reach)


def _ears(draw: Draw, plan: _Plan, reach: float, rod: float) -> list[Mesh]:
    """Fittings at the bow's ends: plates, pins or lugs on the wall."""
    kind = draw.pick(["plate", "pin", "lug"])
    pieces = []
    for side in (-1.0, 1.0):
        wall = side * plan.reach(plan.ears)
        if kind == "plate":
            size = draw.between(0.05, 0.1)
            pieces.append(box((0.02, 1.5 * size, size), (wall, plan.ears, 0)))
        elif kind == "pin":
            length = abs(reach - plan.reach(plan.ears)) + 2 * rod
            pieces.append(cylinder(0.8 * rod, length, "x", (wall + side * 0.5 * length, plan.ears, 0), 10))
        else:
            pieces.append(ellipsoid((0.03, 0.05, 0.04), (wall, plan.ears, 0), 10, 6))
    return pieces
