"""The hinge of a lid, where it can be seen: without one, a hinged lid looks like one that lifts off."""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.model import Point
from kinmo.synth.primitives import box, cylinder, join

SEEN = 0.8
"""Chance that the hinge shows."""


def lid_hinge(draw: Draw, place: Point, length: float, size: float) -> list[Mesh]:
    """A barrel of `length` along x at `place`, with a leaf of it towards +z, or a strap; at times nothing.

    Args:
        draw: what chooses.
        place: a point of the joint's line.
        length: how long the barrel may be.
        size: a length that says how thick things of this kind are.
    """
    if not draw.chance(SEEN):
        return []
    length *= draw.between(0.3, 0.9)
    x, y, z = (float(value) for value in place)
    if draw.chance(0.3):
        return [box((length, draw.between(2.0, 4.0) * size, draw.between(0.5, 1.5) * size), (x, y, z))]
    barrel, leaf = cylinder(draw.between(0.5, 1.0) * size, length, "x", (x, y, z), 12), 3.0 * size
    return [join(barrel, box((0.8 * length, 0.4 * size, leaf), (x, y, z + 0.5 * leaf)))]
