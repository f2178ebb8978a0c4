"""Closures of an opening in a housing's front: doors, flaps, drawers, shelves and panes, made to measure.

Each builder takes a `Draw` and the opening's width, height and depth. It gives a `Mechanism` in the opening's frame: the origin
is the centre of the opening in the plane of the front, and the outside is towards +z.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.primitives import X, Y, Z, box, cylinder, extrude, facing, move, rotation_about, rounded_box, transform
from kinmo.synth.synth_object import Motion, hinge, slider, spinner

FrontBuilder: TypeAlias = Callable[[Draw, float, float, float], Mechanism]
"""Function that builds a closure for an opening of a given width, height and depth."""


def door(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Door with its hinge along the left or right edge; two leaves if the opening is wide."""
    if wide > high and draw.chance(0.5):
        draws = draw.identical(2)
        leaves = [_leaf(own, 0.5 * wide, high, side) for own, side in zip(draws, (-1.0, 1.0), strict=True)]
        places = [facing(Z, Y, X * side * 0.25 * wide) for side in (-1.0, 1.0)]
        return Mechanism([_carried(leaf, place) for leaf, place in zip(leaves, places, strict=True)])
    return Mechanism([_leaf(draw, wide, high, draw.sign())])


def flap(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Flap with its hinge along the lower or upper edge."""
    leaf = _leaf(draw, high, wide, draw.pick([-1.0, -1.0, 1.0]))
    return Mechanism([_carried(leaf, rotation_about(Z, 90.0))])


def folding_door(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Door of two leaves: one hinged at a side, the other on the first, both opening outwards."""
    side, share, thick = draw.sign(), draw.between(0.4, 0.6), draw.ratio(0.01, 0.06) * wide
    spans = share * wide, (1 - share) * wide
    centers = side * (0.5 * wide - 0.5 * spans[0]), -side * (0.5 * wide - 0.5 * spans[1])
    near, far = ([box((0.98 * span, 0.97 * high, thick), (x, 0, 0.5 * thick))] for span, x in zip(spans, centers, strict=True))
    if draw.chance(0.7):
        at = (-side * 0.42 * wide, draw.between(-0.2, 0.2) * high, thick)
        far += pull(draw, 0.25 * high, at, vertical=True, thickness=0.04 * wide, reach=0.08 * wide)
    opens, name = draw.between(80.0, 120.0), draw.pick(["door", "leaf", "panel"])
    first = MovingPart(name, near, hinge((side * 0.5 * wide, 0, 0), Y * side, 0.0, opens))
    seam = (side * (0.5 * wide - spans[0]), 0, thick)
    folds = draw.between(90.0, 178.0)
    rest = draw.pick([0.0, draw.between(0.1, 0.9) * folds], [4, 1])
    return Mechanism([first, MovingPart(name, far, hinge(seam, Y * side, 0.0, folds, rest=rest), first)])


def tilting_bin(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Front with a wedge-shaped bin behind it that tips out about its lower edge."""
    thick, reach, tall = draw.ratio(0.02, 0.08) * high, draw.between(0.3, 0.7) * min(deep, high), draw.between(0.4, 0.7) * high
    low = -0.47 * high
    pieces = [box((0.98 * wide, 0.96 * high, thick), (0, 0, 0.5 * thick))]
    wedge = np.array([(low, 0.0), (low, -0.15 * reach), (low + tall, -reach), (low + tall, 0.0)])
    if draw.chance(0.5):
        pieces.append(extrude(wedge, 0.9 * wide, "x"))
    else:
        pieces += [extrude(wedge, 0.02 * wide, "x", (s * 0.45 * wide, 0, 0)) for s in (-1, 1)]
    if draw.chance(0.7):
        pieces += pull(draw, 0.4 * min(wide, 2 * high), (0, 0.35 * high, thick), vertical=False)
    opens = draw.between(15.0, 50.0)
    motion = hinge((0, low, draw.pick([0.0, thick])), X, 0.0, opens, rest=draw.pick([0.0, opens], [4, 1]))
    return Mechanism([MovingPart(draw.pick(["drawer", "bin", "door", "lid"]), pieces, motion)])


def _leaf(draw: Draw, wide: float, high: float, side: float) -> MovingPart:
    """A leaf with a vertical hinge at `side` (-1 left, 1 right)."""
    thick = draw.between(0.03, 0.2) * min(wide, high)
    inset = draw.pick([0.0, draw.between(0.3, 1.0) * thick])
    middle = 0.5 * thick - inset
    free, margin = -side * 0.5 * wide, draw.between(0.0, 0.02) * wide
    pieces: list[Mesh]
    kind = draw.pick(["slab", "rounded", "frame"], [4, 1, 3])
    size = (wide - 2 * margin, high - 2 * margin, thick)
    if kind == "slab":
        pieces = [box(size, (0, 0, middle))]
    elif kind == "rounded":
        pieces = [rounded_box(size, 0.2 * min(wide, high), "z", (0, 0, middle))]
    else:
        rim = draw.between(0.08, 0.2) * min(wide, high)
        pieces = [box((rim, size[1], thick), (s * 0.5 * (size[0] - rim), 0, middle)) for s in (-1, 1)]
        pieces += [box((size[0], rim, thick), (0, s * 0.5 * (size[1] - rim), middle)) for s in (-1, 1)]
        if draw.chance(0.7):
            pieces.append(box((size[0] - 1.8 * rim, size[1] - 1.8 * rim, 0.3 * thick), (0, 0, middle)))
    if draw.chance(0.75):
        upright = draw.chance(0.8)
        length = draw.between(0.15, 0.8) * (high if upright else 0.4 * wide)
        at = (0.85 * free if upright else 0.6 * free, draw.between(-0.2, 0.2) * high, middle + 0.5 * thick)
        pieces += pull(draw, length, at, vertical=upright, thickness=0.05 * min(wide, high), reach=0.12 * min(wide, high))
    edge = side * (0.5 * wide - margin - draw.pick([0.0, 0.0, draw.between(0.0, 0.06)]) * wide)
    depth = middle + draw.pick([-0.5, 0.0, 0.5]) * thick
    if draw.chance(0.3):
        pieces += [cylinder(0.2 * thick, 0.1 * high, "y", (edge, s * 0.35 * high, depth), 10) for s in (-1, 1)]
    opening = draw.between(60.0, 170.0)
    rest = draw.pick([0.0, draw.between(0.1, 1.0) * opening], [3, 1])
    motion = hinge((edge, 0, depth), Y * side, 0.0, opening, rest=rest)
    return MovingPart(draw.pick(["door", "door", "lid", "cover", "leaf", "panel", "frame"]), pieces, motion)


def drawer_front(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Drawer: a front with a tray or a block behind it, sliding outwards."""
    thick, length = draw.between(0.02, 0.06) * wide, draw.between(0.5, 0.95) * deep
    inner = (0.92 * wide, draw.between(0.5, 0.9) * high, length)
    pieces = [box((0.98 * wide, 0.96 * high, thick), (0, 0, draw.pick([0.5, -0.5]) * thick))]
    if draw.chance(0.5):
        wall = 0.03 * wide
        pieces.append(box((inner[0], wall, length), (0, -0.45 * high, -0.5 * length)))
        pieces += [box((wall, inner[1], length), (s * 0.45 * wide, 0, -0.5 * length)) for s in (-1, 1)]
        pieces.append(box((inner[0], inner[1], wall), (0, 0, -length)))
    else:
        pieces.append(box(inner, (0, 0, -0.5 * length)))
    if draw.chance(0.75):
        size = 0.5 * min(wide, 2 * high)
        pieces += pull(draw, size, (0, draw.between(-0.1, 0.3) * high, 0.5 * thick), vertical=draw.chance(0.1))
    return Mechanism([MovingPart(draw.pick(["drawer", "tray", "box", "front"]), pieces, _out(draw, length))])


def shelf(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Plate or grid behind the front that slides outwards."""
    length = draw.between(0.6, 0.95) * deep
    thick, level = draw.between(0.02, 0.06) * high, draw.between(-0.3, 0.3) * high
    middle = (0, level, -0.5 * deep)
    if draw.chance(0.5):
        pieces = [box((0.94 * wide, thick, length), middle)]
    else:
        count = draw.integer(4, 9)
        rods = np.linspace(-0.45, 0.45, count) * wide
        pieces = [box((0.02 * wide, thick, length), (x, level, -0.5 * deep)) for x in rods]
        pieces += [box((0.94 * wide, thick, 0.03 * length), (0, level, -0.5 * deep + s * 0.48 * length)) for s in (-1, 1)]
    if draw.chance(0.3):
        pieces.append(box((0.94 * wide, 0.12 * high, thick), (0, level, -0.5 * (deep - length))))
    return Mechanism([MovingPart(draw.pick(["shelf", "tray", "rack", "plate"]), pieces, _out(draw, length))])


def turntable(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Disc behind the front that turns on a floor."""
    radius, thick = draw.between(0.3, 0.47) * min(wide, deep), draw.between(0.02, 0.06) * high
    level, middle = -0.5 * high + draw.pick([0.05, draw.between(0.05, 0.5)]) * high, -0.5 * deep
    pieces = [cylinder(radius, thick, "y", (0, level, middle), draw.pick([16, 24, 32]))]
    if draw.chance(0.4):
        pieces.append(cylinder(draw.between(0.1, 0.3) * radius, 1.5 * thick, "y", (0, level - thick, middle), 12))
    floor = [box((0.98 * wide, 0.02, 0.9 * deep), (0, level - 1.5 * thick - 0.01, middle))]
    motion = spinner((0, level, middle), Y)
    return Mechanism([MovingPart(draw.pick(["tray", "plate", "table", "disc"]), pieces, motion)], draw.pick([floor, []]))


def sliding_pane(draw: Draw, wide: float, high: float, deep: float) -> Mechanism:
    """Pane in front of or behind another pane, sliding sideways or up."""
    upright = draw.chance(0.3)
    thick, share = 0.03 * min(wide, high), draw.between(0.45, 0.6)
    size = (0.98 * wide, share * high, thick) if upright else (share * wide, 0.98 * high, thick)
    path, room = (Y, high) if upright else (X, wide)
    start = 0.5 * (room - share * room) * draw.sign()
    pieces = [box(size, path * start)]
    fixed = [box(size, -path * start - Z * 1.5 * thick)] if draw.chance(0.7) else []
    if draw.chance(0.5):
        pieces += [move(piece, path * start) for piece in pull(draw, 0.2 * min(wide, high), (0, 0, 0.5 * thick), vertical=True)]
    travel = draw.between(0.5, 1.0) * (room - share * room)
    motion = slider(-path * np.sign(start), 0.0, travel)
    return Mechanism([MovingPart(draw.pick(["pane", "window", "door", "shutter"]), pieces, motion)], fixed)


def _out(draw: Draw, length: float) -> Motion:
    """Slider to the front for a part of a given length."""
    travel = draw.between(0.4, 0.95) * length
    return slider(Z, 0.0, travel, rest=draw.pick([0.0, draw.between(0.0, 0.9) * travel], [3, 1]))


def _carried(part: MovingPart, matrix: NDArray[np.float64]) -> MovingPart:
    """The part and its joint under a rigid transform [4, 4]."""
    return MovingPart(part.name, [transform(piece, matrix) for piece in part.pieces], part.motion.moved_by(matrix))


FRONTS = (
    *(door, door, door, door, flap, flap, drawer_front, drawer_front, drawer_front),
    *(shelf, sliding_pane, folding_door, tilting_bin),
)
"""All closures. Frequent ones are listed more than once."""
INTERIORS = (turntable, shelf)
"""Moving parts that may be behind a door."""
