"""Pedestals: a foot with a column, which carries a body or mechanism that turns, tips, rises or has joints of its own."""

from __future__ import annotations

import numpy as np

from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.linked import arm, caster, crossed, gimbal, halves, motor
from kinmo.synth.mechanisms.mount import mount
from kinmo.synth.mechanisms.sliding import keys, pusher
from kinmo.synth.mechanisms.turning import bail, flap, globe, knob, lever, rocker, rotor, tap, wing
from kinmo.synth.primitives import X, Y, Z, box, cylinder, facing, rounded_box, sweep, turn
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, screw, slider, spinner

SCREEN_SHARE = 0.25
"""Share of thin upright plates among the bodies on a column."""


def pedestal(draw: Draw, crowded: bool) -> SynthObject:
    """Pedestal on the floor with a body or mechanism on its column. A crowded one often has casters."""
    root = Node("mechanism")
    base = Link("foot", [], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    foot = root.add("foot") if draw.chance(0.6) else root
    rise = draw.pick([draw.between(0.05, 0.3), draw.between(0.3, 1.2)])
    top = _foot(draw, foot, base, links, crowded)
    radius = draw.between(0.02, 0.06)
    column = cylinder(radius, rise, "y", (0, top + 0.5 * rise, 0), 14)
    top += rise
    carrier = base
    kind = draw.pick(["stays", "rises", "turns"], [15, 3, 2])
    if kind == "stays":
        base.nodes.append(foot.add(draw.pick(["column", "support", "stem"]), column))
    else:
        base.nodes.append(foot.add("sleeve", cylinder(1.4 * radius, 0.5 * rise, "y", (0, top - 0.7 * rise, 0), 14)))
        lift = draw.between(0.1, 0.5) * rise
        motion = slider(Y, -0.5 * lift, lift) if kind == "rises" else hinge((0, 0, 0), Y, -90.0, 90.0)
        name = draw.pick(["column", "rod"] if kind == "rises" else ["column", "support", "stand"])
        carrier = Link(name, [foot.add(name, column)], base, motion)
        links.append(carrier)
    if draw.chance(0.5):
        links += _ridden(draw, root, carrier, top)
    else:
        carried = draw.pick([arm, gimbal, globe, crossed, halves, rotor, motor, tap], [5, 2, 5, 1, 1, 2, 3, 1])(draw)
        links += mount(draw, carried, draw.between(0.4, 0.9), facing(Y, Z, (0, top, 0)), root, carrier)
    return SynthObject("Mechanism", root, links)


def _ridden(draw: Draw, root: Node, carrier: Link, top: float) -> list[Link]:
    """Body on the column, sometimes with a back and with mechanisms at its sides."""
    wide, deep = draw.between(0.3, 1.1), draw.between(0.2, 1.0)
    high = draw.pick([draw.between(0.04, 0.15), draw.between(0.2, 0.8)])
    middle = (0.0, top + 0.5 * high, draw.pick([0.0, draw.between(-0.15, 0.15)]))
    if draw.chance(SCREEN_SHARE):
        return _screen(draw, root, carrier, top, wide)
    if draw.chance(0.3):
        body = cylinder(0.5 * wide, high, "y", (0, middle[1], 0), 24, top_radius=draw.between(0.35, 0.55) * wide)
    else:
        body = rounded_box((wide, high, deep), 0.1 * min(wide, deep), "y", middle)
    pieces = [body]
    back = (wide * draw.between(0.6, 1.0), draw.between(0.3, 0.8), 0.05)
    behind = (0, top + high + 0.5 * back[1] - 0.05, -0.5 * deep)
    backed = draw.pick(["none", "stays", "reclines"], [7, 2, 2])
    if backed == "stays":
        pieces.append(box(back, behind))
    name = draw.pick(["seat", "top", "head", "screen", "plate", "body"])
    head = Link(name, [root.add(name, *pieces)], carrier, _head_motion(draw, top))
    links = [head]
    if backed == "reclines":
        tips = hinge((0, top + high, -0.5 * deep), X, -draw.between(10.0, 60.0), draw.between(5.0, 80.0))
        named = draw.pick(["back", "panel", "board", "frame"])
        links.append(Link(named, [root.add(named, box(back, behind))], head, tips))
    for side in draw.pick([(), (X,), (-X, X), (Z,), (Y,)], [4, 1, 2, 2, 1]):
        reach = 0.5 * (high if side is Y else wide if abs(side[0]) else deep)
        built = draw.pick([lever, flap, wing, bail, rotor])(draw)
        up = Z if side is Y else Y
        size = draw.between(0.3, 0.8) * min(wide, deep)
        links += mount(draw, built, size, facing(side, up, np.array(middle) + side * reach), root, head)
    return links


def _screen(draw: Draw, root: Node, carrier: Link, top: float, wide: float) -> list[Link]:
    """Thin upright plate in front of the column's end. It tips, turns, rises, or turns in its own plane."""
    high, thick = draw.between(0.4, 1.0) * wide, draw.between(0.02, 0.08)
    level, ahead = top + draw.between(-0.1, 0.5) * high, draw.between(0.02, 0.1)
    neck = cylinder(0.4 * thick, 0.3 * wide, "x", (0, level if level < top else top, 0.4 * ahead), 12)
    plate = box((wide, high, thick), (0, level, ahead + 0.5 * thick))
    at = (0.0, top, 0.0)
    motion = draw.pick(
        [
            hinge(at, X, -draw.between(5.0, 30.0), draw.between(5.0, 30.0)),
            hinge(at, Y, -draw.between(20.0, 90.0), draw.between(20.0, 90.0)),
            slider(Y, -draw.between(0.02, 0.2), draw.between(0.02, 0.2)),
            hinge((0.0, level, 0.0), Z, -90.0, 90.0),
        ],
        [8, 2, 1, 0.5],
    )
    name = draw.pick(["screen", "frame", "panel", "head"])
    return [Link(name, [root.add(name, *draw.pick([[plate], [plate, neck]]))], carrier, motion)]


def _head_motion(draw: Draw, top: float) -> Motion:
    """Joint of the body on a column that ends at height `top`."""
    origin = (0.0, top, 0.0)
    kind = draw.pick(["turn", "limited", "screw", "lift", "tip"], [5, 1, 2, 1, 2])
    if kind == "turn":
        return spinner(origin, Y)
    if kind == "limited":
        return hinge(origin, Y, -draw.between(30.0, 180.0), draw.between(30.0, 180.0))
    if kind == "screw":
        return screw(origin, Y, -0.1, draw.between(0.05, 0.2), turns=draw.pick([None, 360.0]))
    if kind == "lift":
        return slider(Y, 0.0, draw.between(0.05, 0.3))
    return hinge(origin, draw.pick([X, Z], [4, 1]), -draw.between(5.0, 45.0), draw.between(5.0, 45.0))


def _foot(draw: Draw, foot: Node, base: Link, links: list[Link], crowded: bool) -> float:
    """Add a disc, a slab, or legs with or without casters; returns the height of the foot."""
    kind = draw.pick(["disc", "slab", "legs"], [3, 2, 3])
    if kind != "legs":
        thick, size = draw.between(0.02, 0.1), draw.between(0.25, 0.7)
        shape = cylinder(0.5 * size, thick, "y", (0, 0.5 * thick, 0), 28)
        slab = box((size, thick, draw.between(0.6, 1.4) * size), (0, 0.5 * thick, 0))
        base.nodes.append(foot.add("plate", shape if kind == "disc" else slab))
        if draw.chance(0.25):
            built = draw.pick([keys, pusher, knob, rocker])(draw)
            links += mount(draw, built, 0.3 * size, facing(Y, Z, (0, thick, 0.3 * size)), foot, base)
        return thick
    count, reach = draw.integer(3, 6), draw.between(0.25, 0.6)
    low, high = draw.between(0.03, 0.2), draw.between(0.0, 0.2)
    rolls, size = draw.chance(0.65 if crowded else 0.25), draw.between(0.12, 0.35)
    leg = sweep(np.array([(0, low + high, 0), (0, low, reach)]), draw.between(0.012, 0.04), 8)
    for index, own in enumerate(draw.identical(count)):
        angle = 360.0 * index / count
        base.nodes.append(foot.add("leg", turn(leg, Y, angle)))
        if rolls:
            at = (reach * np.sin(np.radians(angle)), low, reach * np.cos(np.radians(angle)))
            links += mount(draw, caster(own), size * reach, facing(-Y, Z, at), foot, base)
    return low + high
