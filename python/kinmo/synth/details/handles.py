"""Handles on the front (+z) of a door or drawer: bars, bows, knobs of many shapes, cups, shells, ledges, tabs, sunk grips."""

from __future__ import annotations

from itertools import pairwise

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
    tube,
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


def assembled_handle(draw: Draw, length: float, thickness: float, reach: float) -> list[Mesh]:
    """A handle along x of several pieces: a bow on discs, a capped bar, a bracket, an arc of blocks, or two bars."""
    kind = draw.pick(["discs", "capped", "bracket", "blocks", "twin"], [2, 2, 2, 1, 1])
    half, post = 0.5 * length, draw.between(0.36, 0.46) * length
    if kind == "discs":
        wide = draw.between(1.0, 1.8) * thickness
        feet = [cylinder(wide, 0.3 * thickness, "z", (s * half, 0, 0.15 * thickness), 16) for s in (-1, 1)]
        return [*feet, *bow_handle(draw, length, thickness, reach, vertical=False)]
    if kind == "capped":
        bar = cylinder(0.5 * thickness, 2 * post, "x", (0, 0, reach), 12)
        posts = [cylinder(0.4 * thickness, reach, "z", (s * 0.8 * post, 0, 0.5 * reach), 10) for s in (-1, 1)]
        ball = np.full(3, draw.between(0.6, 0.9) * thickness)
        return [bar, *posts, *(ellipsoid(ball, (s * post, 0, reach), 12, 8) for s in (-1, 1))]
    if kind == "bracket":
        flat = draw.between(0.4, 2.5) * thickness
        arms = [box((0.5 * thickness, flat, reach), (s * (half - 0.25 * thickness), 0, 0.5 * reach)) for s in (-1, 1)]
        grip = box((length, flat, 0.5 * thickness), (0, 0, reach))
        plates = [box((2 * thickness, flat, 0.15 * thickness), (s * half, 0, 0.08 * thickness)) for s in (-1, 1)]
        return [grip, *arms, *(plates if draw.chance(0.4) else [])]
    if kind == "blocks":
        angles = np.radians(np.linspace(0, 180, draw.integer(4, 9) + 1))
        points = np.stack([-half * np.cos(angles), np.zeros(len(angles)), reach * np.sin(angles)], axis=1)
        pieces = []
        for start, end in pairwise(points):
            tilt = np.degrees(np.arctan2(-(end - start)[2], (end - start)[0]))
            block = box((1.05 * float(np.linalg.norm(end - start)), thickness, 0.6 * thickness))
            pieces.append(move(turn(block, (0, 1, 0), tilt), 0.5 * (start + end)))
        return pieces
    bars = [cylinder(0.3 * thickness, length, "x", (0, s * 0.6 * thickness, reach), 8) for s in (-1, 1)]
    return [*bars, *(box((thickness, 1.6 * thickness, reach), (s * post, 0, 0.5 * reach)) for s in (-1, 1))]


def knob_handle(draw: Draw, radius: float, reach: float) -> list[Mesh]:
    """A knob along +z that does not turn: of revolution, a ball, a block, a pyramid, a stub, a plate or a ring."""
    segments = draw.pick([12, 16, 24])
    neck, stem = radius * draw.between(0.3, 0.6), reach * draw.between(0.3, 0.7)
    profiles = {
        "turned": [[neck, 0], [neck, stem], [radius, stem + 0.1 * reach], [radius, 0.9 * reach], [0.8 * radius, reach]],
        "mushroom": [[neck, 0], [neck, stem], [radius, stem], [0.85 * radius, 0.5 * (stem + reach)]],
        "flared": [[neck, 0], [0.7 * neck, stem], [radius, reach]],
        "disc": [[neck, 0], [neck, 0.8 * reach], [radius, 0.8 * reach], [radius, reach]],
    }
    solids = ["ball", "box", "pyramid", "stub", "ring"]
    kind = draw.pick([*profiles, *solids], [5, 2, 1, 2, 2.5, 3, 2, 2, 1])
    if kind in profiles:
        return [turn(lathe(np.array([*profiles[kind], [0, reach]]), segments), (1, 0, 0), 90.0)]
    foot = cylinder(neck, reach, "z", (0, 0, reach / 2), segments)
    if kind == "ball" and neck < 0.4 * radius:
        return [ellipsoid((radius, radius, radius), (0, 0, radius), segments, 8)]  # it touches the front at a point
    if kind == "ball":
        return [join(foot, ellipsoid((radius, radius, radius), (0, 0, reach), segments, 8))]
    if kind == "stub":
        end = radius * draw.between(0.7, 1.1)
        return [cylinder(radius, reach, "z", (0, 0, reach / 2), draw.pick([6, 8, 16, 24]), top_radius=end)]
    if kind == "ring":
        ring = torus(0.8 * radius, 0.2 * radius, draw.pick(["x", "y", "z"]), (0, 0, reach), 16, 6)
        return [cylinder(0.4 * neck, reach - 0.7 * radius, "z", (0, 0, 0.5 * (reach - 0.7 * radius)), 8), ring]
    low = draw.pick([0.0, stem])
    size = (2 * radius, 2 * radius * draw.pick([1.0, draw.between(0.5, 1.0)]), reach - low)
    head = box(size, (0, 0, 0.5 * (low + reach)))
    if kind == "pyramid":
        head.vertices[head.vertices[:, 2] > 0.5 * (low + reach)] *= (taper := draw.between(0.05, 0.8), taper, 1.0)
    head = turn(head, Z, draw.pick([0.0, 45.0], [4, 1]))
    if not low:
        return [head]
    post = cylinder(neck, low, "z", (0, 0, low / 2), segments)
    if draw.chance(0.4):
        post = box((2 * neck, 2 * neck, low), (0, 0, low / 2))
    return [join(post, head)] if draw.chance(0.5) else [post, head]


