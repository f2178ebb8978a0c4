"""Carrying handles: bows, brackets, straps and rings that turn about the line through their ends, or are fixed.

Built on the wall z = 0, which faces +z, with both ends on the x axis.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, box, cylinder, rounded_path, sweep, sweep_outline, transform
from kinmo.synth.synth_object import Link, Node, hinge

STRAP_OUTLINE = np.array([[0.5, 0.12], [-0.5, 0.12], [-0.5, -0.12], [0.5, -0.12]])
"""Outline [4, 2] of a flat band, to sweep."""
SHEET_RING_OUTLINE = np.array([[0.2, 0.5], [-0.2, 0.5], [-0.2, -0.5], [0.2, -0.5]])
"""Outline [4, 2] of a ring cut from sheet metal, to sweep. The ring lies flat on its wall."""


def carrying_handle(draw: Draw, half: float, reach: float, rod: float, *, hangs: bool = False) -> list[Mesh]:
    """Meshes of a handle.

    Args:
        half: Half the distance between the ends, at x = -half and x = half.
        reach: Height above the wall.
        rod: Radius of the rod.
        hangs: The handle may be a ring.

    Returns:
        The pieces.
    """
    if hangs and draw.chance(0.4):
        return _ring(draw, half, half * draw.between(0.5, 1.6), rod)
    kind = draw.pick(["bracket", "arc", "trapezoid", "strap", "grip"], [4, 2, 2, 2, 2])
    if kind == "arc":
        angle = np.linspace(0.0, np.pi, 14)
        path = np.stack([-half * np.cos(angle), np.zeros(14), reach * np.sin(angle)], axis=1)
    else:
        top = half * (draw.between(0.5, 0.9) if kind == "trapezoid" else 1.0)
        path = rounded_path(np.array([(-half, 0, 0), (-top, 0, reach), (top, 0, reach), (half, 0, 0)]), 0.6 * reach)
    if kind == "strap":
        return [sweep_outline(path, STRAP_OUTLINE, rod * draw.between(2.0, 5.0))]
    pieces = [sweep(path, rod, draw.pick([6, 8, 10]))]
    if kind == "grip":
        pieces.append(cylinder(1.8 * rod, 1.3 * half, "x", (0, 0, reach), 12))
    return pieces


def _ring(draw: Draw, half: float, reach: float, rod: float) -> list[Mesh]:
    """A closed ring, round or cut from sheet, wider away from its axis, sometimes with a clip there."""
    narrow = half * draw.between(0.4, 0.9)
    path = rounded_path(np.array([(-narrow, 0, 0), (-half, 0, reach), (half, 0, reach), (narrow, 0, 0)]), 0.4 * half)
    if draw.chance(0.5):
        thick, wide = 2.0 * rod * np.ptp(SHEET_RING_OUTLINE, axis=0)
        pieces = [sweep_outline(path, SHEET_RING_OUTLINE, 2.0 * rod), box((2 * narrow, thick, wide))]
    else:
        pieces = [sweep(path, rod, draw.pick([6, 8, 10])), cylinder(rod, 2 * narrow, "x", segments=10)]
    if draw.chance(0.5):
        pieces.append(box((1.6 * narrow, draw.between(0.5, 2.0) * rod, draw.between(0.3, 0.8) * reach)))
    return pieces


def add_carrying_handle(
    draw: Draw,
    above: Node,
    carrier: Link,
    place: NDArray[np.float64],
    half: float,
    *,
    hangs: bool = False,
    movable: bool = True,
) -> list[Link]:
    """Add a carrying handle.

    Args:
        above: Node that the handle is added below.
        carrier: Link of the wall.
        place: Rigid transform [4, 4] from the handle's frame to its wall.
        half: Half the distance between the ends.
        hangs: Show the handle against the wall towards local -y, as at the ends of a chest.
        movable: Give the handle a hinge. A fixed handle belongs to `carrier`.

    Returns:
        The handle's link, or nothing for a fixed handle.
    """
    rod, reach = half * draw.between(0.05, 0.14), half * draw.between(0.3, 1.1)
    deep = draw.between(0.0, 1.2) * rod
    pieces = [transform(piece, place) for piece in carrying_handle(draw, half, reach, rod, hangs=hangs)]
    node = above.add(draw.pick(["handle", "grip"], [9, 1]), *pieces)
    if draw.chance(0.4):
        ends = [box((3 * rod, 4 * rod, 2 * rod), (s * half, 0, 0.5 * rod)) for s in (-1, 1)]
        carrier.nodes[0].pieces += [transform(piece, place) for piece in ends]
    if hangs:
        # At 0 degrees the handle stands out from the wall, at 90 degrees about +x it points to -y.
        limits = draw.pick([(-90.0, 90.0), (0.0, 90.0), (-60.0, 90.0)])
        rest = 90.0 - draw.pick([0.0, draw.between(0.0, 60.0)], [3, 1])
    else:
        limits = draw.pick([(-90.0, 90.0), (0.0, 90.0), (-90.0, 0.0), (-70.0, 70.0)], [4, 1, 1, 2])
        rest = draw.pick([0.0, draw.between(*limits), limits[0], limits[1]], [4, 2, 1, 1])
    motion = hinge((0, 0, deep), X, *limits, rest=rest).moved_by(place)
    if movable:
        return [Link("handle", [node], carrier, motion, leaf_name="handle")]
    node.pieces = [transform(piece, motion.at(rest)) for piece in node.pieces]
    carrier.nodes.append(node)
    return []
