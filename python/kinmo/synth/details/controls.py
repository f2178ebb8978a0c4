"""Buttons and dials on a front that faces +z, and grids to place them."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, box, cylinder, dome, extrude, lathe, move, rounded_box, sheet, turn

CAP_LOOKS = ("box", "tapered", "rounded", "round", "plate", "sunk")
"""Looks of keys."""

KEY_FORMS = ("solid", "open", "capped", "lettered")
"""Forms of keys: one solid, a cap without a bottom, a cap with a plate on it, or one with a sign of loose strokes."""


def dial(draw: Draw, radius: float, depth: float, at: Point) -> list[Mesh]:
    """Meshes of a knob that turns about z, with its foot at `at`.

    It is plain, stepped, tapered, ribbed, domed, waisted or a disc with a wing, often with a pointer.
    """
    segments = draw.pick([12, 16, 24, 32])
    kind = draw.pick(["plain", "stepped", "tapered", "ribbed", "domed", "waisted", "wing"], [4, 4, 4, 2, 1, 1, 2])
    if kind == "ribbed":
        count, deep = draw.integer(5, 24), draw.ratio(0.02, 0.15)
        angle = np.linspace(0, 2 * np.pi, 4 * count, endpoint=False)
        reach = radius * (1 - deep + deep * np.cos(count * angle))
        body = extrude(np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1), depth, "z", (0, 0, depth / 2))
    elif kind in ("domed", "waisted"):
        turned = {
            "domed": [[0, 0], [1, 0], [1, 0.3], [0.9, 0.65], [0.6, 0.9], [0, 1]],
            "waisted": [[0, 0], [0.8, 0], [0.55, 0.4], [1, 0.75], [1, 1], [0, 1]],
        }
        body = turn(lathe(np.array(turned[kind]) * (radius, depth), segments), (1, 0, 0), 90.0)
    elif kind == "wing":
        thin = draw.between(0.1, 0.4) * depth
        wing = box(
            (draw.between(0.2, 0.5) * radius, 2 * radius * draw.between(0.85, 1.1), depth - thin), (0, 0, 0.5 * (depth + thin))
        )
        wing = turn(wing, (0, 0, 1), draw.pick([0.0, 45.0, 90.0, draw.between(0.0, 180.0)]))
        return [move(piece, at) for piece in (cylinder(radius, thin, "z", (0, 0, thin / 2), segments), wing)]
    elif kind == "plain":
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
    """A button that is pressed along -z, with its foot at `at`: square, rounded, oval, round, tapered or domed."""
    kind = draw.pick(["box", "rounded", "round", "oval", "tapered", "domed"], [10, 4, 3, 1, 1, 1])
    if kind == "box":
        mesh = box((width, height, depth), (0, 0, depth / 2))
    elif kind == "rounded":
        mesh = rounded_box((width, height, depth), 0.3 * min(width, height), "z", (0, 0, depth / 2), 3)
    elif kind == "oval":
        mesh = rounded_box((width, height, depth), 0.5 * min(width, height), "z", (0, 0, depth / 2), 6)
    elif kind == "domed":
        mesh = dome((0.5 * height, depth, 0.5 * width), axis="z", segments=14)
    else:
        radius = min(width, height) / 2
        top = radius * (draw.between(0.6, 0.95) if kind == "tapered" else 1.0)
        mesh = cylinder(radius, depth, "z", (0, 0, depth / 2), draw.pick([12, 16, 24]), top_radius=top)
    return move(mesh, at)


def key_cap(look: str, width: float, height: float, thick: float, taper: float) -> Mesh:
    """A key of a keyboard with its foot on z = 0, or sunk below it. `look` is one of `CAP_LOOKS`."""
    if look == "plate":
        return box((width, height, 0.15 * thick), (0, 0, 0.075 * thick))
    if look == "sunk":
        return box((width, height, thick), (0, 0, -0.4 * thick))
    if look == "rounded":
        return rounded_box((width, height, thick), 0.25 * min(width, height), "z", (0, 0, thick / 2), 2)
    if look == "round" and width < 1.6 * height:
        return cylinder(0.5 * min(width, height), thick, "z", (0, 0, thick / 2), 12)
    cap = box((width, height, thick), (0, 0, thick / 2))
    if look == "tapered":
        cap.vertices[cap.vertices[:, 2] > thick / 2] *= (taper, taper, 1.0)
    return cap


def key_parts(draw: Draw, form: str, cap: Mesh) -> list[Mesh]:
    """A key cap as the loose pieces that a drawing of it may have. `form` is one of `KEY_FORMS`."""
    low, high = cap.vertices.min(axis=0), cap.vertices.max(axis=0)
    (width, height, thick), middle = high - low, 0.5 * (low + high)
    if form == "open":
        bottom = np.all(cap.vertices[cap.faces][:, :, 2] < low[2] + 1e-9, axis=1)
        return [Mesh(cap.vertices, cap.faces[~bottom])]
    if form == "capped":
        return [cap, box((0.8 * width, 0.8 * height, 0.3 * thick), (middle[0], middle[1], high[2]))]
    if form == "lettered":
        stroke = 0.08 * min(width, height)
        sizes = [draw.pick([(stroke, 0.4 * height), (0.3 * height, stroke)]) for _ in range(draw.integer(1, 3))]
        places = [middle[:2] + np.array([draw.between(-0.2, 0.2) * width, draw.between(-0.1, 0.2) * height]) for _ in sizes]
        strokes = [sheet(size, (*at, high[2] + 0.02 * thick), "z") for size, at in zip(sizes, places, strict=True)]
        return [cap, *strokes]
    return [cap]


def grid_places(columns: int, rows: int, width: float, height: float) -> list[tuple[float, float]]:
    """Centres (x, y) of a grid of cells that fills `width` x `height` about the origin, row by row from the top left."""
    return [
        (width * ((column + 0.5) / columns - 0.5), height * (0.5 - (row + 0.5) / rows))
        for row in range(rows)
        for column in range(columns)
    ]
