"""Mechanisms of several links: casters, arms, crossed bars, jaws, and stands that turn and tip."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.primitives import X, Y, Z, arc_path, box, cylinder, dome, ellipsoid, move, sweep, turn
from kinmo.synth.synth_object import hinge, slider, spinner


def caster(draw: Draw) -> Mechanism:
    """Fork or hood that swivels about the mount's normal, with one or two wheels that roll or not."""
    radius, stem = draw.between(0.12, 0.35), draw.between(0.02, 0.3)
    trail, tread = draw.between(0.0, 0.6) * radius, draw.between(0.06, 0.2)
    height = stem + 1.1 * radius
    fork = [cylinder(draw.between(0.02, 0.06), height - 0.4 * radius, "z", (0, 0, 0.5 * height - 0.2 * radius), 12)]
    apart = draw.pick([0.0, draw.between(0.55, 0.8)], [3, 2]) * tread
    if apart:
        hood = dome((1.2 * tread, 1.1 * radius, 1.05 * radius), segments=12)
        fork.append(move(turn(hood, X, -90.0), (0, trail, height)))
    else:
        fork.append(box((tread + 0.1, 0.14, 0.03), (0, 0.3 * trail, stem)))
        fork += [box((0.03, 0.12, 1.3 * radius), (s * (0.5 * tread + 0.03), 0.6 * trail, stem + 0.6 * radius)) for s in (-1, 1)]
    sides = (-1.0, 1.0) if apart else (0.0,)
    wheel = [cylinder(radius, 0.8 * tread, "x", (s * apart, trail, height), draw.pick([16, 24])) for s in sides]
    turned = draw.between(0.0, 360.0)
    rolls = draw.chance(0.7)
    held = [turn(piece, Z, turned) for piece in (fork if rolls else fork + wheel)]
    name = draw.pick(["caster", "fork", "stem"])
    swivelling = MovingPart(name, held, spinner((0, 0, 0), Z))
    if not rolls:
        return Mechanism([swivelling])
    axle = np.array([np.cos(np.radians(turned)), np.sin(np.radians(turned)), 0.0])
    center = (-trail * axle[1], trail * axle[0], height)
    rolling = MovingPart("wheel", [turn(piece, Z, turned) for piece in wheel], spinner(center, axle), swivelling)
    return Mechanism([swivelling, rolling])


def arm(draw: Draw) -> Mechanism:
    """Bars joined end to end by pins, with a head at the end. Most pins are horizontal, like those of levers."""
    thick = draw.between(0.02, 0.1)
    across, along = draw.pick([(X, "x"), (Y, "y")], [2, 1])
    ahead = np.cross(across, Z)
    at, tilt = np.array([0.0, 0.0, draw.between(0.03, 0.3)]), draw.between(-50.0, 50.0)
    cheek = (2.5 * np.abs(ahead) + 0.5 * np.abs(across)) * thick + Z * (at[2] + 0.05)
    fixed = [box(cheek, -across * thick + Z * (0.5 * at[2] + 0.025))]
    moving: list[MovingPart] = []
    level = draw.chance(0.12)
    for index in range(draw.integer(1, 3)):
        length = draw.between(0.3, 0.7)
        path = np.sin(np.radians(tilt)) * ahead + np.cos(np.radians(tilt)) * Z
        aside = across * thick * (index % 2)
        end = at + length * path
        sides = (-0.7, 0.7) if draw.chance(0.25) else (0.0,)
        bars = [sweep(np.array([at, end]) + aside + across * s * thick, 0.4 * thick, draw.pick([4, 8])) for s in sides]
        upright = level and index == 0  # the first arm turns about the normal of the mount
        pin = cylinder(draw.between(0.5, 1.3) * thick, draw.between(1.6, 3.0) * thick, "z" if upright else along, at, 12)
        swing = draw.between(20.0, 90.0)
        on = moving[-1] if moving else None
        pieces = [*bars, pin] if draw.chance(0.7) else bars
        motion = hinge(at, (Z if upright else across) * draw.sign(), -swing, swing)
        moving.append(MovingPart(draw.pick(["arm", "lever", "rod", "leg"]), pieces, motion, on))
        at, tilt = end, tilt + draw.sign() * draw.between(20.0, 110.0)
    if draw.chance(0.6):
        axis = path if draw.chance(0.25) else across
        head = [move(turn(piece, across, tilt), at) for piece in _head(draw)]
        moving.append(MovingPart(draw.pick(["head", "shade", "holder"]), head, hinge(at, axis, -60.0, 60.0), moving[-1]))
    return Mechanism(moving, fixed)


