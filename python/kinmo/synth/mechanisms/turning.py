"""Mechanisms that turn: flaps, dials, rollers, rotors, swivels, taps, levers, rockers, treadles, latches and bails."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import dial
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.primitives import X, Y, Z, arc_path, box, cylinder, ellipsoid, move, rounded_box, rounded_path, sweep, turn
from kinmo.synth.synth_object import Motion, hinge, spinner


def flap(draw: Draw) -> Mechanism:
    """Panel with its hinge along one edge, often with visible knuckles there and a handle at the opposite edge."""
    wide, high = draw.between(0.4, 0.95), draw.between(0.3, 0.95)
    thick = draw.pick([draw.between(0.02, 0.12), draw.between(0.12, 0.4)], [4, 1])
    lift = draw.pick([0.0, draw.between(0.02, 0.5)])
    size, middle = (wide, high, thick), (0.0, 0.0, lift + 0.5 * thick)
    panel = box(size, middle) if draw.chance(0.7) else rounded_box(size, 0.2 * min(wide, high), "z", middle)
    at = (draw.pick([0.0, draw.between(0.0, 0.08)]) * wide - 0.5 * wide, 0.0, lift + draw.pick([0.0, 0.5, 1.0]) * thick)
    pieces, fixed = [panel], []
    if lift > 0:
        fixed.append(box((wide, high, lift), (0, 0, 0.5 * lift)))
    if draw.chance(0.5):
        pieces += pull(draw, 0.3 * high, (0.4 * wide, 0, lift + thick), vertical=draw.chance(0.8))
    if draw.chance(0.4):
        knuckles = [
            cylinder(0.3 * thick + 0.008, 0.15 * high, "y", (at[0] - 0.2 * thick, y * high, at[2]), 12) for y in (-0.35, 0.35)
        ]
        draw.pick([pieces, fixed]).extend(knuckles)
    opening = draw.pick([draw.between(60.0, 130.0), draw.between(4.0, 30.0)], [5, 1])
    motion = hinge(at, -Y, 0.0, opening) if draw.chance(0.5) else hinge(at, Y, -opening, 0.0)
    name = draw.pick(["lid", "door", "cover", "flap", "panel", "screen"])
    return Mechanism([MovingPart(name, pieces, _sometimes_open(draw, motion))], fixed)


def wing(draw: Draw) -> Mechanism:
    """Plate that stands out from the mount on a hinge, bare or on two ears: a table leaf, a footrest, a visor."""
    wide, out, thick = draw.between(0.3, 1.0), draw.between(0.2, 0.9), draw.between(0.02, 0.12)
    held = draw.pick(["bare", "axle", "ears"], [4, 3, 3])
    height = draw.pick([0.0, draw.between(0.02, 0.2)]) if held == "ears" else 0.0
    size, middle = (wide, thick, out), (0, draw.pick([-0.5, 0.0, 0.5]) * thick, height + 0.5 * out)
    plate = box(size, middle) if draw.chance(0.6) else rounded_box(size, 0.2 * min(wide, out), "y", middle)
    pieces, fixed = [plate], []
    if held == "axle":
        fixed = [cylinder(0.5 * thick + 0.01, wide, "x", (0, 0, height), 12)]
    elif held == "ears":
        fixed = [box((0.04, 1.5 * thick, height + 0.06), (s * (0.5 * wide + 0.02), 0, 0.5 * height + 0.03)) for s in (-1, 1)]
    swing = draw.between(40.0, 100.0)
    motion = hinge((0, 0, height), X * draw.sign(), 0.0, swing, rest=draw.pick([0.0, draw.between(0.0, 1.0) * swing]))
    return Mechanism([MovingPart(draw.pick(["board", "lid", "tray", "panel", "cover"]), pieces, motion)], fixed)


def knob(draw: Draw) -> Mechanism:
    """Dial that turns about the mount's normal."""
    pieces = dial(draw, draw.between(0.12, 0.42), draw.between(0.08, 0.5), (0, 0, 0))
    return Mechanism([MovingPart(draw.pick(["knob", "dial", "button"]), pieces, _hinge_about(draw, Z))])


