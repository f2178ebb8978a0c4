"""Small parts that a front (+z) carries and that never move by themselves: studs, hinges, lock plates, corners and badges."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.handles import knob_handle
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, Z, box, cylinder, dome, join, move, rounded_box, sheet, turn
from kinmo.synth.synth_object import Node

FITTING_NAMES = {
    "studs": ("other_leaf", "stud", "screw"),
    "corners": ("other_leaf", "corner", "frame"),
    "badge": ("other_leaf", "label", "logo"),
    "lock plate": ("other_leaf", "lock", "keyhole"),
    "keyhole": ("other_leaf", "keyhole", "lock"),
    "knob": ("handle", "other_leaf", "knob"),
    "barrels": ("hinge", "other_leaf"),
    "straps": ("hinge", "other_leaf"),
}
"""Names of the leaves of each kind of fitting."""
FITTED_SHARE = 0.25
"""Share of fronts that have fittings."""


def add_fittings(draw: Draw, above: Node, low: Point, high: Point, face: float, side: str = "") -> list[Node]:
    """Add one or two kinds of fittings to some fronts. The caller gives them to the front's link unless `above` is its node.

    Args:
        above: Node that the leaves are added below.
        low: Lower left corner [2] of the front.
        high: Upper right corner [2] of the front.
        face: Position of its surface along z.
        side: Edge of its hinge: "left", "right", "top", "bottom", or "" for a front that slides, which gets no hinges.

    Returns:
        The new leaves.
    """
    if not draw.chance(FITTED_SHARE):
        return []
    nodes = []
    for _ in range(draw.pick([1, 2], [3, 1])):
        kinds = [kind for kind in FITTING_NAMES if side or kind not in ("barrels", "straps")]
        kind, loose = draw.pick(kinds), draw.chance(0.5)
        width, height = high[0] - low[0], high[1] - low[1]
        pieces = _fitting(draw, kind, width, height, side)
        pieces = [move(piece, (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), face)) for piece in pieces]
        name = draw.pick(FITTING_NAMES[kind])
        nodes += [above.add(name, piece) for piece in pieces] if loose else [above.add(name, *pieces)]
    return nodes


def _fitting(draw: Draw, kind: str, width: float, height: float, side: str) -> list[Mesh]:
    """Meshes of the fittings of one kind on a front of `width` x `height` about the origin."""
    small = min(width, height)
    size = small * draw.ratio(0.02, 0.09)
    if kind == "studs":
        return [move(stud, (x, y, 0)) for stud in [_stud(draw, size)] for x, y in _stud_places(draw, width, height, 1.5 * size)]
    if kind == "corners":
        plate, thin = 2.0 * size, 0.15 * size
        arms = [box((plate, 0.5 * plate, thin), (0, 0.25 * plate, 0)), box((0.5 * plate, plate, thin), (0.25 * plate, 0, 0))]
        corner = draw.pick([[join(*arms)], [box((plate, plate, thin))], [sheet((plate, plate), (0, 0, 0.1 * thin), "z")]])
        places = [(1, 1, 0.0), (-1, 1, 90.0), (-1, -1, 180.0), (1, -1, 270.0)]
        at = [(x * (width - plate) / 2, y * (height - plate) / 2, 0.4 * thin) for x, y, _ in places]
        return [move(turn(piece, Z, place[2]), foot) for place, foot in zip(places, at, strict=True) for piece in corner]
    x, y = draw.between(-0.35, 0.35) * width, draw.between(-0.4, 0.4) * height
    if kind == "badge":
        wide, high, thin = small * draw.ratio(0.08, 0.4), small * draw.ratio(0.04, 0.15), 0.1 * size
        solid = (wide, high, thin)
        badge = draw.pick([box(solid), rounded_box(solid, 0.5 * high, "z"), sheet((wide, high), axis="z")])
        return [move(badge, (draw.pick([0.0, x]), y, 0.5 * thin))]
    if kind == "knob":
        # A second pull, or a pair of them.
        knob = knob_handle(draw, size, size * draw.between(0.8, 2.5))
        return [move(piece, (s * abs(x), y, 0)) for s in draw.pick([(1,), (-1, 1)]) for piece in knob]
    if kind in ("lock plate", "keyhole"):
        tall, thin = 1.5 * size, 0.2 * size
        slot = [cylinder(0.25 * size, 1.2 * thin, "z", (0, 0.3 * size, 0.6 * thin), 10)]
        slot.append(box((0.2 * size, 0.8 * size, 1.2 * thin), (0, -0.1 * size, 0.6 * thin)))
        round_plate = cylinder(size, thin, "z", (0, 0, 0.5 * thin), 16)
        back = draw.pick([round_plate, box((1.2 * size, 2 * tall, thin), (0, 0, 0.5 * thin))])
        pieces = slot if kind == "keyhole" else [back, *(slot if draw.chance(0.6) else [])]
        return [move(piece, (x, y, 0)) for piece in pieces]
    return _hinges(draw, kind, width, height, size, side)


def _hinges(draw: Draw, kind: str, width: float, height: float, size: float, side: str) -> list[Mesh]:
    """Two or three barrels or straps beside the edge with the hinge."""
    out = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "bottom": (0.0, -1.0), "top": (0.0, 1.0)}[side]
    upright = out[0] != 0.0
    long, across = (height, width) if upright else (width, height)
    places = np.linspace(-0.38, 0.38, draw.pick([2, 3])) * long
    if kind == "barrels":
        tall, radius = long * draw.ratio(0.04, 0.12), 0.25 * size
        barrel = cylinder(radius, tall, "y" if upright else "x", (0, 0, 0), 10)
        leaf = box((3 * radius, tall, 0.3 * radius) if upright else (tall, 3 * radius, 0.3 * radius))
        pieces, inset = [join(barrel, leaf)] if draw.chance(0.5) else [barrel], radius
    else:
        reach, tall = across * draw.between(0.2, 0.7), long * draw.ratio(0.02, 0.06)
        strap = box((reach, tall, 0.1 * size) if upright else (tall, reach, 0.1 * size), (0, 0, 0.05 * size))
        pieces, inset = [strap], 0.5 * reach
    edge = 0.5 * across - inset
    at = [(out[0] * edge, place, 0) if upright else (place, out[1] * edge, 0) for place in places]
    return [move(piece, foot) for foot in at for piece in pieces]


def _stud(draw: Draw, size: float) -> Mesh:
    """The head of a nail or screw, or a small block or pyramid."""
    kind = draw.pick(["dome", "disc", "block", "pyramid"])
    if kind == "dome":
        return dome((0.5 * size, draw.between(0.15, 0.5) * size, 0.5 * size), axis="z", segments=12)
    tall = draw.between(0.1, 0.5) * size
    if kind == "disc":
        return cylinder(0.5 * size, tall, "z", (0, 0, 0.5 * tall), 12)
    block = box((size, size, tall), (0, 0, 0.5 * tall))
    if kind == "pyramid":
        block.vertices[block.vertices[:, 2] > 0.5 * tall] *= (0.05, 0.05, 1.0)
    return block


def _stud_places(draw: Draw, width: float, height: float, inset: float) -> list[tuple[float, float]]:
    """Places (x, y) of studs: at the corners, in a row, or all along the edges."""
    x, y = 0.5 * width - inset, 0.5 * height - inset
    form = draw.pick(["corners", "row", "edges"], [3, 2, 1])
    if form == "row":
        level = draw.pick([-1.0, 0.0, 1.0]) * y
        return [(place, level) for place in np.linspace(-x, x, draw.integer(2, 9))]
    if form == "corners":
        return [(i * x, j * y) for i in (-1, 1) for j in (-1, 1)]
    across, along = draw.integer(3, 8), draw.integer(3, 8)
    rows = [(place, s * y) for place in np.linspace(-x, x, across) for s in (-1, 1)]
    return rows + [(s * x, place) for place in np.linspace(-y, y, along)[1:-1] for s in (-1, 1)]
