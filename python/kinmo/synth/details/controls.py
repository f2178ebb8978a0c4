"""Buttons and dials on a front that faces +z, and grids to place them."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, box, cylinder, lathe, move, rounded_box, turn


def dial(draw: Draw, radius: float, depth: float, at: Point) -> list[Mesh]:
    """Meshes of a knob that turns about z, with its foot at `at`: plain, stepped or tapered, often with a pointer."""
    segments = draw.pick([12, 16, 24, 32])
    kind = draw.pick(["plain", "stepped", "tapered"])
    if kind == "plain":
        body = cylinder(radius, depth, "z", (0, 0, depth / 2), segments)
    elif kind == "tapered":
        body = cylinder(radius, depth, "z", (0, 0, depth / 2), segments, top_radius=draw.between(0.6, 0.9) * radius)
    else:
        share = draw.between(0.2, 0.5)
        profile = np.array([[0, 0], [1, 0], [1, share], [0.7, share], [0.65, 1], [0, 1]]) * (radius, depth)
        body = turn(lathe(profile, segments), (1, 0, 0), 90.0)
    pieces = [body]
    if draw.chance(0.5):
        grip = box((0.25 * radius, 1.7 * radius, 0.4 * depth), (0, 0, 1.1 * depth))
        pieces.append(turn(grip, (0, 0, 1), draw.between(-90, 90)))
    return [move(piece, at) for piece in pieces]


def button(draw: Draw, width: float, height: float, depth: float, at: Point) -> Mesh:
    """A button that is pressed along -z, with its foot at `at`: square, rounded or round."""
    kind = draw.pick(["box", "rounded", "round"], [5, 2, 2])
    if kind == "box":
        mesh = box((width, height, depth), (0, 0, depth / 2))
    elif kind == "rounded":
        mesh = rounded_box((width, height, depth), 0.3 * min(width, height), "z", (0, 0, depth / 2), 3)
    else:
        mesh = cylinder(min(width, height) / 2, depth, "z", (0, 0, depth / 2), draw.pick([12, 16, 24]))
    return move(mesh, at)


def grid_places(columns: int, rows: int, width: float, height: float) -> list[tuple[float, float]]:
    """Centres (x, y) of a grid of cells that fills `width` x `height` about the origin, row by row from the top left."""
    return [
        (width * ((column + 0.5) / columns - 0.5), height * (0.5 - (row + 0.5) / rows))
        for row in range(rows)
        for column in range(columns)
    ]
