"""Supports of table tops: legs, panels, sleds, crossed bars, hairpins or a column, with stretchers, shelves and braces."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework import legs
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, box, box_between, cylinder, lathe, sweep
from kinmo.synth.synth_object import Node


def add_supports(draw: Draw, node: Node, x: float, z: float, high: float, thickness: float) -> None:
    """Add supports of one kind below the height `high` within half extents `x` and `z`, mostly four legs."""
    kind = draw.pick(["legs", "panels", "sled", "cross", "hairpin"], [12, 1.5, 1, 1, 0.7])
    inner_x, inner_z = x - thickness / 2, z - thickness / 2
    if kind == "legs":
        for leg in legs(draw, inner_x, inner_z, 0, high, thickness):
            node.add("leg", leg)
        _stretchers(draw, node, x, z, high, thickness)
    elif kind == "panels":
        deep = z * draw.between(0.7, 1.0)
        for side in (-1, 1):
            near, far = sorted((side * (x - 0.5 * thickness), side * x))
            node.add(draw.pick(["leg", "vertical_side_panel"]), box_between((near, 0, -deep), (far, high, deep)))
    elif kind == "sled":
        bar = 0.6 * thickness
        for side in (-1, 1):
            at = side * (x - bar / 2)
            posts = [box((bar, high, bar), (at, high / 2, s * (z - bar / 2))) for s in (-1, 1)]
            rails = [box((bar, bar, 2 * z - 2 * bar), (at, y, 0)) for y in (bar / 2, high - bar / 2)]
            node.add("leg", *posts, *rails[: draw.integer(1, 2)])
    elif kind == "cross":
        across = draw.chance(0.3)
        for side in (-1, 1):
            place = side * (inner_z if across else inner_x)
            for lean in (-1, 1):
                foot = (lean * inner_x, 0, place) if across else (place, 0, lean * inner_z)
                top = (-lean * inner_x, high, place) if across else (place, high, -lean * inner_z)
                node.add("leg", _bar(foot, top, 0.5 * thickness))
    else:
        for sx in (-1, 1):
            for sz in (-1, 1):
                foot = (sx * inner_x, 0, sz * inner_z)
                tops = [(sx * (inner_x - 0.12 * x), high, sz * inner_z), (sx * inner_x, high, sz * (inner_z - 0.2 * z))]
                node.add("leg", *(_bar(foot, top, 0.12 * thickness, 8) for top in tops))
    if draw.chance(0.08):
        # A brace across the rear.
        for lean in (-1, 1)[: draw.integer(1, 2)]:
            ends = (-lean * inner_x, 0.15 * high, -inner_z), (lean * inner_x, 0.85 * high, -inner_z)
            node.add("bar_stretcher", _bar(*ends, 0.15 * thickness))


def add_column(draw: Draw, node: Node, x: float, z: float, high: float, thickness: float) -> None:
    """Add one or two columns on a plate, on bars or on three to five feet."""
    foot, radius = draw.ratio(0.03, 0.1) * high, thickness * draw.between(0.5, 1.2)
    places = (0.0,) if x < 1.5 * z or draw.chance(0.5) else (-0.6 * x, 0.6 * x)
    kind, count = draw.pick(["plate", "disc", "feet"]), draw.pick([3, 4, 5], [1, 4, 1])
    turned = draw.chance(0.3)
    share = np.array([1.0, 0.7, 1.1, 0.6, 0.8, 0.6, 1.0]) if turned else np.ones(7)
    profile = np.stack([radius * share, np.linspace(foot, high, 7)], axis=1)
    for at in places:
        column = lathe(np.concatenate([[(0, foot)], profile, [(0, high)]]), draw.pick([8, 16, 24]))
        node.add("leg", Mesh(column.vertices + (at, 0, 0), column.faces))
        wide = 0.7 * min(z, x)
        if kind == "feet":
            angles = 2 * np.pi * (np.arange(count) + 0.25) / count
            ends = [(at + wide * np.cos(angle), 0.3 * foot, wide * np.sin(angle)) for angle in angles]
            node.add("foot", *(_bar((at, 1.5 * foot, 0), end, 0.3 * foot) for end in ends))
        elif kind == "disc":
            node.add("foot", cylinder(wide, foot, "y", (at, foot / 2, 0), 32, top_radius=wide * draw.between(0.7, 1.0)))
        else:
            node.add("foot", box((1.2 * wide, foot, 1.7 * z), (at, foot / 2, 0)))


def add_apron(draw: Draw, node: Node, x: float, z: float, low: float, high: float, board: float) -> None:
    """Add boards between the supports below a top, on two or four sides."""
    for side in (-1, 1):
        near, far = sorted((side * (z - board), side * z))
        node.add(draw.pick(["bar", "vertical_front_panel"]), box_between((-x, low, near), (x, high, far)))
    if draw.chance(0.7):
        for side in (-1, 1):
            near, far = sorted((side * (x - board), side * x))
            node.add("vertical_side_panel", box_between((near, low, -z + board), (far, high, z - board)))


def _stretchers(draw: Draw, node: Node, x: float, z: float, high: float, thickness: float) -> None:
    """Add bars between legs at the sides, front and rear, or as an H or a cross, and sometimes shelves on them."""
    if draw.chance(0.45):
        return
    y, half, inner_x, inner_z = draw.between(0.08, 0.4) * high, thickness / 3, x - thickness / 2, z - thickness / 2
    form = draw.pick(["sides", "H", "cross"], [6, 2, 1])
    if form == "cross":
        for lean in (-1, 1):
            node.add("bar_stretcher", _bar((-inner_x, y, -lean * inner_z), (inner_x, y, lean * inner_z), 0.5 * half))
        return
    for side in (-1, 1):
        node.add("bar_stretcher", box((half, half, 2 * (z - thickness)), (side * inner_x, y, 0)))
        if form == "sides" and draw.chance(0.5):
            node.add("bar_stretcher", box((2 * (x - thickness), half, half), (0, y, side * inner_z)))
    if form == "H":
        node.add("bar_stretcher", box((2 * inner_x, half, half), (0, y, 0)))
    if draw.chance(0.5):
        count = draw.pick([1, draw.integer(3, 9)], [3, 1])
        pitch = (2 * z - thickness) / count
        for index in range(count):
            at = -z + 0.5 * thickness + (index + 0.5) * pitch
            deep = pitch if count == 1 else 0.85 * pitch
            node.add("shelf", box((2 * x - thickness, 0.6 * half, deep), (0, y + half, at)))


def _bar(start: Point, end: Point, radius: float, corners: int = 4) -> Mesh:
    """A straight bar between two points [3]."""
    return sweep(np.array([start, end], float), radius, corners)