def roller(draw: Draw) -> Mechanism:
    """Wheel, drum or reel between two cheeks that turns about a line along the mount."""
    wide, radius = draw.between(0.08, 0.7), draw.between(0.12, 0.35)
    height = draw.between(0.6, 1.3) * radius + 0.1
    cheek = draw.between(0.02, 0.06)
    fixed = [
        box((cheek, draw.between(0.1, 0.3), height + 0.05), (s * (0.5 * wide + cheek), 0, 0.5 * height + 0.025))
        for s in (-1, 1)
    ]
    axle = cylinder(0.12 * radius, wide + 2 * cheek, "x", (0, 0, height), 10)
    pieces = [move(piece, (0, 0, height)) for piece in _wheel(draw, radius, wide)]
    if draw.chance(0.2):
        pieces = [ellipsoid((0.5 * wide, radius, radius), (0, 0, height), 24, 12)]
    name = draw.pick(["wheel", "roller", "drum", "sphere"])
    return Mechanism([MovingPart(name, [*pieces, axle], spinner((0, 0, height), X))], fixed)


def rotor(draw: Draw) -> Mechanism:
    """Blades, a disc, a crank or a hand that turns on an axle standing on the mount."""
    length, radius = draw.between(0.05, 0.5), draw.between(0.25, 0.48)
    hub = cylinder(draw.between(0.05, 0.12), draw.between(0.05, 0.15), "z", (0, 0, length), 16)
    kind = draw.pick(["blades", "disc", "crank", "hand"], [4, 2, 2, 2])
    pieces = [hub]
    if kind == "disc":
        pieces.append(cylinder(radius, draw.between(0.02, 0.1), "z", (0, 0, length), 28))
    elif kind == "crank":
        pieces.append(box((radius, 0.07, 0.03), (0.5 * radius, 0, length)))
        pieces.append(cylinder(0.035, draw.between(0.1, 0.3), "z", (radius, 0, length + 0.1), 12))
    elif kind == "hand":
        pieces.append(box((radius, draw.between(0.02, 0.08), 0.02), (0.4 * radius, 0, length)))
    else:
        blade = turn(box((radius, draw.between(0.08, 0.25), 0.015), (0.5 * radius, 0, 0)), X, draw.between(0.0, 35.0))
        count = draw.integer(2, 6)
        pieces += [move(turn(blade, Z, 360.0 * i / count), (0, 0, length)) for i in range(count)]
    axle = cylinder(0.04, length, "z", (0, 0, 0.5 * length), 12)
    return Mechanism(
        [MovingPart(draw.pick(["rotor", "wheel", "hand", "blade", "lever"]), pieces, _hinge_about(draw, Z))], [axle]
    )


def swivel(draw: Draw) -> Mechanism:
    """Plate, seat, screen, spout or head that turns about its post."""
    length, radius = draw.between(0.05, 0.6), draw.between(0.03, 0.14)
    post = cylinder(radius, length, "z", (0, 0, 0.5 * length), 16)
    pieces = [move(piece, (0, 0, length)) for piece in post_top(draw)]
    name = draw.pick(["seat", "head", "spout", "screen", "top", "table"])
    return Mechanism([MovingPart(name, pieces, _hinge_about(draw, Z))], [post])