def _flat_handle(draw: Draw, kind: str, length: float, thickness: float, reach: float) -> list[Mesh]:
    """A handle along x that is flat, closed to the front, or hangs; see `pull` for the kinds."""
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
    if kind == "shell":
        whole = dome((draw.between(0.8, 1.5) * reach, reach, 0.5 * length), axis="z", segments=16)
        upper = whole.vertices[whole.faces][:, :, 1].min(axis=1) > -1e-9 * length
        return [Mesh(whole.vertices, whole.faces[upper]).compact]
    if kind == "edge":
        thin, fall = 0.25 * thickness, draw.between(1.0, 3.0) * thickness
        plates = [box((length, fall, thin), (0, 0, 0.5 * thin)), box((length, thin, reach), (0, 0.5 * fall, 0.5 * reach))]
        return [*plates, box((length, 0.4 * fall, thin), (0, 0.3 * fall, reach))][: draw.integer(2, 3)]
    if kind == "tab":
        flat = box((draw.between(0.2, 0.6) * length, 0.3 * thickness, reach), (0, 0, 0.5 * reach))
        return [turn(flat, Z, draw.pick([0.0, 90.0]))]
    if kind == "plate":
        size = (length, draw.between(0.3, 1.0) * length, draw.between(0.1, 0.4) * thickness)
        if draw.chance(0.4):
            return [cylinder(0.5 * length, size[2], "z", (0, 0, 0.5 * size[2]), 20)]
        return [box(size, (0, 0, 0.5 * size[2]))]
    if kind == "dish":
        radius, deep = 0.5 * length, 0.3 * thickness
        floor = cylinder(0.8 * radius, 0.3 * deep, "z", segments=20)
        return [tube(radius, 0.8 * radius, deep, "z", (0, 0, 0.4 * deep), 20), floor]
    if kind == "plated":
        plate = box((length, draw.between(2.0, 4.0) * thickness, 0.3 * thickness), (0, 0, 0.15 * thickness))
        return [plate, *knob_handle(draw, min(0.2 * length, 1.2 * thickness), reach)]
    boss = [
        cylinder(0.8 * thickness, reach, "z", (x, 0, 0.5 * reach), 10)
        for x in ((-0.4 * length, 0.4 * length), (0.0,))[kind == "ring"]
    ]
    if kind == "ring":
        radius = 0.35 * length
        return [*boss, torus(radius, 0.4 * thickness, "z", (0, -radius, 0.8 * reach), 20, 6)]
    path = rounded_path(np.array([(-0.4, 0, 0), (-0.4, -0.4, 0), (0.4, -0.4, 0), (0.4, 0, 0)]) * length, 0.2 * length)
    return [*boss, move(sweep(path, 0.4 * thickness, 6), (0, 0, 0.8 * reach))]


def pull(
    draw: Draw,
    length: float,
    at: Point,
    *,
    vertical: bool,
    thickness: float | None = None,
    reach: float | None = None,
    room: float = np.inf,
) -> list[Mesh]:
    """Meshes of a handle of a random kind.

    Args:
        length: Length of the handle.
        at: Foot [3] of the handle.
        vertical: Along y instead of x.
        thickness: Thickness of the rod; None for a random one.
        reach: Height above the front; None for a random one.
        room: Shorter side of the front, which handles as wide as long do not exceed.

    Returns:
        The pieces, in the order of assembly.
    """
    thickness = length * draw.between(0.06, 0.16) if thickness is None else thickness
    reach = max(1.5 * thickness, length * draw.between(0.12, 0.3)) if reach is None else reach
    flat = {"cup": 1, "shell": 1, "ledge": 2, "edge": 1.5, "drop": 1, "ring": 1, "sunk": 1.5, "dish": 0.7, "plated": 1}
    flat |= {"plate": 0.7, "tab": 0.7}
    kind = draw.pick(["bar", "bow", "assembled", "knob", "block", *flat], [8, 6, 4, 9, 3, *flat.values()])
    if kind == "bar":
        pieces = bar_handle(draw, length, thickness, reach, vertical=vertical)
    elif kind == "bow":
        pieces = bow_handle(draw, length, thickness, reach, vertical=vertical)
    elif kind == "assembled":
        pieces = assembled_handle(draw, length, thickness, reach)
        pieces = [turn(piece, Z, 90.0) for piece in pieces] if vertical else pieces
    elif kind == "knob":
        pieces = knob_handle(draw, min(0.2 * length, draw.between(0.8, 1.6) * thickness), reach)
    elif kind == "block":
        size = (thickness, length, reach) if vertical else (length, thickness, reach)
        pieces = [box(size, (0, 0, reach / 2))]
    else:
        if kind == "sunk":
            length = min(length, 1.2 * room)
        elif kind not in ("ledge", "edge"):
            length = min(length, 8 * reach, 0.9 * room)
        pieces = _flat_handle(draw, kind, length, thickness, reach)
        if vertical and kind in ("ledge", "sunk", "edge", "plate"):
            pieces = [turn(piece, Z, 90.0) for piece in pieces]
    return [move(piece, at) for piece in pieces]
