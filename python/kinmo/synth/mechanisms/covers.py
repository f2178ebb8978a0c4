"""Mechanisms that cover, fold or carry: hatches, folding panels, hoods, swinging plates, bins, cranks, sticks, swing arms."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.door_locks import lock_pieces
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.primitives import X, Y, Z, box, cylinder, ellipsoid, extrude, move, rounded_box, sweep, tube, turn
from kinmo.synth.synth_object import Motion, hinge, slider, spinner


def hatch(draw: Draw) -> Mechanism:
    """Round or square cover on a collar, hinged beside it or turning aside about a post, often with a lock that turns on it."""
    radius, collar, thick = draw.ratio(0.15, 0.45), draw.ratio(0.02, 0.3), draw.ratio(0.02, 0.12)
    is_round = draw.chance(0.6)
    middle = (0, 0, collar + 0.5 * thick)
    if is_round:
        fixed = [tube(radius, 0.85 * radius, collar, "z", (0, 0, 0.5 * collar), 24)]
        cover = cylinder(radius * draw.between(0.9, 1.1), thick, "z", middle, draw.pick([16, 24, 32]))
    else:
        wall = 0.1 * radius
        fixed = [box((wall, 2 * radius, collar), (s * (radius - 0.5 * wall), 0, 0.5 * collar)) for s in (-1, 1)]
        fixed += [box((2 * radius, wall, collar), (0, s * (radius - 0.5 * wall), 0.5 * collar)) for s in (-1, 1)]
        cover = rounded_box((2 * radius, 2 * radius, thick), draw.between(0.0, 0.3) * radius, "z", middle)
    out = radius * draw.between(1.05, 1.3)
    pieces: list[Mesh] = [cover, box((out, 0.3 * radius, 0.5 * thick), (-0.5 * out, 0, collar + 0.7 * thick))]
    if draw.chance(0.7):
        fixed.append(box((0.2 * radius, 0.5 * radius, collar), (-out, 0, 0.5 * collar)))
        pieces.append(cylinder(0.4 * thick, 0.4 * radius, "y", (-out, 0, collar + 0.5 * thick), 12))
        motion = hinge((-out, 0, collar + 0.5 * thick), -Y, 0.0, draw.between(70.0, 170.0))
    else:
        fixed.append(cylinder(0.12 * radius, collar + 1.5 * thick, "z", (-out, 0, 0.5 * (collar + 1.5 * thick)), 12))
        motion = hinge((-out, 0, 0), Z * draw.sign(), 0.0, draw.between(60.0, 180.0))
    lid = MovingPart(draw.pick(["lid", "cover", "door"]), pieces, _at_times_open(draw, motion))
    moving = [lid]
    if draw.chance(0.5):
        kind = draw.pick(["wheel", "lever", "dial", "tee"])
        lock = [move(piece, (0, 0, collar + thick)) for piece in lock_pieces(draw, kind, radius * draw.between(0.5, 1.2))]
        turns = spinner((0, 0, collar + thick), Z) if draw.chance(0.6) else hinge((0, 0, collar + thick), Z, 0.0, 90.0)
        moving.append(MovingPart(draw.pick(["handle", "knob", "disc"]), lock, turns, lid))
    return Mechanism(moving, fixed)


def folding_panels(draw: Draw) -> Mechanism:
    """Two or three panels in a row, each hinged on the one before, that fold up: a folding door, a screen, a map."""
    count, high, thick = draw.pick([2, 3], [3, 1]), draw.between(0.3, 0.9), draw.ratio(0.015, 0.08)
    wide = 0.9 / count
    moving: list[MovingPart] = []
    name = draw.pick(["panel", "door", "leaf", "screen"])
    for index in range(count):
        left = -0.45 + index * wide
        pieces = [box((0.98 * wide, high, thick), (left + 0.5 * wide, 0, 0.5 * thick))]
        if index == count - 1 and draw.chance(0.6):
            pieces += pull(draw, 0.3 * high, (left + 0.85 * wide, 0, thick), vertical=True)
        opens = draw.between(80.0, 175.0)
        motion = hinge((left, 0, draw.pick([0.0, thick]) if index == 0 else thick), -Y, 0.0, opens)
        moving.append(MovingPart(name, pieces, motion, moving[-1] if moving else None))
    rims = [box((0.04, high + 0.08, 1.5 * thick), (-0.47, 0, 0.75 * thick))]
    rims += [box((0.94, 0.04, thick), (0, s * (0.5 * high + 0.03), 0.5 * thick)) for s in (-1, 1)]
    return Mechanism(moving, draw.pick([rims, rims[:1]]))


def hood(draw: Draw) -> Mechanism:
    """Curved shell about a line along the mount that turns about that line: a roll top, a visor, a bin's hood."""
    radius, wide = draw.ratio(0.2, 0.48), draw.between(0.4, 0.95)
    thick, arc, count = radius * draw.ratio(0.02, 0.12), draw.between(50.0, 120.0), draw.integer(5, 12)
    start = draw.between(0.0, 120.0 - 0.5 * arc)
    step = arc / count
    plate = box((wide, 2.05 * radius * np.sin(np.radians(0.5 * step)), thick), (0, 0, radius))
    gaps = draw.pick([1.0, 0.8])
    plates = [turn(Mesh(plate.vertices * (1, gaps, 1), plate.faces), X, -90.0 + start + (i + 0.5) * step) for i in range(count)]
    pieces = [*plates]
    arms = [box((0.02, 0.1 * radius, radius), (s * 0.49 * wide, 0, 0.5 * radius)) for s in (-1, 1)]
    pieces += [turn(arm, X, -90.0 + start + 0.5 * arc) for arm in arms]
    half = np.radians(np.linspace(0.0, 180.0, 10))
    cheek = np.stack([np.cos(half), np.sin(half)], axis=1) * 0.9 * radius
    sides = [extrude(cheek, 0.03, "x", (s * (0.5 * wide + 0.03), 0, 0)) for s in (-1, 1)]
    if draw.chance(0.4):
        sides = [cylinder(0.08 * radius, wide, "x", segments=10)]
    room = 180.0 - start - arc
    motion = hinge((0, 0, 0), X, -start, max(room, 5.0))
    return Mechanism([MovingPart(draw.pick(["cover", "lid", "shutter", "visor"]), pieces, motion)], sides)