def tap(draw: Draw) -> Mechanism:
    """Cap on a post with a grip that reaches out or up. It turns about the post, or tips."""
    length, radius = draw.between(0.05, 0.5), draw.between(0.06, 0.2)
    post = cylinder(radius, length, "z", (0, 0, 0.5 * length), 18)
    size, high = draw.between(0.9, 1.3) * radius, draw.between(0.5, 1.6) * radius
    top = cylinder(size, high, "z", (0, 0, length + 0.5 * high), 18, top_radius=draw.between(0.6, 1.0) * size)
    out, rise = draw.between(0.25, 0.7), draw.between(-0.2, 0.7)
    path = np.array([(0, 0, length + 0.6 * high), (0, -out, length + 0.6 * high + rise * out)])
    grips = [sweep(path, draw.between(0.1, 0.4) * radius, draw.pick([4, 8]))]
    if draw.chance(0.2):
        grips = [turn(grips[0], Z, 360.0 * index / 4) for index in range(4)]
    tipped = hinge((0, 0, length + 0.5 * high), X * draw.sign(), -draw.between(5.0, 40.0), draw.between(5.0, 40.0))
    motion = _hinge_about(draw, Z) if len(grips) > 1 or draw.chance(0.7) else tipped
    return Mechanism([MovingPart(draw.pick(["switch", "handle", "lever", "knob"]), [top, *grips], motion)], [post])


def lever(draw: Draw) -> Mechanism:
    """Stick that tips about a line along the mount, between cheeks, on a ball or in a slot."""
    height, length, thick = draw.between(0.0, 0.2), draw.between(0.3, 1.0), draw.between(0.03, 0.1)
    stick = box((thick, thick, length), (0, 0, height + 0.5 * length))
    if draw.chance(0.5):
        stick = sweep(np.array([(0, 0, height), (0, 0, height + length)]), 0.5 * thick, 10)
    pieces, fixed = [stick], []
    kind = draw.pick(["cheeks", "ball", "slot"])
    if kind == "cheeks":
        fixed = [box((0.04, 0.16, height + 0.1), (s * (0.5 * thick + 0.03), 0, 0.5 * height + 0.05)) for s in (-1, 1)]
    elif kind == "ball":
        pieces.append(ellipsoid((thick, thick, thick), (0, 0, height), 14, 8))
        fixed = [cylinder(1.2 * thick, height + 0.02, "z", (0, 0, 0.5 * height), 16)]
    else:
        fixed = [box((0.15, 0.6, height + 0.02), (s * (0.5 * thick + 0.08), 0, 0.5 * height)) for s in (-1, 1)]
    if draw.chance(0.5):
        pieces.append(ellipsoid((thick, thick, 1.2 * thick), (0, 0, height + length), 14, 8))
    swing = draw.between(15.0, 60.0)
    motion = _sometimes_open(draw, hinge((0, 0, height), X * draw.sign(), -swing, swing))
    return Mechanism([MovingPart(draw.pick(["lever", "handle", "stick", "switch"]), pieces, motion)], fixed)


def rocker(draw: Draw) -> Mechanism:
    """Plate that tips about its middle, in a frame or on a ridge."""
    wide, high, thick = draw.between(0.25, 0.8), draw.between(0.25, 0.9), draw.between(0.05, 0.2)
    plate = turn(box((wide, high, thick), (0, 0, 0.6 * thick)), X, draw.sign() * draw.between(0.0, 12.0))
    fixed = []
    if draw.chance(0.6):
        fixed = [box((0.06, high + 0.16, 0.8 * thick), (s * (0.5 * wide + 0.05), 0, 0.4 * thick)) for s in (-1, 1)]
        fixed += [box((wide + 0.04, 0.06, 0.8 * thick), (0, s * (0.5 * high + 0.05), 0.4 * thick)) for s in (-1, 1)]
    swing = draw.between(5.0, 20.0)
    motion = hinge((0, 0, draw.pick([0.0, 0.5]) * thick), X, -swing, swing)
    return Mechanism([MovingPart(draw.pick(["switch", "button", "lever", "pedal"]), [plate], motion)], fixed)