def crossed(draw: Draw) -> Mechanism:
    """Two bars, plates or frames that cross and turn about a pin at the crossing."""
    thick, long, wide = draw.between(0.02, 0.08), draw.between(0.6, 1.1), draw.between(0.04, 0.15)
    angle, share = draw.between(15.0, 60.0), draw.between(0.35, 0.65)
    height = share * long * np.cos(np.radians(angle))
    bars: list[Mesh] = []
    for side in (-1.0, 1.0):
        bar = box((wide, thick, long), (0, 0.55 * side * thick, (0.5 - share) * long))
        bars.append(move(turn(bar, Y, side * angle), (0, 0, height)))
    pin = cylinder(0.35 * wide, 3 * thick, "y", (0, 0, height), 12)
    motion = hinge((0, 0, height), Y * draw.sign(), -draw.between(5.0, 60.0), draw.between(5.0, 1.8 * angle))
    return Mechanism([MovingPart(draw.pick(["leg", "bar", "blade", "frame"]), [bars[0]], motion)], [bars[1], pin])


def halves(draw: Draw) -> Mechanism:
    """Two halves, one on the other, hinged along one edge: a book, tongs, a clamshell."""
    wide, long = draw.between(0.15, 0.9), draw.between(0.4, 1.0)
    thick, second = draw.between(0.03, 0.25), draw.between(0.6, 1.2)
    gap = draw.pick([0.0, draw.between(0.0, 0.08)])
    lower = box((wide, long, thick), (0, 0, 0.5 * thick))
    upper = box((wide * draw.between(0.7, 1.0), long, second * thick), (0, 0, (1 + 0.5 * second) * thick + gap))
    place = (0, -0.5 * long + draw.between(0.0, 0.1), thick + draw.between(0.0, 1.0) * gap)
    fixed = [lower]
    if draw.chance(0.6):
        pin = cylinder(0.25 * thick + 0.5 * gap, draw.between(0.3, 1.1) * wide, "x", place, 12)
        ears = [box((0.04, 0.1, 1.5 * thick + gap), (s * 0.5 * wide, place[1], 0.75 * thick)) for s in (-1, 1)]
        fixed += draw.pick([[pin], ears, [pin, *ears]])
    opening = draw.between(10.0, 150.0)
    rest = draw.pick([0.0, draw.between(0.1, 1.0) * opening])
    return Mechanism(
        [MovingPart(draw.pick(["body", "lid", "frame", "leg"]), [upper], hinge(place, X, 0.0, opening, rest=rest))], fixed
    )


def ridden(draw: Draw) -> Mechanism:
    """Large body on a small foot. It turns, tips, or lifts off."""
    foot, rise = draw.between(0.1, 0.4), draw.between(0.04, 0.3)
    fixed = [cylinder(foot, 0.04, "z", (0, 0, 0.02), 24), cylinder(0.3 * foot, rise, "z", (0, 0, 0.5 * rise), 16)]
    size = np.array([draw.between(0.4, 1.0), draw.between(0.1, 0.8), draw.between(0.2, 1.0)])
    body = box(size, (0, 0, rise + 0.5 * size[2])) if draw.chance(0.6) else cylinder(
        0.5 * size[1], size[2], "z", (0, 0, rise + 0.5 * size[2]), 24, top_radius=draw.between(0.6, 1.2) * 0.5 * size[1]
    )  # fmt: skip
    motion = {
        "turn": spinner((0, 0, 0), Z),
        "tip": hinge((0, 0, rise), X, -draw.between(5.0, 30.0), draw.between(5.0, 30.0)),
        "lift": slider(Z, 0.0, draw.between(0.1, 0.5)),
    }[draw.pick(["turn", "tip", "lift"])]
    return Mechanism([MovingPart(draw.pick(["body", "head", "container", "screen"]), [body], motion)], fixed)


def jaws(draw: Draw) -> Mechanism:
    """Two fingers that open about one common pin, or one pin each."""
    thick, long = draw.between(0.03, 0.08), draw.between(0.4, 0.9)
    apart = draw.pick([0.0, draw.between(0.05, 0.2)])
    height = draw.between(0.05, 0.2)
    moving = []
    for side in (-1.0, 1.0):
        finger = box((1.5 * thick, 0.9 * thick, long), (0, 0.5 * side * thick, 0.4 * long))
        finger = turn(finger, Y, side * draw.between(3.0, 25.0))
        place = (0.5 * side * apart, 0, height)
        motion = hinge(place, Y * side, -draw.between(3.0, 10.0), draw.between(10.0, 60.0))
        moving.append(MovingPart(draw.pick(["jaw", "leg", "finger"]), [move(finger, place)], motion))
    pins = [cylinder(0.4 * thick, 3 * thick, "y", (0.5 * s * apart, 0, height), 12) for s in (-1, 1)]
    fixed = [box((apart + 0.12, 0.4 * thick, height + 0.05), (0, -1.3 * thick, 0.5 * height)), *(pins if apart else pins[:1])]
    return Mechanism(moving, fixed)


