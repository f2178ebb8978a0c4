"""Gas and electric hobs with knobs: built into a worktop, on the table, on a stand, or with a lid."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import dial, grid_places
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, join, move, rounded_box, torus, tube, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Hob with one to six burners and as many knobs.

    Knobs are on the top (at the front or a side) or on the front, and turn. A lid may fold up, and a tray slide out. Burners,
    grates, pot rests and splashbacks are fixed.
    """
    columns, rows = draw.pick([(1, 1), (2, 1), (2, 2), (3, 2), (3, 1)], [1, 3, 5, 2, 1])
    cell = draw.between(0.25, 0.4)
    wide, deep = columns * cell, rows * cell
    tall = draw.ratio(0.04, 0.3)
    place = draw.pick(["front", "top front", "top side"], [4, 3, 2])
    strip = draw.between(0.1, 0.2)
    x0, x1, z0, z1 = -wide / 2, wide / 2, -deep / 2, deep / 2
    if place == "top front":
        z1 += strip
    elif place == "top side":
        x1 += strip
    root = Node("oven")
    body = draw.pick(
        [
            box_between((x0, -tall, z0), (x1, 0, z1)),
            rounded_box((x1 - x0, tall, z1 - z0), 0.05, "y", ((x0 + x1) / 2, -tall / 2, (z0 + z1) / 2)),
        ]
    )
    base = Link("body", [root.add("body", body)], kind=draw.pick([JointType.STATIC, JointType.FREE, JointType.HEAVY]))
    links = [base]
    _add_burners(draw, root, base, columns, rows, wide, deep)
    count = max(2, columns * rows) if draw.chance(0.85) else draw.integer(2, 6)
    links += _add_knobs(draw, root, base, count, place, (x0, x1, z0, z1), tall, strip)
    _add_stand(draw, root, base, (x0, x1, z0, z1), tall)
    if draw.chance(0.3):
        thick, high = draw.ratio(0.006, 0.02), draw.between(0.05, 0.08)
        lid = root.add(draw.pick(["lid", "cover"]), box_between((x0, high, z0), (x1, high + thick, z1)))
        opens = draw.between(85.0, 105.0)
        motion = hinge((0, high, z0), -X, 0.0, opens, rest=draw.pick([opens, 0.0, draw.between(30.0, 80.0)], [4, 1, 1]))
        links.append(Link("lid", [lid], base, motion))
    elif draw.chance(0.3):
        plate = box_between((x0, 0, z0), (x1, draw.between(0.08, 0.3), z0 + 0.015))
        base.nodes.append(root.add(draw.pick(["back_panel", "splashback"]), plate))
    if tall > 0.12 and place != "front" and draw.chance(0.4):
        tray = box_between((0.9 * x0, -0.7 * tall, 0.9 * z0), (0.9 * x1, -0.6 * tall, z1))
        front = box_between((0.95 * x0, -0.85 * tall, z1), (0.95 * x1, -0.45 * tall, z1 + 0.015))
        node = root.add("tray", tray, front)
        links.append(Link("tray", [node], base, slider(Z, 0.0, 0.7 * (z1 - z0)), leaf_name="translation_tray"))
    return SynthObject("Oven", root, links)


