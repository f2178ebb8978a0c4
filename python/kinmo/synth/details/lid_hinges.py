"""Visible hinges of lids. Without one, a hinged lid looks like a lid that lifts off."""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, cylinder, join
from kinmo.synth.synth_object import Point

VISIBLE_CHANCE = 0.8
"""Chance that a hinge is visible."""


def lid_hinge(draw: Draw, place: Point, length: float, size: float) -> list[Mesh]:
    """Meshes of a hinge: a barrel along x with a leaf towards +z, a strap, or nothing.

    Args:
        place: A point [3] of the joint's axis.
        length: Largest length of the barrel.
        size: Typical thickness of the parts around it.

    Returns:
        The pieces; empty for a hidden hinge.
    """
    if not draw.chance(VISIBLE_CHANCE):
        return []
    length *= draw.between(0.3, 0.9)
    x, y, z = (float(value) for value in place)
    if draw.chance(0.3):
        return [box((length, draw.between(2.0, 4.0) * size, draw.between(0.5, 1.5) * size), (x, y, z))]
    barrel, leaf = cylinder(draw.between(0.5, 1.0) * size, length, "x", (x, y, z), 12), 3.0 * size
    return [join(barrel, box((0.8 * length, 0.4 * size, leaf), (x, y, z + 0.5 * leaf)))]
