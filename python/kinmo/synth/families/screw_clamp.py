"""Screw clamps with a spindle that screws through the frame, and an arm that slides on bar clamps."""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.details.turning_handles import turning_handle
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box_between, cylinder, move, rotation_about, torus, tube
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, screw, slider


def build(draw: Draw) -> SynthObject:
    """C-clamp, or bar clamp with an arm that slides along the bar.

    The spindle screws through the frame or the arm.
    """
    shape = draw.pick([_c_clamp, _bar_clamp], [4, 3])(draw)
    posture = draw.pick([None, (X, 90.0), (Z, 90.0), (X, 180.0)], [4, 1, 1, 1])
    if posture is not None:
        shape.move(rotation_about(*posture))
    return shape


def _spindle(draw: Draw, low: float, high: float, radius: float) -> list[Mesh]:
    """A spindle along y at the origin, with a plate at its lower end and a handle at its top."""
    rod = cylinder(radius, high - low, "y", (0, 0.5 * (low + high), 0), 14)
    plate = cylinder(radius * draw.between(1.5, 2.8), 0.05, "y", (0, low, 0), 18)
    grip = turning_handle(draw, draw.between(0.15, 0.3), draw.between(0.06, 0.12))
    pieces = [rod, plate, *(move(piece, (0, high, 0)) for piece in grip)]
    if draw.chance(0.3):
        pieces += [torus(radius, 0.01, "y", (0, low + (0.2 + 0.1 * i) * (high - low), 0), 14, 4) for i in range(6)]
    return pieces


def _c_clamp(draw: Draw) -> SynthObject:
    """A C-shaped frame whose spindle screws down through its upper arm."""
    gap, deep = draw.between(0.6, 1.1), draw.between(0.4, 0.7)
    bar, thick = draw.between(0.1, 0.16), draw.between(0.06, 0.12)
    root = Node("Clamp")
    frame = [
        box_between((-deep - bar, -bar, -thick), (-deep, gap + bar, thick)),
        box_between((-deep, -bar, -thick), (0.12, 0.0, thick)),
        box_between((-deep, gap, -thick), (0.12, gap + bar, thick)),
        tube(0.1, 0.05, 1.5 * bar, "y", (0, gap + 0.5 * bar, 0), 16),
    ]
    body = root.add("base_body", *frame)
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    low = gap * draw.between(0.1, 0.9)
    spindle = root.add("screw", *_spindle(draw, low, low + gap + draw.between(0.3, 0.5), 0.045))
    motion = screw((0, draw.pick([0.0, gap]), 0), Y * draw.sign(), -0.2, 0.2, turns=draw.pick([None, None, 360.0]))
    return SynthObject("Clamp", root, [base, Link("screw", [spindle], base, motion)])


def _bar_clamp(draw: Draw) -> SynthObject:
    """A long bar with a fixed arm, and a sliding arm that carries the spindle."""
    length, deep, bar = draw.between(1.2, 2.0), draw.between(0.3, 0.5), draw.between(0.04, 0.07)
    root = Node("Clamp")
    rail = root.add("base_body", box_between((-bar, 0, -bar / 2), (bar, length, bar / 2)))
    rail.pieces.append(box_between((-bar, 0, -bar), (deep + 0.06, 2.5 * bar, bar)))
    base = Link("base_body", [rail], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    at = length * draw.between(0.4, 0.85)
    arm = root.add("slider", box_between((-2 * bar, at, -1.2 * bar), (deep + 0.08, at + 3 * bar, 1.2 * bar)))
    jaw = Link("slider", [arm], base, slider(Y, 3 * bar - at, length - at - 3 * bar))
    spindle = [move(piece, (deep, at, 0)) for piece in _spindle(draw, -0.25, 3 * bar + draw.between(0.15, 0.35), 0.03)]
    turned = screw((deep, at, 0), Y, -0.15, 0.15, turns=None)
    return SynthObject("Clamp", root, [base, jaw, Link("screw", [root.add("screw", *spindle)], jaw, turned)])