def _add_burners(draw: Draw, root: Node, base: Link, columns: int, rows: int, wide: float, deep: float) -> None:
    """Burners with grates above them, one per burner or one per column; or plates, or rings drawn on the top."""
    kind, grate = draw.pick(["gas", "plate", "ring"], [5, 2, 1]), draw.pick(["cross", "frame", "column", "none"], [3, 3, 2, 1])
    bar, high = draw.ratio(0.006, 0.015), draw.between(0.02, 0.05)
    size = wide / columns
    for x, z in grid_places(columns, rows, wide, deep):
        radius = draw.between(0.1, 0.3) * size
        at = np.array([x, 0.0, -z])
        if kind == "gas":
            cap = cylinder(0.7 * radius, 0.4 * high, "y", at + (0, 0.5 * high, 0), 18)
            ring = cylinder(radius, 0.3 * high, "y", at + (0, 0.15 * high, 0), 18)
            burner = [ring, cap]
        elif kind == "plate":
            burner = [cylinder(1.2 * radius, 0.4 * high, "y", at + (0, 0.2 * high, 0), 24)]
        else:
            burner = [tube(radius, 0.9 * radius, 0.002, "y", at + (0, 0.001, 0), 24)]
        base.nodes.append(root.add("burner", *burner))
        if kind != "gas" or grate in ("none", "column"):
            continue
        arm = 0.44 * size
        bars: list[Mesh] = [box((2 * arm, bar, bar), at + (0, high, 0)), box((bar, bar, 2 * arm), at + (0, high, 0))]
        if grate == "frame":
            bars += [box((2 * arm, bar, bar), at + (0, high, s * arm)) for s in (-1, 1)]
            bars += [box((bar, bar, 2 * arm), at + (s * arm, high, 0)) for s in (-1, 1)]
        elif draw.chance(0.3):
            bars = [torus(arm, bar / 2, "y", at + (0, high, 0), 24, 6), *bars]
        feet = [box((bar, high, bar), at + (sx * arm, high / 2, sz * arm)) for sx, sz in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        rest = [*bars, *feet]
        base.nodes.append(root.add(draw.pick(["grate", "grid", "rack"]), *([join(*rest)] if draw.chance(0.6) else rest)))
    if kind == "gas" and grate == "column":
        for column in range(columns):
            x = wide * ((column + 0.5) / columns - 0.5)
            bars = [box((bar, bar, 0.94 * deep), (x + s * 0.42 * size, high, 0)) for s in (-1, 1)]
            bars += [box((0.84 * size, bar, bar), (x, high, share * deep)) for share in np.linspace(-0.47, 0.47, 3 * rows)]
            bars += [box((bar, high, bar), (x + s * 0.42 * size, high / 2, t * 0.46 * deep)) for s in (-1, 1) for t in (-1, 1)]
            base.nodes.append(root.add("grate", join(*bars)))


def _add_knobs(
    draw: Draw,
    root: Node,
    base: Link,
    count: int,
    place: str,
    area: tuple[float, float, float, float],
    tall: float,
    strip: float,
) -> list[Link]:
    """Knobs in a row at one of three places; they turn, freely or by up to three quarters."""
    x0, x1, z0, z1 = area
    along = (x0, x1) if place != "top side" else (z0, z1)
    room = (along[1] - along[0]) / count
    width = min(room, tall if place == "front" else strip)
    radius = draw.between(0.25, 0.42) * width
    deep = radius * draw.ratio(0.5, 1.8)
    links = []
    span = draw.pick([1.0, draw.between(0.6, 1.0)])
    name, turns = draw.pick(["knob", "switch", "control_button"]), draw.pick(["free", "limited"])
    limits = draw.pick([(0.0, 180.0), (0.0, 270.0), (0.0, 90.0), (-135.0, 135.0)])
    for own, index in zip(draw.identical(count), range(count), strict=True):
        aside = 0.5 * (along[0] + along[1]) + span * room * (index + 0.5 - count / 2)
        pieces = dial(own, radius, deep, (0, 0, 0))
        if place == "front":
            at, axis = np.array([aside, -tall / 2, z1]), Z
        else:
            at = np.array([aside, 0.0, z1 - strip / 2]) if place == "top front" else np.array([x1 - strip / 2, 0.0, aside])
            axis = Y
            pieces = [turn(piece, X, -90.0) for piece in pieces]
        if own.chance(0.3):
            ring = tube(1.2 * radius, 0.9 * radius, 0.1 * deep, "z" if place == "front" else "y", at, 20)
            base.nodes.append(root.add("ring", ring))
        node = root.add(name, *(move(piece, at) for piece in pieces))
        motion = spinner(at, axis) if turns == "free" else hinge(at, axis, *limits)
        links.append(Link("knob", [node], base, motion, leaf_name=name))
    return links


def _add_stand(draw: Draw, root: Node, base: Link, area: tuple[float, float, float, float], tall: float) -> None:
    """Add a worktop around a flat hob, feet, or legs with a shelf; or nothing."""
    x0, x1, z0, z1 = area
    kind = draw.pick(["none", "worktop", "feet", "legs"], [2, 2 if tall < 0.08 else 0.3, 3, 2])
    if kind == "worktop":
        over, thick = draw.between(0.05, 0.4), draw.between(0.02, 0.05)
        plate = box_between((x0 - over, -tall - thick, z0 - 0.08), (x1 + over, -tall, z1 + 0.08))
        base.nodes.append(root.add("countertop", plate))
    elif kind in ("feet", "legs"):
        drop, thin = (draw.between(0.02, 0.06), 0.03) if kind == "feet" else (draw.between(0.3, 0.8), 0.025)
        for x in (x0 + thin, x1 - thin):
            for z in (z0 + thin, z1 - thin):
                leg = draw.pick([box((thin, drop, thin)), cylinder(thin / 2, drop, "y")])
                base.nodes.append(root.add("foot", move(leg, (x, -tall - drop / 2, z))))
        if kind == "legs" and draw.chance(0.6):
            shelf = box_between((x0, -tall - 0.7 * drop, z0), (x1, -tall - 0.7 * drop + 0.015, z1))
            base.nodes.append(root.add("shelf", shelf))
