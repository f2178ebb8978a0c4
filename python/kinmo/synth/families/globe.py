"""Globes: a ball on a tilted axis between the ends of a bow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Y, Z, arc_path, box, cylinder, ellipsoid, lathe, sweep, torus, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, spinner


def build(draw: Draw) -> SynthObject:
    """Globe whose ball turns about a tilted axis.

    The bow is fixed, turns on its foot, or tips about a horizontal line.
    """
    radius, tilt = 0.5, draw.pick([23.5, draw.between(0.0, 45.0), 0.0], [3, 3, 1])
    tilt *= draw.sign()
    lift = radius + draw.between(0.25, 0.7)
    center = np.array([0.0, lift, 0.0])
    axis = np.array([-np.sin(np.radians(tilt)), np.cos(np.radians(tilt)), 0.0])
    root = Node("globe")
    rod, gap = draw.between(0.012, 0.03), draw.between(0.03, 0.08)
    ball = root.add("sphere", ellipsoid(np.full(3, radius), center, draw.pick([16, 24, 32]), draw.pick([10, 16])))
    ball.pieces[0] = turn(ball.pieces[0], Z, tilt, center)
    if draw.chance(0.3):
        ball.pieces.append(turn(torus(1.005 * radius, 0.01, "y", center, 32, 6), Z, tilt, center))

    frame = root.add("frame")
    reach = radius + gap
    half_turn = draw.chance(0.7)
    bow_arc = arc_path(center, reach, -90.0 + tilt, (90.0 if half_turn else 270.0) + tilt, "z", 25)
    bow = sweep(bow_arc, rod, 8)
    if draw.chance(0.3):
        bow = turn(bow, axis, 180.0, center)
    pins = _pins(draw, center, radius, reach + rod, 0.6 * rod)
    ring = frame.add("circle", bow, *(turn(pin, Z, tilt, center) for pin in pins))
    foot = frame.add("base", *_foot(draw, lift - reach))
    base = Link("base", [foot], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    kind = draw.pick(["fixed", "swivel", "tipping"], [5, 1, 1])
    holder = base
    links = [base]
    if kind == "fixed":
        base.nodes.append(ring)
    else:
        swing = hinge((0, 0, 0), Y, -180.0, 180.0) if kind == "swivel" else hinge(center, Z, -30.0, 30.0)
        holder = Link("circle", [ring], base, swing)
        links.append(holder)
    if kind == "tipping":
        arms = [box((0.04, lift, 0.04), (0, 0.5 * lift, s * (reach + rod + 0.02))) for s in (-1, 1)]
        foot.pieces += [*arms, box((0.1, 0.04, 2 * reach), (0, 0.02, 0))]
    origin = center + axis * draw.pick([0.0, reach, -reach])
    links.append(Link("sphere", [ball], holder, spinner(origin, axis * draw.sign())))
    return SynthObject("Globe", root, links)


def _pins(draw: Draw, center: NDArray[np.float64], radius: float, reach: float, thick: float) -> list[Mesh]:
    """Bearings of the ball at its poles: a rod through it, or a pin at each end of the bow."""
    if draw.chance(0.5):
        return [cylinder(thick, 2.0 * reach, "y", center, 8)]
    long = reach - 0.98 * radius
    return [cylinder(thick, long, "y", center + Y * side * (reach - 0.5 * long), 8) for side in (-1.0, 1.0)]


def _foot(draw: Draw, height: float) -> list[Mesh]:
    """The foot, up to `height`: a disc, a turned foot or a cross."""
    wide = draw.between(0.25, 0.5)
    kind = draw.pick(["disc", "turned", "cross"], [2, 3, 1])
    if kind == "cross":
        bars = [turn(box((2 * wide, 0.05, 0.08), (0, 0.025, 0)), Y, angle) for angle in (0.0, 90.0)]
        return [*bars, cylinder(0.04, height, "y", (0, 0.5 * height, 0), 12)]
    if kind == "disc":
        return [cylinder(wide, 0.05, "y", (0, 0.025, 0), 28), cylinder(0.04, height, "y", (0, 0.5 * height, 0), 12)]
    profile = [[0, 0], [wide, 0], [wide, 0.1], [0.3 * wide, 0.3], [0.1, 0.5], [0.2, 0.7], [0.06, 1.0], [0, 1.0]]
    return [lathe(np.array(profile) * (1.0, height), 24)]
