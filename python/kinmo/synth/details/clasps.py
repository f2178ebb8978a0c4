"""Clasps between a lid and a body: latches, bails, turn buttons, sliding tabs, push buttons and number wheels.

Built on the wall z = 0, which faces +z. The seam is the line y = 0, with the body below it and the lid above it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, join, move, rounded_box, rounded_path, sweep, transform
from kinmo.synth.synth_object import Link, Motion, Node, hinge, slider, spinner

CLASP_WEIGHTS = {"latch": 14, "bail": 3, "turn": 1.5, "slide": 1.5, "push": 4, "wheels": 0.5, "plate": 1.5}
"""Relative frequency of each kind of clasp."""


@dataclass(frozen=True)
class Clasp:
    """Parts of one clasp.

    Attributes:
        name: Name of its nodes and links.
        moving: Pieces and joint of each moving part.
        fixed: Pieces that do not move.
        on_lid: True if it is mounted on the lid, False if on the body.
    """

    name: str
    moving: list[tuple[list[Mesh], Motion]]
    fixed: list[Mesh]
    on_lid: bool


def add_clasp(draw: Draw, above: Node, body: Link, lid: Link, place: NDArray[np.float64], size: float) -> list[Link]:
    """Add a clasp to a body or its lid.

    Args:
        above: Node that the clasp is added below.
        body: Link of the body.
        lid: Link of the lid.
        place: Rigid transform [4, 4] from the clasp's frame to the object.
        size: Height of the clasp.

    Returns:
        Links of the moving parts.
    """
    clasp = random_clasp(draw, size)
    carrier = lid if clasp.on_lid else body
    if clasp.fixed:
        carrier.nodes[0].pieces += [transform(piece, place) for piece in clasp.fixed]
    links = []
    for pieces, motion in clasp.moving:
        node = above.add(clasp.name, *(transform(piece, place) for piece in pieces))
        links.append(Link(clasp.name, [node], carrier, motion.moved_by(place), leaf_name=clasp.name))
    return links


def random_clasp(draw: Draw, size: float) -> Clasp:
    """Clasp of a random kind, about `size` high, in its own frame."""
    kind = draw.pick(list(CLASP_WEIGHTS), list(CLASP_WEIGHTS.values()))
    build = {"latch": _latch, "bail": _bail, "turn": _turn_button, "slide": _sliding_tab, "push": _push_button}
    if kind == "plate":
        return Clasp("lock", [], [box((0.8 * size, size, 0.15 * size), (0, -0.3 * size, 0.075 * size))], draw.chance(0.5))
    return _wheels(draw, size) if kind == "wheels" else build[kind](draw, size)


def _latch(draw: Draw, size: float) -> Clasp:
    """Plate or hook across the seam that swings off the wall about its upper, lower or side edge."""
    wide, thick = size * draw.between(0.25, 1.2), size * draw.between(0.06, 0.6)
    on_lid, edge = draw.chance(0.5), draw.pick(["horizontal", "vertical"], [12, 1])
    up = 1.0 if on_lid else -1.0
    share = draw.between(0.0, 0.45)
    middle = up * (0.5 - share) * size
    if draw.chance(0.3):
        plate = rounded_box((wide, size, thick), 0.3 * wide, "z", (0, middle, 0.5 * thick))
    else:
        plate = box((wide, size, thick), (0, middle, 0.5 * thick))
    pieces = [plate]
    if draw.chance(0.35):
        lip = box((wide, 0.15 * size, 1.4 * thick), (0, middle - up * 0.45 * size, 0.7 * thick))
        pieces.append(lip)
    if draw.chance(0.3):
        pieces.append(cylinder(0.6 * thick, wide, "x", (0, middle + up * 0.5 * size, 0.5 * thick), 10))
    opens = draw.pick([25.0, 60.0, 90.0, 120.0, 180.0], [2, 1, 3, 2, 3])
    # Turns by more than 90 degrees need a pin that stands off the wall.
    deep = thick * draw.pick([0.5 if opens > 90.0 else 0.0, 0.5, draw.between(0.5, 1.0)])
    rest = draw.between(0.2, 0.9) * opens if draw.chance(0.12) else 0.0
    if edge == "horizontal":
        axis = (0.0, middle + up * size * draw.between(0.4, 0.5), deep)
        motion = hinge(axis, (-up, 0, 0), 0.0, opens, rest=rest)
    else:
        side = draw.sign()
        motion = hinge((side * 0.5 * wide, 0, deep), (0, side, 0), 0.0, opens, rest=rest)
    # A plate of the same outline behind the latch, which touches it all over.
    back = [box((wide, size, 0.1 * thick), (0, middle, 0.0))] if draw.chance(0.3) else []
    return Clasp(draw.pick(["lock", "buckle", "latch"], [4, 2, 1]), [(pieces, motion)], back, on_lid)


def _bail(draw: Draw, size: float) -> Clasp:
    """Lever on the body that pulls a wire loop over a hook on the lid. Both turn together or separately."""
    wide, thick, low = size * draw.between(0.4, 0.9), size * draw.between(0.08, 0.2), -size * draw.between(0.5, 0.8)
    lever = box((0.6 * wide, 0.7 * size, thick), (0, low + 0.35 * size, 1.2 * thick))
    path = np.array([(-0.5, low, thick), (-0.5, 0.3 * size, thick), (0.5, 0.3 * size, thick), (0.5, low, thick)]) * (wide, 1, 1)
    loop = sweep(rounded_path(path, 0.2 * wide), 0.35 * thick, 6)
    hook = box((0.4 * wide, 0.15 * size, 1.5 * thick), (0, 0.25 * size, 0.75 * thick))
    base = box((wide, 0.3 * size, 0.6 * thick), (0, low, 0.3 * thick))
    motion = hinge((0, low, thick), X, 0.0, draw.pick([90.0, 150.0]))
    swing = hinge((0, low + 0.1 * size, thick), X, 0.0, draw.pick([45.0, 90.0]))
    moving = [([lever, loop], motion)] if draw.chance(0.5) else [([lever], motion), ([loop], swing)]
    return Clasp("lock", moving, [base, hook], on_lid=False)


def _turn_button(draw: Draw, size: float) -> Clasp:
    """Key plate, wing or round lock that turns about the wall's normal."""
    thick = size * draw.between(0.1, 0.4)
    if draw.chance(0.5):
        hub, wing = cylinder(0.3 * size, thick, "z", (0, 0, 0.5 * thick), 20), (0.1 * size, 0.5 * size, 0.3 * thick)
    else:
        hub, wing = cylinder(0.2 * size, thick, "z", (0, 0, 0.5 * thick), 16), (0.25 * size, size, 0.5 * thick)
    pieces = [hub, box(wing, (0, 0, thick))]
    if draw.chance(0.5):
        pieces = [join(*pieces)]
    motion = spinner((0, 0, 0), Z) if draw.chance(0.3) else hinge((0, 0, 0), Z, *draw.pick([(0.0, 90.0), (-90.0, 90.0)]))
    plate = [box((0.9 * size, 1.2 * size, 0.1 * thick), (0, 0, 0.05 * thick))] if draw.chance(0.5) else []
    return Clasp("lock", [(pieces, motion)], plate, draw.chance(0.5))