def gimbal(draw: Draw) -> Mechanism:
    """Fork that turns on the mount, with a head that tips in it."""
    half, high = draw.between(0.15, 0.4), draw.between(0.25, 0.7)
    foot = cylinder(draw.between(0.1, 0.3), 0.06, "z", (0, 0, 0.03), 20)
    cheeks = [box((0.04, 0.12, high), (s * half, 0, 0.06 + 0.5 * high)) for s in (-1, 1)]
    fork = [foot, box((2 * half, 0.12, 0.04), (0, 0, 0.08)), *cheeks]
    turning = MovingPart(draw.pick(["fork", "frame", "stand"]), fork, spinner((0, 0, 0), Z))
    center = (0.0, 0.0, high)
    size = (1.7 * half, draw.between(0.15, 0.5), draw.between(0.15, 0.8) * high)
    head = box(size, center) if draw.chance(0.6) else cylinder(0.4 * high, size[1], "y", center, 20)
    axle = cylinder(0.03, 2 * half, "x", center, 10)
    swing = draw.between(20.0, 80.0)
    tipping = MovingPart(draw.pick(["head", "screen", "motor"]), [head, axle], hinge(center, X, -swing, swing), turning)
    if draw.chance(0.6):
        return Mechanism([turning, tipping])
    return Mechanism([MovingPart(tipping.name, tipping.pieces, tipping.motion)], fork)


def motor(draw: Draw) -> Mechanism:
    """Head on a neck that tips, swings or is fixed, with a rotor in front of it, sometimes in a ring."""
    high, long = draw.between(0.15, 0.6), draw.between(0.12, 0.35)
    thick, reach = draw.between(0.06, 0.14), draw.between(0.25, 0.5)
    neck = cylinder(draw.between(0.02, 0.05), high, "z", (0, 0, 0.5 * high), 12)
    center = np.array([0.0, 0.0, high])
    housing = [cylinder(thick, long, "y", center, 18)]
    front = center - Y * (0.5 * long + draw.between(0.02, 0.08))
    if draw.chance(0.5):
        rim = arc_path(tuple(front), reach + 0.03, 0, 360, "y", 28)
        housing += [sweep(rim, 0.012, 6), box((0.015, 0.015, 2 * reach), front + Y * 0.04)]
    kind = draw.pick(["tips", "swings", "stays"], [2, 1, 1])
    count, wide = draw.integer(2, 6), draw.between(0.08, 0.25)
    blade = turn(box((0.9 * reach, 0.012, wide), (0.5 * reach, 0, 0)), X, draw.between(0.0, 35.0))
    blades = [move(turn(blade, Y, 360.0 * i / count), front) for i in range(count)]
    hub = cylinder(draw.between(0.04, 0.08), 0.06, "y", front, 14)
    name = draw.pick(["rotor", "blade", "wheel", "disc"])
    if draw.chance(0.3):
        blades = [cylinder(reach, 0.03, "y", front, 28)]
    spin = spinner(front, Y * draw.sign())
    if kind == "stays":
        return Mechanism([MovingPart(name, [hub, *blades], spin)], [neck, *housing])
    place = center - Z * draw.between(0.0, 0.5) * thick
    swing = draw.between(20.0, 80.0)
    head = MovingPart(draw.pick(["motor", "head"]), housing, hinge(place, X if kind == "tips" else Z, -swing, swing))
    return Mechanism([head, MovingPart(name, [hub, *blades], spin, head)], [neck])


def _head(draw: Draw) -> list[Mesh]:
    """Head of an arm: a shade, a plate, a ball or a block."""
    kind = draw.pick(["shade", "plate", "ball", "block"])
    if kind == "shade":
        return [cylinder(0.06, draw.between(0.15, 0.3), "z", (0, 0, 0.1), 20, top_radius=draw.between(0.1, 0.22))]
    if kind == "plate":
        return [box((draw.between(0.2, 0.5), draw.between(0.15, 0.4), 0.03), (0, 0, 0.03))]
    if kind == "ball":
        return [ellipsoid((0.1, 0.1, 0.14), (0, 0, 0.1), 16, 8)]
    return [box((draw.between(0.1, 0.3), 0.12, draw.between(0.15, 0.4)), (0, 0, 0.1))]


LINKED = (caster, arm, arm, crossed, halves, halves, ridden, jaws, gimbal, motor)
"""All mechanisms of several links. Frequent ones are listed more than once."""
