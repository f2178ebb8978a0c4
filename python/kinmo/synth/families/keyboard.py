"""Keyboards with keys, folding feet and sometimes a dial."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.controls import CAP_LOOKS, KEY_FORMS, dial, key_cap, key_parts
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import ORIGIN, X, Y, Z, box, cylinder, facing, rotation_about, rounded_box, transform
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Keyboard whose keys slide down.

    Two feet under the rear edge fold out, and a dial turns.
    """
    columns, rows = draw.pick([(4, 4), (6, 3), (10, 4), (12, 5), (14, 5)], [3, 2, 3, 2, 1])
    pitch = 0.1
    margin = draw.between(0.02, 0.2)
    width, depth, thick = columns * pitch + 2 * margin, rows * pitch + 2 * margin, draw.between(0.04, 0.15)
    root = Node("Keyboard")
    body = root.add("base_body", rounded_box((width, thick, depth), draw.between(0.01, 0.05), "y", (0, 0.5 * thick, 0)))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC], [3, 1]))
    links = [base, *_keys(draw, root, base, columns, rows, pitch, thick)]
    if draw.chance(0.5):
        links += _feet(draw, root, base, width, depth)
    if draw.chance(0.15):
        at = (0.5 * width - 0.5 * margin, thick, -0.5 * depth + 0.5 * margin)
        knob = root.add("knob", *dial(draw, 0.4 * margin, 0.05, ORIGIN))
        links.append(Link("knob", [knob], base, spinner(ORIGIN, Z)))
        links[-1].move(facing(Y, -Z, at))
    shape = SynthObject("Keyboard", root, links)
    shape.move(rotation_about(X, draw.pick([0.0, draw.between(2.0, 10.0)])))
    return shape


def _keys(draw: Draw, root: Node, base: Link, columns: int, rows: int, pitch: float, top: float) -> list[Link]:
    """Square keys with some wide ones in the last row, of any look of keys, so that no look tells whether keys move."""
    tall, gap = draw.between(0.02, 0.09), draw.between(0.06, 0.3) * pitch
    travel = draw.between(0.3, 1.0) * tall
    look, taper = draw.pick(CAP_LOOKS, [4, 5, 2, 1, 1, 1]), draw.between(0.6, 0.95)
    form, name = draw.pick(KEY_FORMS, [5, 1, 1, 1.5]), draw.pick(["key", "button"], [3, 1])
    inwards = draw.chance(0.5)
    bar = draw.between(3.0, 6.0) if columns > 6 else 2.0
    stepped = draw.chance(0.3)
    links = []
    for row in range(rows):
        z = (row - 0.5 * (rows - 1)) * pitch
        last = row == rows - 1
        widths = [1.0] * columns if not last else [1.0, bar, *[1.0] * max(0, columns - 1 - int(np.ceil(bar)))]
        left = -0.5 * columns * pitch
        for share in widths:
            wide = share * pitch - gap
            x, low = left + 0.5 * share * pitch, top + (0.02 * (rows - 1 - row) if stepped else 0.0)
            cap = key_cap(look, wide, pitch - gap, tall, taper)
            place = facing(Y, -Z, (x, low, z))
            node = root.add(name, *(transform(piece, place) for piece in key_parts(draw, form, cap)))
            motion = slider(-Y, 0.0, travel) if inwards else slider(Y, -travel, 0.0)
            links.append(Link("button", [node], base, motion, leaf_name=name))
            left += share * pitch
    return links


def _feet(draw: Draw, root: Node, base: Link, width: float, depth: float) -> list[Link]:
    """Two feet under the rear edge that fold out to the rear or sideways."""
    links = []
    long, thick = draw.between(0.06, 0.14), draw.between(0.01, 0.02)
    rest = draw.pick([0.0, draw.between(30.0, 90.0)])
    across = draw.chance(0.8)
    for side in (-1.0, 1.0):
        at = (side * 0.4 * width, -0.5 * thick, -0.42 * depth)
        if across:
            plate, motion = box((0.12, thick, long), (at[0], at[1], at[2] + 0.5 * long)), hinge(at, X, 0.0, 90.0, rest=rest)
        else:
            plate = box((long, thick, 0.08), (at[0] - side * 0.5 * long, at[1], at[2]))
            motion = hinge(at, -side * Z, 0.0, 90.0, rest=rest)
        base.nodes[0].pieces.append(cylinder(0.6 * thick, 0.12, "x" if across else "z", at, 8))
        links.append(Link("foot", [root.add("foot", plate)], base, motion))
    return links
