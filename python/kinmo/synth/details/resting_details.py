"""Details that never move by themselves: loose keys of a keyboard, sockets, grilles, stickers, lamps, screws and feet.

They look like parts that move elsewhere, such as buttons. All are built about the origin of a front that faces +z.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import CAP_LOOKS, KEY_FORMS, grid_places, key_cap, key_parts
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    Point,
    X,
    Y,
    Z,
    box,
    cylinder,
    dome,
    facing,
    join,
    move,
    sheet,
    transform,
)
from kinmo.synth.synth_object import Link, Node

DETAIL_NAMES = {
    "port": ("other_leaf", "port", "usb_port"),
    "grille": ("other_leaf", "vent", "speaker"),
    "sticker": ("other_leaf", "label", "logo"),
    "lamp": ("other_leaf", "light", "button"),
    "screw": ("other_leaf", "screw"),
    "foot": ("other_leaf", "foot"),
    "key": ("other_leaf", "button", "key"),
}
"""Names of the leaves of each kind of detail."""


def key_caps(draw: Draw, width: float, height: float, tall: float) -> list[list[Mesh]]:
    """Rows of loose keys on `width` x `height`, at most `tall`, with wide keys at the ends of rows.

    Keys have any of `CAP_LOOKS` and `KEY_FORMS`. A number pad may stand beside the rows.

    Returns:
        The pieces of each key.
    """
    rows, columns = draw.integer(4, 7), draw.integer(9, 15)
    pad = draw.pick([0, 3, 4], [5, 1, 1])
    step = width / (columns + (pad + 0.4 if pad else 0))
    tops = np.ones(rows)
    tops[0] = draw.pick([1.0, draw.between(0.45, 0.9)])
    tops *= height / tops.sum()
    gap = draw.between(0.03, 0.35) * min(step, float(tops.min()))
    look = draw.pick(CAP_LOOKS, [5, 4, 2, 0.7, 2, 1.5])
    form = draw.pick(KEY_FORMS, [5, 1, 1, 1.5])
    thick, taper = tall * draw.between(0.3, 1.0), draw.between(0.6, 0.95)
    keys, y = [], height / 2
    for row, high in enumerate(tops):
        shares = _last_row(draw, columns) if row == rows - 1 else _row(draw, columns)
        ends = -width / 2 + step * np.cumsum([0.0, *shares])
        spans = list(pairwise(ends))
        spans += [(width / 2 - step * (place + 1), width / 2 - step * place) for place in range(pad) if row or draw.chance(0.5)]
        for left, right in spans:
            cap = key_cap(look, right - left - gap, float(high) - gap, thick, taper)
            at = (0.5 * (left + right), y - 0.5 * float(high), 0.0)
            keys.append([move(piece, at) for piece in key_parts(draw, form, cap)])
        y -= float(high)
    return keys


def _row(draw: Draw, columns: int) -> list[float]:
    """Widths of the keys of a row, which add up to `columns`: equal ones between wider ends."""
    first = draw.pick([1.0, draw.between(1.0, 2.4)])
    plain = int(columns - first - 1.0)
    return [first, *[1.0] * plain, columns - first - plain]


def _last_row(draw: Draw, columns: int) -> list[float]:
    """Widths of the keys of the row with the space bar, which add up to `columns`."""
    bar, left, right = draw.between(0.25, 0.5) * columns, draw.integer(1, 4), draw.integer(1, 6)
    side = (columns - bar) / (left + right)
    return [*[side] * left, bar, *[side] * right]


def resting_detail(draw: Draw, kind: str, size: float) -> list[Mesh]:
    """Meshes of a detail about `size` wide. `kind` is a key of `DETAIL_NAMES`."""
    thin = 0.05 * size
    if kind == "port":
        wide, high = size, size * draw.between(0.25, 0.9)
        if draw.chance(0.25):
            return [cylinder(0.5 * high, 4 * thin, "z", (0, 0, draw.between(-1.5, 1.0) * thin), 14)]
        if draw.chance(0.3):
            bars = [box((wide, 0.15 * high, thin), (0, s * 0.42 * high, 0.4 * thin)) for s in (-1, 1)]
            bars += [box((0.1 * wide, high, thin), (s * 0.45 * wide, 0, 0.4 * thin)) for s in (-1, 1)]
            return [join(*bars), box((0.6 * wide, 0.2 * high, thin))]
        return [box((wide, high, 4 * thin), (0, 0, draw.between(-1.9, 0.5) * thin))]
    if kind == "grille":
        count, high = draw.integer(4, 14), size * draw.ratio(0.15, 1.5)
        if draw.chance(0.3):
            rows = min(4, max(1, int(count * high / size)))
            dot, places = 0.3 * size / count, grid_places(count, rows, size, high)
            dots = [cylinder(dot, 0.4 * thin, "z", (x, y, 0.1 * thin), 6) for x, y in places]
            return dots if draw.chance(0.4) else [join(*dots)]
        pitch = size / count
        return [box((0.5 * pitch, high, 0.6 * thin), ((i + 0.5) * pitch - 0.5 * size, 0, 0.2 * thin)) for i in range(count)]
    if kind == "sticker":
        flat = (size, size * draw.between(0.3, 1.1))
        return [sheet(flat, (0, 0, 0.03 * thin), "z") if draw.chance(0.4) else box((*flat, 0.2 * thin), (0, 0, 0.05 * thin))]
    radius = 0.5 * size
    if kind == "lamp" and draw.chance(0.5):
        return [box((size, 0.4 * size, 0.3 * size), (0, 0, 0.1 * size))]
    if kind == "foot":
        tall = size * draw.between(0.1, 0.4)
        if draw.chance(0.3):
            return [box((size * draw.between(1.0, 4.0), 0.6 * size, tall), (0, 0, tall / 2))]
        return [cylinder(radius, tall, "z", (0, 0, tall / 2), 12, top_radius=radius * draw.between(0.6, 1.0))]
    if kind == "key":
        look, high = draw.pick(CAP_LOOKS), size * draw.between(0.4, 1.0)
        return [key_cap(look, size, high, draw.between(0.05, 0.3) * size, 0.8)]
    head = dome((radius, 0.4 * radius, radius), axis="z", segments=12) if draw.chance(0.5) else None
    head = head or cylinder(radius, 0.3 * size, "z", (0, 0, 0.05 * size), 12)
    slot = [box((1.4 * radius, 0.25 * radius, 0.1 * size), (0, 0, 0.2 * size))] if kind == "screw" and draw.chance(0.5) else []
    return [head, *slot]


def add_resting(
    draw: Draw, above: Node, kind: str, size: float, frames: Iterable[NDArray[np.float64]], *, alike: bool = True
) -> list[Node]:
    """Add details of one kind as leaves, and return these. The caller gives them to a link.

    Args:
        above: Node that the leaves are added below.
        kind: Key of `DETAIL_NAMES`.
        size: Width of each detail.
        frames: Rigid transforms [4, 4] from a front at the origin to the places of the details.
        alike: All details have one shape.

    Returns:
        One leaf per detail, or one leaf with all of them.
    """
    places, name = list(frames), draw.pick(DETAIL_NAMES[kind])
    sources = draw.identical(len(places)) if alike else [draw] * len(places)
    details = [resting_detail(own, kind, size) for own in sources]
    found = [[transform(piece, place) for piece in pieces] for pieces, place in zip(details, places, strict=True)]
    if draw.chance(0.5):
        found = [[piece for pieces in found for piece in pieces]] if found else []
    return [above.add(name, *pieces) for pieces in found]


def add_body_details(draw: Draw, above: Node, low: Point, high: Point) -> list[Node]:
    """Add a few details to the sides, the back and the underside of a box-shaped body; returns their leaves.

    Args:
        above: Node that the leaves are added below.
        low: Lowest corner [3] of the body.
        high: Highest corner [3] of the body.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    nodes: list[Node] = []
    for _ in range(draw.integer(1, 3)):
        kind = draw.pick(list(DETAIL_NAMES), [4, 4, 3, 2, 3, 0, 1])
        normal, up = draw.pick([(X, Y), (-X, Y), (-Z, Y), (-Y, Z)], [2, 2, 3, 1])
        right = np.cross(up, normal)
        room, tall = float(np.abs(right) @ half), float(np.abs(up) @ half)
        wide = draw.ratio(0.04, 0.25) if kind in ("grille", "sticker") else draw.ratio(0.02, 0.08)
        count = 1 if kind == "grille" else draw.integer(1, 4)
        size = 2.0 * wide * min(room, tall)
        start = middle + normal * half + right * draw.between(-0.6, 0.2) * room + up * draw.between(-0.6, 0.6) * tall
        frames = [facing(normal, up, start + 1.5 * size * index * right) for index in range(count)]
        nodes += add_resting(draw, above, kind, size, frames)
    if draw.chance(0.3):
        size = draw.ratio(0.05, 0.2) * float(min(half[0], half[2]))
        corners = [(i * 0.8 * half[0], -half[1], k * 0.8 * half[2]) for i in (-1, 1) for k in (-1, 1)]
        nodes += add_resting(draw, above, "foot", size, [facing(-Y, Z, middle + np.array(at)) for at in corners])
    return nodes


def let_rest(links: Iterable[Link], carrier: Link) -> None:
    """Give the nodes of links to `carrier`, with which they move from then on."""
    carrier.nodes += [node for link in links for node in link.nodes]