def swinging_plate(draw: Draw) -> Mechanism:
    """Plate that lies on the mount and turns on it about a pin near its edge, or several plates on one pin."""
    long, wide, thick = draw.between(0.3, 0.8), draw.between(0.15, 0.6), draw.ratio(0.01, 0.06)
    count = draw.pick([1, 2, 3, 4], [5, 1, 1, 1])
    moving = []
    pin = cylinder(0.05, (count + 1) * thick, "z", (0, 0, 0.5 * (count + 1) * thick), 12)
    round_end = draw.chance(0.5)
    for index in range(count):
        level = (index + 0.5) * thick
        pieces = [box((wide, long, 0.9 * thick), (0, -0.42 * long, level))]
        if round_end:
            pieces = [cylinder(0.5 * wide, 0.9 * thick, "z", (0, -0.6 * long, level), 20)]
            pieces.append(box((0.4 * wide, 0.7 * long, 0.9 * thick), (0, -0.3 * long, level)))
        swing = draw.between(60.0, 180.0)
        limits = draw.pick([(-swing, swing), (0.0, swing), (-swing, 0.0)])
        moving.append(MovingPart(draw.pick(["cover", "blade", "leaf", "plate"]), pieces, hinge((0, 0, 0), Z, *limits)))
    fixed = [pin]
    if draw.chance(0.4):
        fixed.append(tube(0.35 * wide, 0.28 * wide, 0.5 * thick, "z", (0, -0.6 * long, 0.0), 20))
    return Mechanism(moving, fixed)