def treadle(draw: Draw) -> Mechanism:
    """Pads or keys side by side that tip about their rear edge, where their support rises."""
    count, high, gap = draw.pick([1, 2, 3], [3, 4, 1]), draw.between(0.3, 0.9), draw.between(0.01, 0.06)
    wide, thick = 0.9 / count, draw.between(0.03, 0.12)
    level = draw.pick([0.0, draw.between(0.02, 0.2)])
    size, swing = (wide - gap, high, thick), draw.between(3.0, 15.0)
    name = draw.pick(["button", "pedal", "pad", "key"], [3, 1, 1, 1])
    deep, tall = draw.between(0.1, 0.4), level + draw.between(0.5, 2.0) * thick
    fixed = [box((0.9, deep, tall), (0, 0.5 * (high + deep), 0.5 * tall))] if level or draw.chance(0.8) else []
    moving, rounded = [], draw.chance(0.4)
    for index in range(count):
        middle = ((index - 0.5 * (count - 1)) * wide, 0.0, level + 0.5 * thick)
        pad = rounded_box(size, 0.15 * min(size[:2]), "z", middle) if rounded else box(size, middle)
        at = (middle[0], 0.5 * high, level + draw.pick([0.0, 0.5]) * thick)
        moving.append(MovingPart(name, [pad], hinge(at, X, -0.1 * swing, swing)))
    return Mechanism(moving, fixed)


def latch(draw: Draw) -> Mechanism:
    """Bar that lies on the mount and turns on it about a pin near one end."""
    long, wide, thick = draw.between(0.4, 0.9), draw.between(0.06, 0.2), draw.between(0.02, 0.08)
    shift = draw.between(0.25, 0.42) * long
    bar = box((long, wide, thick), (shift, 0, 0.5 * thick))
    pin = cylinder(draw.between(0.2, 0.45) * wide, 2 * thick, "z", (0, 0, thick), 12)
    parts = [bar, pin] if draw.chance(0.5) else [bar]
    motion = hinge((0, 0, 0), Z * draw.sign(), -draw.between(10.0, 90.0), draw.between(10.0, 90.0))
    return Mechanism([MovingPart(draw.pick(["latch", "hook", "hand", "arm"]), parts, motion)], [] if len(parts) > 1 else [pin])


def bail(draw: Draw) -> Mechanism:
    """Bow or frame that tips about the line through its two ends: a bail, a stand, folding legs."""
    half, long, thick = draw.between(0.2, 0.46), draw.between(0.25, 1.0), draw.between(0.015, 0.05)
    height = draw.between(0.0, 0.3)
    if draw.chance(0.4):
        path = arc_path((0, 0, height), long, -90, 90, "y", 16, aspect=half / long)
    else:
        narrow = draw.between(0.7, 1.0) * half
        corners = [(-half, 0, height), (-narrow, 0, height + long), (narrow, 0, height + long), (half, 0, height)]
        path = rounded_path(np.array(corners), draw.between(0.02, 0.2))
    pieces: list[Mesh] = [sweep(path, thick, 8)]
    if draw.chance(0.3):
        pieces.append(cylinder(1.6 * thick, half, "x", (0, 0, height + long), 12))
    ears = [box((0.05, 0.12, height + 0.06), (s * (half + thick + 0.02), 0, 0.5 * height + 0.03)) for s in (-1, 1)]
    swing = draw.between(40.0, 88.0)
    motion = hinge((0, 0, height), X * draw.sign(), -swing, swing, rest=draw.pick([0.0, draw.between(-1.0, 1.0) * swing]))
    return Mechanism([MovingPart(draw.pick(["handle", "leg", "stand", "foot"]), pieces, motion)], ears)


