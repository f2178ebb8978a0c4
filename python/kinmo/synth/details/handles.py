"""Handles on the front (+z) of a door or drawer: pulls, bars, bows, knobs, cups, ledges, drops and sunk grips."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    Point,
    Z,
    arc_path,
    box,
    cylinder,
    dome,
    ellipsoid,
    join,
    lathe,
    move,
    rounded_path,
    sweep,
    torus,
    turn,
)


def bar_handle(draw: Draw, length: float, thickness: float, reach: float, *, vertical: bool) -> list[Mesh]:
    """A bar along y or x on two posts that stand on the plane z = 0, one piece per rod."""
    axis = "y" if vertical else "x"
    side = np.eye(3)[1 if vertical else 0]
    posts = [side * s * length * draw.between(0.36, 0.46) for s in (-1, 1)]
    if draw.chance(0.5):
        bar = cylinder(thickness / 2, length, axis, (0, 0, reach), draw.pick([8, 12, 16]))
    else:
        bar = box(np.where(side > 0, length, thickness), (0, 0, reach))
    return [bar, *(box((thickness, thickness, reach), (p[0], p[1], reach / 2)) for p in posts)]


def bow_handle(draw: Draw, length: float, thickness: float, reach: float, *, vertical: bool) -> list[Mesh]:
    """A rod bent to a bow or a square bracket, in one piece."""
    if draw.chance(0.5):
        path = arc_path((0, 0, 0), length / 2, 0, 180, "y", 12, aspect=2 * reach / length)[:, [2, 1, 0]]
    else:
        ends = [[-length / 2, 0, 0], [-length / 2, 0, reach], [length / 2, 0, reach], [length / 2, 0, 0]]
        path = rounded_path(np.array(ends), 0.6 * reach)
    rod = sweep(path, thickness / 2, draw.pick([6, 8, 10]))
    return [turn(rod, (0, 0, 1), 90.0) if vertical else rod]


def knob_handle(draw: Draw, radius: float, reach: float) -> list[Mesh]:
    """A knob of revolution along +z."""
    segments = draw.pick([12, 16, 24])
    neck = radius * draw.between(0.3, 0.6)
    profile = np.array(
        [[neck, 0], [neck, 0.5 * reach], [radius, 0.6 * reach], [radius, 0.9 * reach], [0.8 * radius, reach], [0, reach]]
    )
    turned = lathe(profile, segments)
    if draw.chance(0.3):
        ball = ellipsoid((radius, radius, radius), (0, 0, reach), segments, 8)
        return [join(cylinder(neck, reach, "z", (0, 0, reach / 2), segments), ball)]
    return [turn(turned, (1, 0, 0), 90.0)]


def _flat_handle(draw: Draw, kind: str, length: float, thickness: float, reach: float) -> list[Mesh]:
    """A handle along x whose front is closed or that hangs: "cup", "ledge", "drop", "ring", "sunk" or "plated"."""
    if kind == "cup":
        return [dome((draw.between(0.7, 1.5) * reach, reach, 0.5 * length), axis="z", segments=16)]
    if kind == "ledge":
        return [
            box((length, 0.3 * thickness, reach), (0, 0, 0.5 * reach)),
            box((length, thickness, 0.2 * reach), (0, 0, reach)),
        ]
    if kind == "sunk":
        rim, half = 0.12 * length, draw.between(0.15, 0.4) * length
        bars = [box((length, rim, 0.4 * thickness), (0, s * half, 0.2 * thickness)) for s in (-1, 1)]
        return [*bars, *(box((rim, 2 * half, 0.4 * thickness), (s * 0.5 * length, 0, 0.2 * thickness)) for s in (-1, 1))]
    if kind == "plated":
        plate = box((length, draw.between(2.0, 4.0) * thickness, 0.3 * thickness), (0, 0, 0.15 * thickness))
        return [plate, *knob_handle(draw, min(0.2 * length, 1.2 * thickness), reach)]
    boss = [
        cylinder(0.8 * thickness, reach, "z", (x, 0, 0.5 * reach), 10)
        for x in ((-0.4 * length, 0.4 * length), (0.0,))[kind == "ring"]
    ]
    if kind == "ring":
        size = 0.35 * length
        return [*boss, torus(size, 0.4 * thickness, "z", (0, -size, 0.8 * reach), 20, 6)]
    path = rounded_path(np.array([(-0.4, 0, 0), (-0.4, -0.4, 0), (0.4, -0.4, 0), (0.4, 0, 0)]) * length, 0.2 * length)
    return [*boss, move(sweep(path, 0.4 * thickness, 6), (0, 0, 0.8 * reach))]


def pull(
    draw: Draw, length: float, at: Point, *, vertical: bool, thickness: float | None = None, reach: float | None = None
) -> list[Mesh]:
    """Meshes of a handle of a random kind.

    Args:
        length: Length of the handle.
        at: Foot [3] of the handle.
        vertical: Along y instead of x.
        thickness: Thickness of the rod; None for a random one.
        reach: Height above the front; None for a random one.

    Returns:
        The pieces, in the order of assembly.
    """
    thickness = length * draw.between(0.06, 0.16) if thickness is None else thickness
    reach = max(1.5 * thickness, length * draw.between(0.12, 0.3)) if reach is None else reach
    kind = draw.pick(
        ["bar", "bow", "knob", "block", "cup", "ledge", "drop", "ring", "sunk", "plated"], [8, 6, 4, 3, 1, 2, 1, 1, 1.5, 1]
    )
    if kind == "bar":
        pieces = bar_handle(draw, length, thickness, reach, vertical=vertical)
    elif kind == "bow":
        pieces = bow_handle(draw, length, thickness, reach, vertical=vertical)
    elif kind == "knob":
        pieces = knob_handle(draw, min(0.2 * length, draw.between(0.8, 1.6) * thickness), reach)
    elif kind == "block":
        size = (thickness, length, reach) if vertical else (length, thickness, reach)
        pieces = [box(size, (0, 0, reach / 2))]
    else:
        pieces = _flat_handle(
            draw, kind, min(length, 8 * reach) if kind in ("cup", "drop", "ring", "plated") else length, thickness, reach
        )
        if vertical and kind in ("ledge", "sunk"):
            pieces = [turn(piece, Z, 90.0) for piece in pieces]
    return [move(piece, at) for piece in pieces]