def tipping_bin(draw: Draw) -> Mechanism:
    """Front with a bin behind it that tips out of a housing about its lower edge."""
    wide, high, deep = draw.between(0.4, 0.9), draw.between(0.4, 0.9), draw.ratio(0.15, 0.6)
    wall = 0.025
    sides = [box((wall, high, deep), (s * 0.5 * (wide + wall), 0, 0.5 * deep)) for s in (-1, 1)]
    sides += [box((wide + 2 * wall, wall, deep), (0, s * 0.5 * (high + wall), 0.5 * deep)) for s in (-1, 1)]
    pieces = [box((wide, high, 0.04), (0, 0, deep + 0.02))]
    inner, low = 0.9 * deep, -0.5 * high
    wedge = np.array([(low + 0.02, 0.0), (low + 0.02, -0.15 * inner), (low + 0.6 * high, -inner), (low + 0.6 * high, 0.0)])
    cheeks = [extrude(wedge, 0.02, "x", (s * 0.46 * wide, 0, deep)) for s in (-1, 1)]
    if draw.chance(0.7):
        pieces += cheeks
        slope = np.array([(0, low + 0.02, deep - 0.15 * inner), (0, low + 0.6 * high, deep - inner)])
        tilt = np.degrees(np.arctan2(0.85 * inner, 0.58 * high))
        back = box((0.92 * wide, float(np.linalg.norm(slope[1] - slope[0])), 0.02))
        pieces.append(move(turn(back, X, -tilt), slope.mean(axis=0)))
    else:
        pieces.append(extrude(wedge, 0.92 * wide, "x", (0, 0, deep)))
    if draw.chance(0.6):
        pieces += pull(draw, 0.4 * wide, (0, 0.3 * high, deep + 0.04), vertical=False)
    at = (0, low, deep + draw.pick([0.0, 0.02, 0.04]))
    opens = draw.between(15.0, 50.0)
    return Mechanism(
        [MovingPart(draw.pick(["drawer", "bin", "door"]), pieces, _at_times_open(draw, hinge(at, X, 0.0, opens)))], sides
    )


def crank(draw: Draw) -> Mechanism:
    """Arm on an axle that stands on the mount, with a grip that turns freely on its end, or folds."""
    reach, rise, thick = draw.between(0.2, 0.48), draw.ratio(0.05, 0.5), draw.ratio(0.02, 0.07)
    axle = cylinder(0.8 * thick, rise, "z", (0, 0, 0.5 * rise), 12)
    bent = draw.chance(0.3)
    path = np.array([(0, 0, rise), (reach, 0, rise + (0.3 * reach if bent else 0.0))])
    arm = [sweep(path, 0.5 * thick, draw.pick([4, 8])), cylinder(thick, 2 * thick, "z", (0, 0, rise), 14)]
    if draw.chance(0.2):
        arm.append(cylinder(reach, 0.5 * thick, "z", (0, 0, rise), 28))
    end, long = path[1], draw.ratio(0.08, 0.35)
    grip = cylinder(draw.between(0.5, 1.2) * thick, long, "z", end + Z * 0.5 * long, 14)
    motion = spinner((0, 0, 0), Z) if draw.chance(0.8) else hinge((0, 0, 0), Z, -180.0, 180.0)
    turning = MovingPart(draw.pick(["crank", "lever", "handle"]), arm, motion)
    kind = draw.pick(["turns", "folds", "fixed"], [4, 1, 2])
    if kind == "fixed":
        return Mechanism([MovingPart(turning.name, [*arm, grip], motion)], [axle])
    grip_motion = spinner(end, Z) if kind == "turns" else hinge(end, Y, -90.0, 0.0)
    return Mechanism([turning, MovingPart(draw.pick(["knob", "grip", "handle"]), [grip], grip_motion, turning)], [axle])


def joystick(draw: Draw) -> Mechanism:
    """Yoke that tips about one line along the mount, with a stick in it that tips about the other."""
    high, long, thick = draw.ratio(0.05, 0.25), draw.ratio(0.2, 0.9), draw.ratio(0.02, 0.07)
    swing, cross = draw.between(10.0, 40.0), draw.between(10.0, 40.0)
    yoke = [
        ellipsoid((2 * thick, 2 * thick, 2 * thick), (0, 0, high), 14, 8),
        cylinder(thick, 6 * thick, "x", (0, 0, high), 12),
    ]
    stick = [cylinder(0.5 * thick, long, "z", (0, 0, high + 0.5 * long), 10, top_radius=thick * draw.between(0.4, 1.0))]
    if draw.chance(0.6):
        stick.append(ellipsoid(np.full(3, thick * draw.between(1.2, 2.5)), (0, 0, high + long), 14, 8))
    fixed = [tube(4 * thick, 2.6 * thick, high, "z", (0, 0, 0.5 * high), 20)]
    tipping = MovingPart(draw.pick(["frame", "yoke", "ball"]), yoke, hinge((0, 0, high), X * draw.sign(), -swing, swing))
    other = MovingPart(
        draw.pick(["stick", "lever", "handle"]), stick, hinge((0, 0, high), Y * draw.sign(), -cross, cross), tipping
    )
    return Mechanism([tipping, other], fixed)