def post_top(draw: Draw) -> list[Mesh]:
    """Meshes on a post that ends at the origin: a plate, a seat with a back, a screen, a spout or a head."""
    kind = draw.pick(["plate", "seat", "screen", "spout", "head"])
    wide, deep = draw.between(0.4, 0.95), draw.between(0.4, 0.95)
    if kind == "plate":
        return [rounded_box((wide, deep, 0.06), 0.1, "z", (draw.between(-0.1, 0.1), 0, 0.03))]
    if kind == "seat":
        back = box((wide, 0.06, draw.between(0.3, 0.8)), (0, 0.5 * deep, 0.3))
        return [box((wide, deep, 0.1), (0, 0, 0.05)), back]
    if kind == "screen":
        return [box((wide, 0.05, 0.7 * deep), (0, draw.between(-0.1, 0.1), 0.35 * deep))]
    if kind == "spout":
        rise, reach = draw.between(0.1, 0.5), draw.between(0.3, 0.8)
        path = rounded_path(np.array([(0, 0, 0), (0, 0, rise), (0, reach, rise), (0, reach, 0.6 * rise)]), 0.3 * rise)
        return [sweep(path, draw.between(0.02, 0.06), 10)]
    cone = cylinder(0.08, draw.between(0.2, 0.5), "y", (0, 0.1, 0.12), 20, top_radius=draw.between(0.1, 0.3))
    return [cone, cylinder(0.06, 0.14, "z", (0, 0, 0.07), 12)]


def _wheel(draw: Draw, radius: float, wide: float) -> list[Mesh]:
    """A wheel about x at the origin, solid or with spokes."""
    if draw.chance(0.6):
        return [cylinder(radius, wide, "x", (0, 0, 0), draw.pick([16, 24, 32]))]
    count = draw.integer(3, 6)
    spoke = box((0.5 * wide, 0.1 * radius, radius), (0, 0, 0.5 * radius))
    return [cylinder(0.25 * radius, wide, "x", (0, 0, 0), 14), *(turn(spoke, X, 360.0 * i / count) for i in range(count))]


def _hinge_about(draw: Draw, axis: np.ndarray) -> Motion:
    """Hinge through the origin along `axis`, free or limited."""
    if draw.chance(0.5):
        return spinner((0, 0, 0), axis * draw.sign())
    return hinge((0, 0, 0), axis * draw.sign(), -draw.between(20.0, 170.0), draw.between(20.0, 170.0))


def _sometimes_open(draw: Draw, motion: Motion) -> Motion:
    """The same hinge, sometimes shown open."""
    rest = motion.a + draw.between(0.0, 1.0) * (motion.b - motion.a) if draw.chance(0.35) else 0.0
    return hinge(motion.origin, motion.direction, motion.a, motion.b, rest=rest)


def globe(draw: Draw) -> Mechanism:
    """Ball or disc that turns in a bow, about the line through its two poles."""
    radius, height = draw.between(0.2, 0.42), draw.between(0.05, 0.2)
    center = (0, 0, height + radius + 0.05)
    ball = ellipsoid((radius, radius, radius), center, 24, 12) if draw.chance(0.7) else cylinder(radius, 0.06, "y", center, 28)
    path = arc_path(center, radius + 0.04, 90, 270, "y", 20)
    bow = sweep(path, draw.between(0.012, 0.03), 8)
    post = cylinder(0.04, center[2] - radius, "z", (0, 0, 0.5 * (center[2] - radius)), 12)
    pins = [cylinder(0.012, 0.1, "x", (s * (radius + 0.01), 0, center[2]), 10) for s in (-1, 1)]
    tilt = draw.pick([0.0, 90.0]) + draw.between(-40.0, 40.0)
    bow, *pins = (turn(piece, Y, tilt, center) for piece in (bow, *pins))
    axis = np.array([np.cos(np.radians(tilt)), 0.0, -np.sin(np.radians(tilt))])
    name = draw.pick(["sphere", "ball", "disc", "wheel"])
    return Mechanism([MovingPart(name, [turn(ball, Y, tilt, center)], spinner(center, axis * draw.sign()))], [bow, post, *pins])


STRETCHABLE_TURNING = (flap, flap, rocker)
"""Mechanisms that may be stretched to fill a side."""
TURNING = (flap, flap, flap, wing, knob, roller, rotor, swivel, tap, lever, rocker, treadle, latch, bail, globe)
"""All turning mechanisms. Frequent ones are listed more than once."""
