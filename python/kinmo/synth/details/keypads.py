"""Fields of keys on a front (+z), keys at the sides, and printed keys that do not move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, grid_places
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, box, join, move, sheet
from kinmo.synth.synth_object import Link, Node, slider

MIN_KEY_PITCH = 0.035
"""Smallest pitch of the keys of a field, for an object about two units wide."""


def add_keypad(
    draw: Draw,
    above: Node,
    carrier: Link,
    center: tuple[float, float, float],
    size: tuple[float, float],
    name: str,
    *,
    lookalikes: bool = True,
) -> list[Link]:
    """Add rows of keys to a front. Keys that do not move belong to `carrier`.

    Args:
        above: Node that the keys are added below.
        carrier: Link of the front.
        center: Centre [3] of the field.
        size: Width and height of the field.
        name: Name of each key's node.
        lookalikes: Allow printed keys, which are flat and mostly fixed, and fields annotated only in part. If False, every key
            is pressed in by about its own height.

    Returns:
        Links of the moving keys.
    """
    columns, rows = draw.pick([1, 2, 3, 4], [1, 2, 5, 3]), draw.integer(2, 7)
    # Keys are large enough for fingers.
    columns, rows = (max(1, min(count, int(room / MIN_KEY_PITCH))) for count, room in zip((columns, rows), size, strict=True))
    cell = min(size[0] / columns, size[1] / rows)
    width = cell * draw.between(0.45, 0.9)
    height = width * draw.pick([draw.between(0.45, 1.0), draw.between(1.0, 1.6) if width < 0.6 * cell else 1.0], [4, 1])
    printed = lookalikes and draw.chance(0.35)
    depth = draw.between(0.003, 0.02)
    look = draw.pick(["glyph", "plate"])
    moves = _moving_keys(draw, rows, columns, printed=printed) if lookalikes else np.ones((rows, columns), bool)
    travel = draw.between(0.6, 1.0) * depth
    rises = draw.chance(1 / 3)
    links = []
    places = grid_places(columns, rows, max(cell, 0.8 * size[0] / columns) * columns, cell * rows)
    for (x, y), moving in zip(places, moves.ravel(), strict=True):
        at = (center[0] + x, center[1] + y, center[2] + (0.001 if printed else 0.0))
        key = _printed_key(draw, width, height, at, look) if printed else button(draw, width, height, depth, at)
        node = above.add(name, key)
        if moving:
            motion = slider((0, 0, 1), -travel, 0.0) if rises else slider((0, 0, -1), 0.0, travel)
            links.append(Link("button", [node], carrier, motion, leaf_name="button"))
        else:
            carrier.nodes.append(node)
    return links


def _moving_keys(draw: Draw, rows: int, columns: int, *, printed: bool) -> NDArray[np.bool_]:
    """Mask [rows, columns] of the keys that are annotated as moving."""
    moves = np.zeros((rows, columns), bool)
    kind = draw.pick(["all", "none", "rows", "columns"], [1, 12, 0, 0] if printed else [14, 3.5, 3, 1])
    if kind == "all":
        moves[:] = True
    elif kind == "rows":
        first = draw.integer(0, rows - 1)
        moves[first : first + draw.integer(1, rows)] = True
    elif kind == "columns":
        moves[:, draw.integer(0, columns - 1)] = True
    return moves


def _printed_key(draw: Draw, width: float, height: float, at: Point, look: str) -> Mesh:
    """A flat plate, or a sign made of a few strokes."""
    if look == "plate":
        return sheet((width, height), at, "z")
    stroke = 0.18 * width
    upright = [sheet((stroke, height), (s * 0.35 * width, 0, 0), "z") for s in (-1, 1)]
    level = [sheet((0.7 * width, stroke), (0, s * (height - stroke) / 2, 0), "z") for s in (-1, 0, 1)]
    strokes = [piece for piece in upright + level if draw.chance(0.6)] or upright[:1]
    return move(join(*strokes), at)


def keypad(draw: Draw, base: Link, width: float, height: float, front: float, share: float) -> list[Link]:
    """Rows of buttons over the lower `share` of a front of `width` x `height` about the origin, at z = `front`."""
    columns, rows = draw.integer(2, 4), draw.integer(2, 7)
    field = (0.85 * width, share * height)
    size = (field[0] / columns * draw.between(0.55, 0.85), min(field[1] / rows, 0.2) * draw.between(0.5, 0.8))
    depth = draw.between(0.01, 0.04)
    middle = -0.5 * (1 - share) * 0.9 * height
    inwards = draw.chance(0.5)
    links = []
    for x, y in grid_places(columns, rows, *field):
        node = Node("button", pieces=[button(draw, *size, depth, (x, y + middle, front - 0.2 * depth))])
        motion = slider((0, 0, -1), 0.0, 0.6 * depth) if inwards else slider((0, 0, 1), -0.6 * depth, 0.0)
        links.append(Link("button", [node], base, motion))
    return links


def side_keys(draw: Draw, base: Link, width: float, height: float) -> list[Link]:
    """One or two keys on the upper half of one side."""
    links = []
    side = draw.sign()
    for _ in range(draw.integer(1, 2)):
        y = height * draw.between(-0.1, 0.4)
        node = Node("button", pieces=[box((0.03, 0.12, 0.03), (side * 0.5 * width, y, 0))])
        links.append(Link("button", [node], base, slider((-side, 0, 0), 0.0, 0.01)))
    return links