def swing_arm(draw: Draw) -> Mechanism:
    """Arm that turns about a post on the mount, with a tray or screen that turns or tips on its end, or slides on it."""
    rise, reach, thick = draw.ratio(0.1, 0.8), draw.between(0.25, 0.6), draw.ratio(0.02, 0.06)
    post = cylinder(thick, rise + thick, "z", (0, 0, 0.5 * (rise + thick)), 14)
    way = draw.sign()
    arm = [
        box((reach, 1.6 * thick, 1.2 * thick), (0.5 * way * reach, 0, rise)),
        cylinder(1.6 * thick, 2 * thick, "z", (0, 0, rise), 14),
    ]
    swing = draw.between(45.0, 180.0)
    motion = spinner((0, 0, 0), Z) if draw.chance(0.3) else hinge((0, 0, 0), Z * draw.sign(), -swing, swing)
    first = MovingPart(draw.pick(["arm", "bar", "support"]), arm, motion)
    end, wide = np.array([way * reach, 0.0, rise]), draw.between(0.2, 0.6)
    load: list[Mesh] = [rounded_box((wide, wide * draw.between(0.5, 1.2), 0.03), 0.1 * wide, "z", end + Z * (thick + 0.02))]
    if draw.chance(0.3):
        load = [cylinder(0.5 * wide, 0.04, "z", end + Z * (thick + 0.02), 24)]
    elif draw.chance(0.3):
        load = [box((0.04, wide, 0.7 * wide), end + Z * (thick + 0.35 * wide))]
    turns = spinner(end, Z) if draw.chance(0.4) else hinge(end, Z, -90.0, 90.0)
    tips = hinge(end + Z * thick, Y, -draw.between(10.0, 60.0), draw.between(10.0, 60.0))
    slides = slider(X, *sorted((0.0, -way * 0.6 * reach)))
    kind = draw.pick([turns, tips, slides], [4, 2, 1])
    return Mechanism([first, MovingPart(draw.pick(["tray", "table", "screen", "plate"]), load, kind, first)], [post])


def hatch_pair(draw: Draw) -> Mechanism:
    """Two equal flaps over one opening that meet in the middle and open upwards."""
    half, high, thick = draw.between(0.15, 0.45), draw.between(0.3, 0.9), draw.ratio(0.015, 0.08)
    rim = draw.ratio(0.01, 0.15)
    fixed = [box((0.04, high + 0.08, rim), (s * (half + 0.02), 0, 0.5 * rim)) for s in (-1, 1)]
    fixed += [box((2 * half, 0.04, rim), (0, s * (0.5 * high + 0.02), 0.5 * rim)) for s in (-1, 1)]
    opens, name, grips = draw.between(60.0, 175.0), draw.pick(["door", "flap", "lid"]), draw.chance(0.5)
    level, moving = rim + draw.pick([0.0, 0.5, 1.0]) * thick, []
    for side, own in zip((-1.0, 1.0), draw.identical(2), strict=True):
        pieces = [box((half - 0.005, high, thick), (0.5 * side * half, 0, rim + 0.5 * thick))]
        if grips:
            pieces += pull(own, 0.3 * high, (0.15 * side * half, 0, rim + thick), vertical=True)
        moving.append(MovingPart(name, pieces, hinge((side * half, 0, level), Y * side, 0.0, opens)))
    return Mechanism(moving, fixed)


def _at_times_open(draw: Draw, motion: Motion) -> Motion:
    """The same hinge, at times shown open."""
    rest = draw.pick([0.0, draw.between(0.1, 1.0) * motion.b], [3, 1])
    return hinge(motion.origin, motion.direction, motion.a, motion.b, rest=rest)


COVERING = (hatch, hatch_pair, folding_panels, hood, swinging_plate, tipping_bin, crank, joystick, swing_arm)
"""All mechanisms that cover, fold or carry."""
