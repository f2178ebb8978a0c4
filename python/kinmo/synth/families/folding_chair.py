"""Folding chairs: a back frame, and a seat and legs that fold against it."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, box, cylinder, rounded_box, sweep, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge


def build(draw: Draw) -> SynthObject:
    """Folding chair whose seat and rear legs turn about horizontal lines at the back frame.

    Built open. The back frame runs from the front feet up and back; the rear legs cross it below the seat.
    """
    width, seat, height = draw.between(0.7, 0.95), draw.between(0.75, 0.95), draw.between(1.5, 1.9)
    rod = draw.between(0.018, 0.035)
    half = 0.5 * width
    foot, lean = draw.between(0.25, 0.45), draw.between(0.35, 0.6)
    slope = (-lean - foot) / height

    def line(y: float) -> float:
        """Position of the back frame along z at a height."""
        return foot + slope * y

    root = Node("chair")
    back = root.add("chair_back")
    sides = [_rod([(s * half, 0, foot), (s * half, height, line(height))], rod) for s in (-1, 1)]
    bars = [cylinder(rod, width, "x", (0, height, line(height)), 10), cylinder(rod, width, "x", (0, 0.15, line(0.15)), 10)]
    back.add("back_frame", *sides, *(bars if draw.chance(0.7) else bars[:1]))
    back.add("back_surface", *_back_surface(draw, width, seat, height, slope, foot))
    base = Link("back", [back], kind=draw.pick([JointType.FREE, JointType.STATIC]))

    depth = draw.between(0.6, 0.85)
    thick = draw.between(0.02, 0.06)
    rear = line(seat) - draw.between(0.02, 0.15)
    panel = rounded_box((width - 4 * rod, thick, depth), draw.between(0.02, 0.15), "y", (0, seat, rear + 0.5 * depth))
    chair_seat = root.add("chair_seat")
    chair_seat.add("seat_surface", panel)
    if draw.chance(0.4):
        chair_seat.add(
            "seat_frame",
            *(cylinder(rod, depth, "z", (s * (half - 2 * rod), seat - thick, rear + 0.5 * depth), 8) for s in (-1, 1)),
        )
    # Folding turns the seat up against the back and the legs in below it, by proportional angles.
    fold = draw.between(60.0, 85.0)
    closed = draw.pick([0.0, fold, draw.between(0.0, fold)], [6, 1, 2])
    at_seat = (draw.pick([0.0, half]), seat - draw.pick([0.0, thick]), line(seat))
    links = [base, Link("seat", [chair_seat], base, hinge(at_seat, X, -fold, 0.0, rest=-closed))]

    inner = half - draw.between(1.5, 3.0) * rod
    cross = seat * draw.between(0.65, 0.98)
    behind = -foot - draw.between(0.0, 0.15)
    top_z = line(cross) + (line(cross) - behind) / cross * (0.95 * seat - cross)
    legs = [_rod([(s * inner, 0, behind), (s * inner, 0.95 * seat, top_z)], rod) for s in (-1, 1)]
    legs.append(cylinder(rod, 2 * inner, "x", (0, 0.2, behind + (line(cross) - behind) * 0.2 / cross), 10))
    chair_base = root.add("chair_base")
    leg_nodes = chair_base.add("foldable_leg_set", *legs) if draw.chance(0.6) else chair_base.add("leg", *legs)
    between = np.degrees(np.arctan2(line(cross) - behind, cross) + np.arctan2(foot - line(cross), cross))
    sense = draw.sign()
    low, high = sorted((0.0, -sense * between))
    motion = hinge((0, cross, line(cross)), X * sense, low, high, rest=-sense * between * closed / fold)
    links.append(Link("leg", [leg_nodes], base, motion))
    return SynthObject("FoldingChair", root, links)


def _rod(ends: list[tuple[float, float, float]], radius: float) -> Mesh:
    """A rod between points."""
    return sweep(np.array(ends), radius, 8)


def _back_surface(draw: Draw, width: float, seat: float, height: float, slope: float, foot: float) -> list[Mesh]:
    """A panel or slats between the uprights above the seat."""
    tilt = float(np.degrees(np.arctan(slope)))
    low, high = seat + draw.between(0.15, 0.4), height - draw.between(0.0, 0.1)
    count = draw.pick([1, 2, 3, 4])
    cell = (high - low) / count
    tall = cell * (1.0 if count == 1 else draw.between(0.4, 0.8))
    slats = []
    for index in range(count):
        y = low + (index + 0.5) * cell
        slats.append(turn(box((width, tall, 0.03), (0, y, foot + slope * y)), X, tilt, (0, y, foot + slope * y)))
    return slats