def _sliding_tab(draw: Draw, size: float) -> Clasp:
    """Tab that slides along the wall, horizontally or vertically, with or without a plate."""
    wide, tall, thick = size * draw.between(0.3, 0.8), size * draw.between(0.2, 0.5), size * draw.between(0.1, 0.3)
    along_x = draw.chance(0.7)
    reach = draw.between(0.3, 1.0) * (wide if along_x else tall)
    tab = box((wide, tall, thick), (0, -0.3 * size, 0.5 * thick))
    direction = draw.sign() * (X if along_x else Y)
    room = (wide + 2 * reach, 1.3 * tall) if along_x else (1.3 * wide, tall + 2 * reach)
    plate = [box((*room, 0.2 * thick), (0, -0.3 * size, 0.1 * thick))] if draw.chance(0.6) else []
    return Clasp("lock", [([tab], slider(direction, 0.0, reach))], plate, on_lid=False)


def _push_button(draw: Draw, size: float) -> Clasp:
    """Button that is pressed into the wall, with or without a plate."""
    proud, wide = size * draw.between(0.05, 0.25), size * draw.between(0.3, 0.7)
    if draw.chance(0.5):
        cap = cylinder(0.5 * wide, proud, "z", (0, -0.3 * size, 0.5 * proud), 18)
    else:
        cap = box((wide, wide * draw.between(0.5, 1.5), proud), (0, -0.3 * size, 0.5 * proud))
    plate = [box((1.6 * wide, size, 0.3 * proud), (0, -0.3 * size, 0.15 * proud))] if draw.chance(0.3) else []
    motion = slider(-Z, 0.0, draw.between(0.4, 1.0) * proud)
    return Clasp(draw.pick(["lock", "button"], [3, 1]), [([cap], motion)], plate, draw.chance(0.5))


def _wheels(draw: Draw, size: float) -> Clasp:
    """Three or four number wheels of a combination lock, half sunk in a plate."""
    count, radius = draw.integer(3, 4), size * draw.between(0.2, 0.35)
    thick = radius * draw.between(0.3, 0.8)
    moving = []
    for index in range(count):
        x = (index - 0.5 * (count - 1)) * 1.4 * thick
        at = (x, -0.3 * size, -0.3 * radius)
        moving.append(([cylinder(radius, thick, "x", at, 20)], spinner(at, X)))
    plate = box((1.6 * count * thick, 1.2 * radius, 0.1 * radius))
    return Clasp("lock", moving, [move(plate, (0, -0.3 * size - 1.2 * radius, 0))], draw.chance(0.5))
