"""Slabs: thin bodies, lying or standing, whose broad face has keys, pads, knobs and slides."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.controls import button
from kinmo.synth.details.posture import lay_down, turn_about_up
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.mechanisms.mount import mount
from kinmo.synth.mechanisms.sliding import cover, pusher, slot
from kinmo.synth.mechanisms.turning import flap, knob, rocker, roller, treadle
from kinmo.synth.primitives import X, Y, Z, box, facing, rotation_about, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, slider

MAX_KEYS = 40
"""Most keys of a slab."""
TILTED_CHANCE, LYING_CHANCE = 0.25, 0.6
"""Chances that a slab is tilted, and that it lies on its back for certain."""
PADS_CHANCE = 0.4
"""Chance of a few tipping pads instead of keys."""


def slab(draw: Draw, crowded: bool) -> SynthObject:
    """Slab with keys or pads, built flat with the keys on top, then laid down or stood up. A crowded one has more keys."""
    root = Node("mechanism")
    wide, long, thick = draw.between(0.2, 1.2), draw.between(0.4, 1.0), draw.between(0.02, 0.25)
    size = (wide, thick, long)
    body = box(size) if draw.chance(0.5) else rounded_box(size, draw.between(0.05, 0.4) * min(wide, long), "y")
    base = Link("body", [root.add("body", body)], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    split = draw.between(0.4, 1.0)  # share of the length with keys; other mechanisms are behind them
    middle = (0.0, 0.5 * thick, 0.5 * (1 - split) * long)
    if draw.chance(PADS_CHANCE):
        size = (wide, split * long, 0.5 * wide)
        links += mount(draw, treadle(draw), size, facing(Y, -Z, middle), root, base)
    else:
        links += mount(draw, _keyboard(draw, wide, split * long, crowded), 1.0, facing(Y, -Z, middle), root, base)
    if split < 0.85 and draw.chance(0.6):
        built = draw.pick([pusher, knob, rocker, slot, roller])(draw)
        room = min((1 - split) * long, wide)
        place = (draw.between(-0.3, 0.3) * (wide - room), 0.5 * thick, -0.5 * split * long)
        links += mount(draw, built, draw.between(0.5, 0.95) * room, facing(Y, Z, place), root, base)
    if draw.chance(0.3):
        built = draw.pick([cover, flap])(draw)
        place = (0.0, -0.5 * thick, draw.between(-0.2, 0.2) * long)
        links += mount(draw, built, draw.between(0.4, 0.8) * min(wide, long), facing(-Y, draw.pick([Z, -Z]), place), root, base)
    shape = SynthObject("Mechanism", root, links)
    if draw.chance(TILTED_CHANCE):
        shape.move(rotation_about(X, draw.between(2.0, 12.0)))
    (turn_about_up if draw.chance(LYING_CHANCE) else lay_down)(draw, shape)
    return shape


def _keyboard(draw: Draw, wide: float, high: float, crowded: bool) -> Mechanism:
    """Rows of keys on a field, some of them wide, with or without gaps."""
    rows = draw.integer(1, 6 if crowded else 3)
    pitch, share, depth = 0.95 * high / rows, draw.between(0.6, 0.97), draw.between(0.01, 0.08)
    columns = max(1, min(round(wide / (draw.between(0.6, 3.0) * pitch)), MAX_KEYS // rows))
    name, motion = draw.pick(["key", "button"]), slider(Z, -0.6 * depth, 0.0)
    above = draw.pick([0.0, draw.between(0.0, 0.6) * depth])  # keys need not touch the slab
    pressed = []
    for row in range(rows):
        edges = np.linspace(-0.475, 0.475, columns + 1) * wide
        if columns > 3 and draw.chance(0.3):  # one key is as wide as several
            first = draw.integer(0, columns - 3)
            edges = np.delete(edges, slice(first + 1, first + draw.integer(2, 3)))
        draws = draw.identical(len(edges) - 1)
        for left, right, own in zip(edges[:-1], edges[1:], draws, strict=True):
            place = (0.5 * (left + right), (row + 0.5) * pitch - 0.475 * high, above)
            pressed.append(MovingPart(name, [button(own, share * (right - left), share * pitch, depth, place)], motion))
    rim = []
    if draw.chance(0.3):
        tall = draw.between(0.3, 1.0) * (depth + above)
        rim = [box((0.02, high, tall), (s * 0.49 * wide, 0, 0.5 * tall)) for s in (-1, 1)]
        rim += [box((wide, 0.02, tall), (0, s * 0.49 * high, 0.5 * tall)) for s in (-1, 1)]
    return Mechanism(pressed, rim)
