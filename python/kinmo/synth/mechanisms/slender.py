"""Slender hand-held bodies with parts that come off their ends, fold out, lie along them or cross them.

Built along z and flat across y, then laid down or stood up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.posture import lay_down, turn_about_up
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.mechanisms.mount import mount
from kinmo.synth.mechanisms.sliding import keys, pusher, slot
from kinmo.synth.mechanisms.turning import knob, latch, rocker
from kinmo.synth.primitives import X, Y, Z, box, cylinder, mirror, rounded_box, rounded_path, sweep, tube, turn
from kinmo.synth.primitives.transforms import facing, rotation_about
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, screw, slider, spinner


@dataclass(frozen=True)
class _Bar:
    """A bar centred at the origin: its width along x, thickness along y and length along z."""

    wide: float
    thick: float
    long: float
    is_round: bool

    @property
    def end(self) -> float:
        """Position of the end face along z."""
        return 0.5 * self.long

    def section(self, draw: Draw, share: float, long: float, middle: float) -> Mesh:
        """A bar of `share` of the width and thickness, of length `long`, centred at z = `middle`."""
        if self.is_round:
            return cylinder(0.5 * share * self.wide, long, "z", (0, 0, middle), 20)
        size = (share * self.wide, share * self.thick, long)
        return box(size, (0, 0, middle)) if draw.chance(0.6) else rounded_box(size, 0.3 * self.wide, "y", (0, 0, middle))

    def shell(self, share: float, long: float, middle: float) -> list[Mesh]:
        """The same as a shell, open at both ends."""
        if self.is_round:
            return [tube(0.5 * share * self.wide, 0.45 * share * self.wide, long, "z", (0, 0, middle), 20)]
        wide, thick = share * self.wide, share * self.thick
        sides = [box((wide, 0.1 * thick, long), (0, s * 0.45 * thick, middle)) for s in (-1, 1)]
        return sides + [box((0.08 * wide, thick, long), (s * 0.46 * wide, 0, middle)) for s in (-1, 1)]


def slender(draw: Draw, crowded: bool) -> SynthObject:
    """Slender body with one kind of moving part, laid down or stood up. A crowded one often has a mechanism on its flat."""
    root = Node("mechanism")
    base = Link("body", [], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    wide = draw.between(0.08, 0.5)
    is_round = draw.chance(0.3)
    bar = _Bar(wide, wide if is_round else wide * draw.between(0.15, 1.0), draw.between(0.5, 1.2), is_round)
    kinds = [_sheathed, _telescoped, _twisted, _folding, _covered, _lever, _twin, _winged]
    weights = [3, 3, 2 if is_round else 1, 4, 2, 3, 2, 4]
    kind = draw.pick(kinds, weights)
    made = kind(draw, bar)
    base.nodes.append(root.add(draw.pick(["body", "handle", "frame"]), *made.fixed))
    links = [base, *mount(draw, Mechanism(made.moving), 1.0, np.eye(4), root, base)]
    if draw.chance(0.6 if crowded else 0.15) and not is_round:
        built = draw.pick([pusher, slot, keys, knob, rocker, latch])(draw)
        place = Y * 0.5 * bar.thick - Z * draw.between(0.0, 0.4) * bar.end
        size = draw.between(0.4, 0.95) * bar.wide
        links += mount(draw, built, size, facing(Y, draw.pick([Z, -Z]), place), root, base)
    shape = SynthObject("Mechanism", root, links)
    if kind is _winged and draw.chance(0.6):  # upright, like worn glasses and gates
        shape.move(rotation_about(Z, 90.0 * draw.sign()))
        turn_about_up(draw, shape)
    else:
        lay_down(draw, shape)
    return shape


def _sheathed(draw: Draw, bar: _Bar) -> Mechanism:
    """Core with a cap or sheath over its end that slides, screws or turns off."""
    covered = draw.between(0.1, 0.6) * bar.long
    core = [bar.section(draw, 0.8, bar.long, 0.0)]
    if draw.chance(0.5):
        core.append(bar.section(draw, 1.0, bar.long - covered, -0.5 * covered))
    middle = bar.end - 0.45 * covered
    sleeve = bar.shell(1.0, covered, middle) if draw.chance(0.5) else [bar.section(draw, 1.02, covered, middle)]
    off = slider(Z, 0.0, covered)
    motion = draw.pick([off, screw((0, 0, 0), Z, 0.0, covered), spinner((0, 0, 0), Z)], [4, 1, 1]) if bar.is_round else off
    return Mechanism([MovingPart(draw.pick(["cap", "lid", "sheath", "cover"]), sleeve, motion)], core)


def _telescoped(draw: Draw, bar: _Bar) -> Mechanism:
    """Core that slides out of a shell."""
    out, inside = draw.between(0.05, 0.6) * bar.long, draw.between(0.2, 0.9) * bar.long
    middle = bar.end + out - 0.5 * (out + inside)
    core = [bar.section(draw, draw.between(0.6, 0.88), out + inside, middle)]
    if draw.chance(0.3):
        core.append(box((0.3 * bar.wide, 0.4 * bar.thick, 0.1 * bar.long), (0, 0.6 * bar.thick, 0.0)))
    motion = slider(Z * draw.sign(), -draw.between(0.1, 1.0) * out, draw.between(0.0, 0.8) * inside)
    name = draw.pick(["blade", "rod", "slider", "body"])
    return Mechanism([MovingPart(name, core, motion)], bar.shell(1.0, bar.long, 0.0))


def _twisted(draw: Draw, bar: _Bar) -> Mechanism:
    """Two parts of a bar that turn about its length relative to each other."""
    share = draw.between(0.1, 0.5)
    held = bar.section(draw, 1.0, (1 - share) * bar.long, -0.5 * share * bar.long)
    turning = [bar.section(draw, draw.between(0.7, 1.15), share * bar.long, bar.end - 0.5 * share * bar.long)]
    if draw.chance(0.3):
        turning.append(box((1.3 * bar.wide, 0.3 * bar.thick, 0.3 * share * bar.long), (0, 0, bar.end)))
    motion = draw.pick([spinner((0, 0, 0), Z), screw((0, 0, 0), Z, 0.0, 0.3 * share * bar.long)], [3, 1])
    return Mechanism([MovingPart(draw.pick(["knob", "cap", "head", "rod"]), turning, motion)], [held])


def _folding(draw: Draw, bar: _Bar) -> Mechanism:
    """Flat bars on pins near the ends that fold out in the plane of the body."""
    moving, fixed = [], bar.shell(1.0, bar.long, 0.0)[:3] if draw.chance(0.5) else [bar.section(draw, 1.0, bar.long, 0.0)]
    count = draw.pick([1, 2, 3], [5, 3, 1])
    thick = draw.between(0.3, 0.8) * bar.thick / count
    for index in range(count):
        end = 1.0 if index % 2 == 0 or draw.chance(0.4) else -1.0
        pin = np.array([draw.between(-0.2, 0.2) * bar.wide, 0.0, 0.9 * end * bar.end])
        long, wide = draw.between(0.4, 0.95) * bar.long, draw.between(0.3, 0.9) * bar.wide
        level = (index - 0.5 * (count - 1)) * 1.1 * thick
        if draw.chance(0.3):
            level += 0.6 * (bar.thick + thick)
        flat = box((wide, thick, long), pin + Z * 0.45 * long + Y * level)
        pieces = [turn(flat, Y, 180.0 if end > 0 else 0.0, pin)]  # the closed bar lies along the body
        if draw.chance(0.4):
            pieces.append(cylinder(0.25 * wide, 1.1 * thick, "y", pin + Y * level, 12))
        opening = draw.between(60.0, 180.0)
        rest = draw.pick([0.0, opening, draw.between(0.0, 1.0) * opening], [2, 2, 1])
        motion = hinge(pin, Y * draw.sign(), 0.0, opening, rest=rest)
        moving.append(MovingPart(draw.pick(["blade", "arm", "leg", "hook"]), pieces, motion))
    return Mechanism(moving, fixed)


def _covered(draw: Draw, bar: _Bar) -> Mechanism:
    """Lid at the end that tips, or a bent sheet around the body that turns about a pin through its flat."""
    if draw.chance(0.5):
        long = draw.between(0.15, 0.45) * bar.long
        held = bar.section(draw, 1.0, bar.long - long, -0.5 * long)
        lid = bar.section(draw, draw.between(0.85, 1.0), long, bar.end - 0.5 * long)
        across, half = draw.pick([("x", bar.thick), ("y", bar.wide)])
        axis = np.eye(3)[0 if across == "x" else 1]
        place = np.array([0.0, 0.5, 0.0] if across == "x" else [0.5, 0.0, 0.0]) * half * draw.sign() + Z * (bar.end - long)
        fixed = [held, cylinder(0.08 * half, 0.4 * bar.wide, across, place, 10)]
        motion = hinge(place, axis * draw.sign(), 0.0, draw.between(60.0, 150.0))
        return Mechanism([MovingPart(draw.pick(["lid", "cap", "cover"]), [lid], motion)], fixed)
    long, gap = draw.between(0.6, 1.0) * bar.long, 0.06 * bar.thick
    level = 0.5 * bar.thick + gap
    pin = Z * (bar.end - draw.pick([0.1, 0.5, 0.85]) * long)
    sheet = [box((0.95 * bar.wide, gap, long), (0, s * level, bar.end - 0.45 * long)) for s in (-1, 1)]
    if draw.chance(0.6):
        sheet.append(box((0.95 * bar.wide, 2 * level, gap), (0, 0, bar.end + 0.05 * long)))
    pins = [cylinder(0.15 * bar.wide, 2 * gap, "y", pin + Y * s * level, 12) for s in (-1, 1)]
    motion = draw.pick([spinner(pin, Y), hinge(pin, Y, 0.0, draw.between(90.0, 180.0))])
    fixed = [bar.section(draw, 1.0, bar.long, 0.0), *pins]
    return Mechanism([MovingPart(draw.pick(["cover", "lid", "shell"]), sheet, motion)], fixed)


def _lever(draw: Draw, bar: _Bar) -> Mechanism:
    """Bar along the flat of the body that tips about a pin across it, sometimes with a second bar below."""
    long, thick = draw.between(0.4, 1.0) * bar.long, draw.between(0.1, 0.8) * bar.thick
    gap, place = draw.between(0.0, 0.5) * bar.thick, draw.pick([-1.0, -1.0, draw.between(-1.0, 0.0)])
    pin = np.array([0.0, 0.5 * bar.thick + gap, place * 0.5 * long])
    wide = draw.between(0.4, 1.0) * bar.wide
    pieces = [box((wide, thick, long), (0, 0.5 * (bar.thick + thick) + gap, 0))]
    fixed = [bar.section(draw, 1.0, bar.long, 0.0)]
    if draw.chance(0.7):
        fixed += [box((0.1 * bar.wide, gap + thick, 0.1 * long), pin + (s * 0.55 * wide, 0.2 * thick, 0)) for s in (-1, 1)]
    raised = draw.pick([0.0, -draw.between(0.0, 25.0)])
    pieces = [turn(piece, X, raised, pin) for piece in pieces]
    name = draw.pick(["lever", "arm", "body", "lid"])
    moving = [MovingPart(name, pieces, hinge(pin, X, -draw.between(10.0, 100.0), draw.between(0.0, 5.0)))]
    if draw.chance(0.35):
        under = box((0.8 * wide, 0.5 * thick, 0.95 * long), (0, 0.5 * bar.thick + gap - 0.3 * thick, 0))
        also = [turn(under, X, draw.between(0.0, 1.0) * raised, pin)]
        moving.append(MovingPart(name, also, hinge(pin, X, -draw.between(5.0, 60.0), draw.between(0.0, 5.0))))
    return Mechanism(moving, fixed)


def _twin(draw: Draw, bar: _Bar) -> Mechanism:
    """Two equal bars, one over the other, on a common pin. They cross at the pin, or open like a fan."""
    thick, angle = 0.45 * bar.thick, draw.between(5.0, 40.0)
    pin = Z * draw.pick([0.9, draw.between(-0.3, 0.6)]) * bar.end
    one = rounded_box((0.5 * bar.wide, thick, bar.long), 0.2 * bar.wide, "y", (0, 0.5 * thick, 0))
    two = mirror(one, 1)
    if draw.chance(0.4):
        rings = [tube(0.4 * bar.wide, 0.3 * bar.wide, 2 * thick, "y", (0.3 * s * bar.wide, 0, -bar.end), 18) for s in (-1, 1)]
        pieces = [[one, rings[0]], [two, rings[1]]]
    else:
        pieces = [[one], [two]]
    opened = [[turn(piece, Y, s * angle, pin) for piece in half] for s, half in zip((1, -1), pieces, strict=True)]
    rivet = cylinder(0.15 * bar.wide, 2.5 * thick, "y", pin, 12)
    motion = hinge(pin, Y * draw.sign(), -draw.between(10.0, 60.0), draw.between(10.0, 60.0))
    return Mechanism([MovingPart(draw.pick(["leg", "blade", "jaw", "arm"]), opened[1], motion)], [*opened[0], rivet])


def _winged(draw: Draw, bar: _Bar) -> Mechanism:
    """Bar or plate with two equal arms hinged at its ends, standing out or folded against it."""
    long, thick = draw.between(0.5, 1.3) * bar.long, draw.between(0.05, 0.3) * bar.wide
    fixed = [bar.section(draw, 1.0, bar.long, 0.0)]
    upright = draw.chance(0.8)  # pins through the body's width, or through its flat
    swing, name, tall = draw.between(80.0, 110.0), draw.pick(["leg", "arm", "wing"]), draw.between(0.2, 0.9)
    rest = draw.pick([0.0, draw.between(0.1, 0.9) * swing, draw.between(0.95, 1.0) * swing], [3, 1, 2])
    bent = draw.pick([0.0, draw.between(0.1, 0.4)])
    moving = []
    for side in (-1.0, 1.0):
        pin = Z * side * bar.end
        if upright:
            pin = pin + Y * (0.5 * bar.thick + thick * (side > 0))  # when folded, one arm lies on the other
            arm = [box((tall * bar.wide, long, thick), pin + Y * 0.5 * long)]
            if bent:
                path = np.array([pin, pin + Y * 0.7 * long, pin + Y * long - X * bent * bar.wide])
                arm = [sweep(rounded_path(path, 0.1 * long), thick, 8)]
            axis = X * -side
            knuckle = cylinder(0.6 * thick, tall * bar.wide, "x", pin, 10)
        else:
            pin = pin + X * (0.5 * bar.wide + thick * (side > 0))
            arm = [box((long, tall * bar.thick, thick), pin + X * 0.5 * long)]
            axis = Y * side
            knuckle = cylinder(0.6 * thick, tall * bar.thick, "y", pin, 10)
        if draw.chance(0.5):
            fixed.append(knuckle)
        moving.append(MovingPart(name, arm, hinge(pin, axis, -5.0, swing, rest=rest)))
    return Mechanism(moving, fixed)
