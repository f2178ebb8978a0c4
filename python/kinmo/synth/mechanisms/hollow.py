"""Hollow bodies, round or square and open at the top, with lids, caps, plungers, handles and spouts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.mechanisms.mount import mount
from kinmo.synth.mechanisms.sliding import keys, pusher, slot
from kinmo.synth.mechanisms.turning import bail, knob, lever
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    box,
    cylinder,
    ellipsoid,
    extrude,
    facing,
    lathe,
    move,
    rounded_outline,
    rounded_path,
    scale,
    sweep,
    tube,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, screw, slider, spinner


@dataclass(frozen=True)
class _Mouth:
    """Opening of a hollow body.

    Attributes:
        height: Height above the floor.
        wide: Half width along x.
        deep: Half width along z.
        is_round: True for an elliptic opening.
    """

    height: float
    wide: float
    deep: float
    is_round: bool

    def plate(self, draw: Draw, over: float, thick: float) -> Mesh:
        """Plate over the opening, `over` times as large. A round one may be domed."""
        low = self.height
        if not self.is_round:
            outline = rounded_outline(2 * over * self.wide, 2 * over * self.deep, 0.1 * self.wide)
            return turn(extrude(outline, thick, "z", (0, 0, low + 0.5 * thick)), X, -90.0)
        radius, rise = over * self.wide, draw.pick([0.0, draw.between(0.05, 0.6)]) * self.wide
        top = np.linspace(1.0, 0.0, 6)
        skin = np.stack([radius * top, thick + rise * (1 - top**2)], axis=1)
        plate = lathe(np.concatenate([[[0.0, 0.0], [radius, 0.0]], skin]), draw.pick([16, 24, 32]))
        return move(scale(plate, (1.0, 1.0, self.deep / self.wide)), (0, low, 0))

    def ring(self, draw: Draw, over: float, thick: float) -> list[Mesh]:
        """The same plate with a hole."""
        share = draw.between(0.5, 0.85)
        wide, deep, middle = over * self.wide, over * self.deep, self.height + 0.5 * thick
        if self.is_round:
            return [move(scale(tube(wide, share * wide, thick, "y", (0, 0, 0), 28), (1, 1, deep / wide)), (0, middle, 0))]
        rim = (1 - share) * min(wide, deep)
        sides = [box((rim, thick, 2 * deep), (s * (wide - 0.5 * rim), middle, 0)) for s in (-1, 1)]
        return sides + [box((2 * wide, thick, rim), (0, middle, s * (deep - 0.5 * rim))) for s in (-1, 1)]


def hollow(draw: Draw, crowded: bool) -> SynthObject:
    """Hollow body on y = 0 with a lid, cap or plunger and, sometimes, a bail and a mechanism at its side."""
    root = Node("mechanism")
    base = Link("body", [], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    pieces, mouth, side = _body(draw)
    weights = [3, 5, 2, 1] if mouth.is_round else [2, 6, 0, 1]
    closing = draw.pick([_resting, _hinged, _turned, _plunger], weights)(draw, mouth)
    bow = bail(draw) if draw.chance(0.25) else None
    pieces += closing.fixed
    if bow is None and draw.chance(0.5):
        pieces += _held(draw, mouth, side)
    if draw.chance(0.25):
        pieces.append(_spout(draw, mouth, side))
    base.nodes.append(root.add("body", *pieces))
    links += mount(draw, Mechanism(closing.moving), 1.0, np.eye(4), root, base)
    if bow is not None:
        reach = draw.between(0.9, 1.15) * mouth.wide / 0.46
        place = (0.0, mouth.height * draw.between(0.75, 1.0), 0.0)
        links += mount(
            draw, Mechanism(bow.moving), (reach, reach, draw.between(0.8, 1.6) * reach), facing(Y, Z, place), root, base
        )
    if draw.chance(0.6 if crowded else 0.2):
        built = draw.pick([lever, knob, pusher, keys, slot])(draw)
        normal = draw.pick([Z, -Z, X, -X])
        place = normal * side * 0.97 + Y * draw.between(0.15, 0.8) * mouth.height
        links += mount(draw, built, draw.between(0.2, 0.6) * side, facing(normal, Y, place), root, base)
    return SynthObject("Mechanism", root, links)


def _body(draw: Draw) -> tuple[list[Mesh], _Mouth, float]:
    """The body on the floor y = 0, its opening, and half its width at mid height."""
    high, half = draw.between(0.25, 1.4), draw.between(0.2, 0.5)
    wall = draw.between(0.04, 0.15) * half
    if draw.chance(0.3):
        deep = half * draw.between(0.5, 1.5)
        pieces = [box((wall, high, 2 * deep), (s * (half - 0.5 * wall), 0.5 * high, 0)) for s in (-1, 1)]
        pieces += [box((2 * half, high, wall), (0, 0.5 * high, s * (deep - 0.5 * wall))) for s in (-1, 1)]
        pieces.append(box((2 * half, wall, 2 * deep), (0, 0.5 * wall, 0)))
        return pieces, _Mouth(high, half, deep, False), min(half, deep)
    neck = draw.pick([1.0, draw.between(0.5, 1.1), draw.between(0.2, 0.5)])
    shoulder = draw.between(0.6, 0.9)
    outer = np.array([[half * draw.between(0.7, 1.0), 0], [half, 0.2 * high], [half, shoulder * high], [half * neck, high]])
    inner = outer[::-1] - (wall, 0.0)
    inner[:, 0], inner[:, 1] = np.maximum(inner[:, 0], 0.02), np.maximum(inner[:, 1], wall)
    profile = np.concatenate([[[0.0, 0.0]], outer, inner, [[0.0, wall]]])
    deep = draw.pick([1.0, draw.between(0.8, 1.4)], [3, 1])
    pieces = [scale(lathe(profile, draw.pick([16, 24, 32])), (1.0, 1.0, deep))]
    return pieces, _Mouth(high, half * neck, deep * half * neck, True), half * min(deep, 1.0)


def _resting(draw: Draw, mouth: _Mouth) -> Mechanism:
    """Lid that lies on the rim or reaches into it, and lifts off."""
    pieces, thick = [mouth.plate(draw, draw.between(0.9, 1.1), draw.between(0.02, 0.12))], 0.1 * mouth.wide
    if draw.chance(0.9 if mouth.is_round else 0.7):
        pieces += _grip(draw, mouth)
    if draw.chance(0.3):
        inside = (1.6 * mouth.wide, thick, 1.6 * mouth.deep)
        pieces.append(box(inside, (0, mouth.height - 0.5 * thick, 0)))
    lift = draw.between(0.02, 0.5)
    return Mechanism([MovingPart(draw.pick(["lid", "lid", "cover", "cap"]), pieces, slider(Y, 0.0, lift))])


def _hinged(draw: Draw, mouth: _Mouth) -> Mechanism:
    """Lid hinged at the rear of the rim, sometimes with a hinged ring below it or a tank behind it."""
    over, fixed = draw.between(0.92, 1.08), []
    ring = draw.between(0.02, 0.08) if draw.chance(0.3) else 0.0
    raised = replace(mouth, height=mouth.height + ring)
    pieces = [raised.plate(draw, over, draw.between(0.02, 0.12))]
    origin = np.array([0.0, raised.height + draw.between(-0.01, 0.04), -mouth.deep * draw.between(0.95, 1.12)])
    if draw.chance(0.3):
        tall, deep = draw.between(0.1, 0.6), draw.between(0.1, 0.4)
        behind = (0.0, mouth.height + 0.5 * tall - 0.2, origin[2] - 0.5 * deep - 0.03)
        fixed.append(box((draw.between(0.6, 1.2) * 2 * mouth.wide, tall + 0.4, deep), behind))
    if draw.chance(0.85):
        wide, thick = draw.between(0.1, 0.7) * mouth.wide, draw.between(0.02, 0.06)
        knuckle = [cylinder(thick, 2 * wide, "x", origin, 12), box((wide, 2 * thick, 2 * thick), origin + Z * thick)]
        draw.pick([pieces, fixed]).extend(knuckle)
    if draw.chance(0.5):
        tab = box((0.3 * mouth.wide, 0.05, 0.2 * mouth.deep), (0, raised.height + 0.03, 1.1 * mouth.deep))
        pieces += _grip(draw, raised) if draw.chance(0.15) else [tab]
    opening = draw.between(60.0, 130.0)
    rest = draw.pick([0.0, -draw.between(0.1, 1.0) * opening], [3, 1])
    lid = MovingPart(draw.pick(["lid", "lid", "cover"]), pieces, hinge(origin, X, -opening, 0.0, rest=rest))
    if not ring:
        return Mechanism([lid], fixed)
    motion = hinge(origin, X, -opening, 0.0, rest=draw.pick([0.0, 0.95 * rest]))
    seat = MovingPart(draw.pick(["seat", "ring", "frame"]), mouth.ring(draw, over, ring), motion)
    return Mechanism(draw.pick([[seat, lid], [seat]], [4, 1]), fixed)


def _turned(draw: Draw, mouth: _Mouth) -> Mechanism:
    """Round cap on the opening, with ribs or a grip. It screws, turns, or slides off."""
    radius, high = mouth.wide * draw.between(0.95, 1.15), draw.between(0.15, 0.9) * mouth.wide
    level = mouth.height + draw.between(-0.3, 0.4) * high
    pieces = [cylinder(radius, high, "y", (0, level, 0), 24, top_radius=draw.between(0.6, 1.0) * radius)]
    if draw.chance(0.3):
        rib = box((0.06 * radius, 0.9 * high, 0.1 * radius), (0, level, radius))
        pieces += [turn(rib, Y, 30.0 * index) for index in range(12)]
    elif draw.chance(0.3):
        pieces += [box((1.6 * radius, 0.4 * high, 0.2 * radius), (0, level + 0.6 * high, 0))]
    motions: list[Motion] = [
        screw((0, 0, 0), Y, 0.0, high, turns=draw.pick([None, 360.0])),
        spinner((0, 0, 0), Y),
        slider(Y, 0.0, high),
    ]
    return Mechanism([MovingPart(draw.pick(["cap", "lid", "closure"]), pieces, draw.pick(motions, [3, 2, 2]))])


def _plunger(draw: Draw, mouth: _Mouth) -> Mechanism:
    """Rod through the closed opening with a knob on top, pressed down."""
    thick, rod, out = 0.1 * mouth.wide, draw.between(0.05, 0.2) * mouth.wide, draw.between(0.1, 0.6) * mouth.height
    cover = mouth.plate(draw, 1.0, thick)
    low = draw.between(0.3, 0.8) * mouth.height
    top = mouth.height + thick + out
    pieces = [cylinder(rod, top - low, "y", (0, 0.5 * (low + top), 0), 12)]
    pieces.append(cylinder(draw.between(1.5, 4.0) * rod, 0.05, "y", (0, top, 0), 18))
    if draw.chance(0.4):
        reach = draw.between(0.4, 1.0) * mouth.wide
        pieces.append(box((2 * rod, 1.5 * rod, reach), (0, top, 0.5 * reach)))
    motion = slider(Y, -0.8 * out, 0.0)
    return Mechanism([MovingPart(draw.pick(["press", "head", "button", "rod"]), pieces, motion)], [cover])


def _grip(draw: Draw, mouth: _Mouth) -> list[Mesh]:
    """Knob, ball or bow on the middle of a lid."""
    size = draw.between(0.1, 0.5) * mouth.wide
    if draw.chance(0.25):
        return [ellipsoid((size, size, size), (0, mouth.height + 0.1 * mouth.wide + 0.7 * size, 0), 16, 8)]
    standing = pull(draw, 2 * size, (0, 0, 0.1 * mouth.wide), vertical=draw.chance(0.5))
    return [move(turn(piece, X, -90.0), (0, mouth.height, 0)) for piece in standing]


def _held(draw: Draw, mouth: _Mouth, side: float) -> list[Mesh]:
    """A loop at one or both sides, or a straight handle."""
    low, high = (mouth.height * share for share in (draw.between(0.1, 0.4), draw.between(0.6, 0.95)))
    out, rod = side + draw.between(0.15, 0.4), draw.between(0.015, 0.05)
    if draw.chance(0.3):
        return [sweep(np.array([(0.9 * side, high, 0), (2 * out + 0.3, high + draw.between(0.0, 0.1), 0)]), 1.5 * rod, 10)]
    path = rounded_path(np.array([(0.9 * side, low, 0), (out, low, 0), (out, high, 0), (0.9 * side, high, 0)]), 0.1)
    loop = sweep(path, rod, 8)
    return [loop, turn(loop, Y, 180.0)] if draw.chance(0.4) else [loop]


def _spout(draw: Draw, mouth: _Mouth, side: float) -> Mesh:
    """Spout to the front, rising."""
    low, rise = draw.between(0.2, 0.6) * mouth.height, draw.between(0.2, 0.6) * mouth.height
    path = np.array([(0, low, 0.9 * side), (0, low + 0.4 * rise, 1.3 * side), (0, low + rise, 1.5 * side)])
    return sweep(rounded_path(path, 0.1 * side), draw.between(0.08, 0.2) * side, 12)
