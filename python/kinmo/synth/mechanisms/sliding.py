"""Mechanisms that slide or screw: drawers, buttons, telescopes, caps, carriages, slots, panes, drawbars and cords."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.controls import button, grid_places
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MovingPart
from kinmo.synth.mechanisms.turning import post_top
from kinmo.synth.primitives import X, Y, Z, box, cylinder, move, rounded_box, rounded_path, sweep, tube
from kinmo.synth.synth_object import Motion, hinge, screw, slider, spinner


def drawer(draw: Draw) -> Mechanism:
    """Tray or block that slides out of a housing."""
    wide, high, deep = draw.between(0.4, 0.9), draw.between(0.15, 0.8), draw.between(0.3, 1.0)
    wall = 0.025
    sides = [box((wall, high, deep), (s * 0.5 * (wide + wall), 0, 0.5 * deep)) for s in (-1, 1)]
    sides += [box((wide + 2 * wall, wall, deep), (0, s * 0.5 * (high + wall), 0.5 * deep)) for s in (-1, 1)]
    inner = (0.96 * wide, 0.94 * high, draw.between(0.6, 0.95) * deep)
    middle = deep - 0.5 * inner[2]
    if draw.chance(0.6):
        pieces = [box((inner[0], 0.02, inner[2]), (0, -0.5 * inner[1], middle))]
        pieces += [box((0.02, 0.6 * inner[1], inner[2]), (s * 0.49 * inner[0], -0.2 * inner[1], middle)) for s in (-1, 1)]
    else:
        pieces = [box(inner, (0, 0, middle))]
    pieces.append(box((wide, high, 0.04), (0, 0, deep + 0.02)))
    if draw.chance(0.6):
        pieces += pull(draw, 0.4 * wide, (0, 0, deep + 0.04), vertical=draw.chance(0.2))
    travel = draw.between(0.4, 0.9) * inner[2]
    motion = slider(Z, 0.0, travel, rest=draw.pick([0.0, draw.between(0.0, 0.9) * travel]))
    return Mechanism([MovingPart(draw.pick(["drawer", "tray", "box"]), pieces, motion)], sides)


def pusher(draw: Draw) -> Mechanism:
    """Button that is pressed in."""
    depth = draw.between(0.05, 0.4)
    pressed = button(draw, draw.between(0.2, 0.8), draw.between(0.2, 0.8), depth, (0, 0, 0))
    return Mechanism([MovingPart(draw.pick(["button", "key", "press"]), [pressed], slider(Z, -0.6 * depth, 0.0))])


def keys(draw: Draw) -> Mechanism:
    """Block of equal keys that are pressed in."""
    columns, rows = draw.pick([draw.integer(2, 4), draw.integer(2, 6)]), draw.pick([1, 2, 3, 4], [4, 3, 2, 1])
    wide, high = draw.between(0.5, 1.0), draw.between(0.3, 0.9)
    share, depth = draw.between(0.6, 0.95), draw.between(0.03, 0.15)
    places, draws = grid_places(columns, rows, wide, high), draw.identical(columns * rows)
    name = draw.pick(["key", "button"])
    motion = slider(Z, -0.6 * depth, 0.0)
    pressed = [
        button(own, share * wide / columns, share * high / rows, depth, (*place, 0.0))
        for own, place in zip(draws, places, strict=True)
    ]
    fixed = []
    if draw.chance(0.3):  # a wall behind the keys, which does not touch them
        deep, tall, clear = draw.between(0.1, 0.4), draw.between(0.8, 3.0) * depth, draw.between(0.02, 0.06)
        fixed.append(box((wide, deep, tall), (0, 0.5 * (high + deep) + clear, 0.5 * tall)))
    return Mechanism([MovingPart(name, [piece], motion) for piece in pressed], fixed)


def telescope(draw: Draw) -> Mechanism:
    """Rod or tube in a tube that slides, screws or turns, sometimes with a second stage or a head."""
    outer, long = draw.between(0.05, 0.4), draw.between(0.3, 1.0)
    sleeve = tube(outer, 0.85 * outer, long, "z", (0, 0, 0.5 * long), draw.pick([16, 24]))
    out = draw.between(0.1, 0.8) * long
    inner = cylinder(0.8 * outer, long, "z", (0, 0, 0.5 * long + out), 16)
    first = MovingPart(draw.pick(["column", "lens", "rod", "tube"]), [inner], _tube_motion(draw, long, out))
    moving = [first]
    if draw.chance(0.25):
        further = cylinder(0.6 * outer, long, "z", (0, 0, 0.5 * long + 1.6 * out), 16)
        moving.append(MovingPart("tube", [further], _tube_motion(draw, long, 0.6 * out), first))
    elif draw.chance(0.4):
        head = [move(piece, (0, 0, long + out)) for piece in post_top(draw)]
        moving[0] = MovingPart(first.name, [inner, *head], first.motion)
    return Mechanism(moving, [sleeve])


def sheath(draw: Draw) -> Mechanism:
    """Sleeve on a rod or blade that stands on the mount; it slides off."""
    long, wide, thick = draw.between(0.5, 1.1), draw.between(0.06, 0.4), draw.between(0.04, 0.2)
    covered = draw.between(0.3, 0.8) * long
    if draw.chance(0.5):
        core = cylinder(0.4 * wide, long, "z", (0, 0, 0.5 * long), 16)
        sleeve = [tube(0.5 * wide, 0.42 * wide, covered, "z", (0, 0, long - 0.45 * covered), 20)]
    else:
        core = box((0.8 * wide, 0.5 * thick, long), (0, 0, 0.5 * long))
        middle = long - 0.45 * covered
        sleeve = [box((wide, 0.2 * thick, covered), (0, s * 0.4 * thick, middle)) for s in (-1, 1)]
        sleeve += [box((0.08 * wide, 0.6 * thick, covered), (s * 0.46 * wide, 0, middle)) for s in (-1, 1)]
    return Mechanism([MovingPart(draw.pick(["sheath", "cap", "cover"]), sleeve, slider(Z, 0.0, covered))], [core])


def cap(draw: Draw) -> Mechanism:
    """Cap on a neck that screws, slides, turns or tips."""
    radius, neck, high = draw.between(0.15, 0.42), draw.between(0.05, 0.5), draw.between(0.08, 0.5)
    collar = cylinder(0.9 * radius, neck, "z", (0, 0, 0.5 * neck), 24)
    lid = cylinder(
        radius, high, "z", (0, 0, neck + 0.5 * high), draw.pick([16, 24, 32]), top_radius=draw.between(0.7, 1.0) * radius
    )
    if draw.chance(0.3):
        lid = rounded_box((2 * radius, 1.6 * radius, high), 0.3 * radius, "z", (0, 0, neck + 0.5 * high))
    pieces = [lid]
    if draw.chance(0.4):
        pieces += pull(draw, radius, (0, 0, neck + high), vertical=False)
    kind = draw.pick(["screw", "slide", "turn", "tip"], [3, 3, 2, 2])
    motion = {
        "screw": screw((0, 0, 0), Z, 0.0, high, turns=draw.pick([None, 360.0])),
        "slide": slider(Z, 0.0, high),
        "turn": spinner((0, 0, 0), Z),
        "tip": hinge((-radius, 0, neck), -Y, 0.0, draw.between(60.0, 120.0)),
    }[kind]
    return Mechanism([MovingPart(draw.pick(["lid", "cap", "closure"]), pieces, motion)], [collar])


def carriage(draw: Draw) -> Mechanism:
    """Block that slides along rails."""
    apart, size = draw.between(0.1, 0.6), draw.between(0.12, 0.4)
    height = draw.between(0.04, 0.3)
    thick = draw.between(0.02, 0.06)
    rails = [cylinder(thick, 0.96, "x", (0, s * 0.5 * apart, height), 10) for s in ((-1, 1) if draw.chance(0.7) else (0,))]
    ends = [box((0.05, apart + 0.15, height + 0.08), (s * 0.48, 0, 0.5 * height + 0.04)) for s in (-1, 1)]
    at = draw.between(-1.0, 1.0) * (0.42 - 0.5 * size)
    block = box((size, apart + 0.12, draw.between(0.1, 0.4)), (at, 0, height + 0.06))
    pieces = [block]
    if draw.chance(0.4):
        pieces.append(box((0.3 * size, 0.1, 0.4), (at, 0, height + 0.3)))
    motion = slider(X * draw.sign(), -(0.4 - 0.5 * size), 0.4 - 0.5 * size)
    return Mechanism([MovingPart(draw.pick(["carriage", "block"]), pieces, motion)], [*rails, *ends])


def slot(draw: Draw) -> Mechanism:
    """Tab that slides along a slot, between two plates or thin edges."""
    gap, slit = draw.between(0.03, 0.12), draw.chance(0.4)
    wide, thick = (0.02, draw.between(0.005, 0.02)) if slit else (draw.between(0.1, 0.3), draw.between(0.04, 0.2))
    plates = [box((wide, 0.95, thick), (s * 0.5 * (gap + wide), 0, 0.5 * thick)) for s in (-1, 1)]
    high = draw.between(0.06, 0.25)
    at = draw.between(-0.3, 0.3)
    pieces = [box((draw.between(1.5, 5.0) * gap, high, draw.between(0.06, 0.2)), (0, at, thick + 0.06))]
    if draw.chance(0.5):
        pieces.append(box((0.8 * gap, 0.6 * high, thick), (0, at, 0.5 * thick)))
    motion = slider(Y * draw.sign(), -0.3, 0.3)
    return Mechanism([MovingPart(draw.pick(["slider", "lever", "button", "latch"]), pieces, motion)], plates)


def pane(draw: Draw) -> Mechanism:
    """Pane that slides between two rails, sometimes next to a fixed pane."""
    high, wide, thick = draw.between(0.4, 0.8), draw.between(0.35, 0.55), draw.between(0.015, 0.05)
    height = draw.between(0.02, 0.1)
    rails = [box((0.98, 0.05, height + 0.08), (0, s * (0.5 * high + 0.02), 0.5 * height + 0.04)) for s in (-1, 1)]
    side = draw.sign()
    at = side * 0.5 * (0.96 - wide)
    sliding = [box((wide, high, thick), (at, 0, height))]
    if draw.chance(0.5):
        sliding += pull(draw, 0.25 * high, (at - side * 0.4 * wide, 0, height + 0.5 * thick), vertical=True)
    if draw.chance(0.5):
        rails.append(box((wide, high, thick), (-at, 0, height - 1.5 * thick)))
    motion = slider(X * -side, 0.0, 0.96 - wide)
    return Mechanism([MovingPart(draw.pick(["door", "pane", "window", "shutter"]), sliding, motion)], rails)


def drawbar(draw: Draw) -> Mechanism:
    """Bow or bar on one or two rods that slide out of the mount or out of sleeves on it."""
    half, out, inside = draw.between(0.1, 0.45), draw.between(0.1, 0.9), draw.between(0.1, 0.6)
    thick, bowed = draw.between(0.02, 0.06), draw.chance(0.7)
    rods = (-half, half) if bowed else (0.0,)
    if bowed:
        corners = [(-half, 0, -inside), (-half, 0, out), (half, 0, out), (half, 0, -inside)]
        pieces = [sweep(rounded_path(np.array(corners), 0.3 * half), thick, draw.pick([4, 8]))]
    else:
        pieces = [cylinder(thick, inside + out, "z", (0, 0, 0.5 * (out - inside)))]
        pieces.append(box((2 * half, 2.5 * thick, 2.5 * thick), (0, 0, out)))
    sleeves = [tube(1.5 * thick, 1.2 * thick, 0.3 * out, "z", (x, 0, 0.15 * out)) for x in rods]
    motion = slider(Z, -0.9 * out if draw.chance(0.5) else 0.0, 0.8 * inside)
    return Mechanism([MovingPart(draw.pick(["handle", "bar", "frame"], [3, 1, 1]), pieces, motion)], draw.pick([sleeves, []]))


def cord(draw: Draw) -> Mechanism:
    """Thin rod, plug or bolt that is pulled out of the mount, or slides through two eyes."""
    long, thin = draw.between(0.3, 1.0), draw.between(0.01, 0.05)
    if draw.chance(0.5):
        rod = sweep(np.array([(0, 0, -0.1), (0, 0, long)]), thin, 8)
        return Mechanism([MovingPart(draw.pick(["cord", "plug", "pin"]), [rod], slider(Z, -0.1, 0.3))])
    height = thin + 0.05
    bolt = sweep(np.array([(-0.4, 0, height), (-0.4 + 0.8 * long, 0, height)]), thin, 8)
    eyes = [box((0.06, 4 * thin + 0.04, height + 2 * thin), (x, 0, 0.5 * height)) for x in (-0.25, 0.3 * long)]
    return Mechanism([MovingPart(draw.pick(["bolt", "latch", "rod"]), [bolt], slider(X, -0.2, 0.3))], eyes)


def cover(draw: Draw) -> Mechanism:
    """Plate that lies on the mount and slides along it, sometimes between low lips."""
    wide, high, thick = draw.between(0.3, 0.9), draw.between(0.3, 0.6), draw.between(0.02, 0.1)
    at, level = draw.between(-0.3, 0.3) * (1 - high), draw.between(0.0, 0.05) + 0.5 * thick
    plate = box((wide, high, thick), (0, at, level))
    pieces = [plate if draw.chance(0.6) else rounded_box((wide, high, thick), 0.2 * high, "z", (0, at, level))]
    if draw.chance(0.4):
        pieces.append(box((0.4 * wide, 0.06 * high, 1.5 * thick), (0, at + draw.between(-0.35, 0.35) * high, level + thick)))
    lips = [box((0.04, 0.96, level + 0.6 * thick), (s * (0.5 * wide + 0.02), 0, 0.5 * level + 0.3 * thick)) for s in (-1, 1)]
    travel = draw.between(0.3, 0.9) * high
    motion = slider(Y * draw.sign(), 0.0, travel)
    return Mechanism([MovingPart(draw.pick(["lid", "cover", "slider", "shutter"]), pieces, motion)], draw.pick([lips, []]))


def spindle(draw: Draw) -> Mechanism:
    """Rod through a bridge with a plate below and a handle on top, sometimes a loose bar. It screws or slides."""
    high, radius = draw.between(0.4, 0.8), draw.between(0.02, 0.07)
    wide, thick = draw.between(0.3, 0.9), draw.between(0.06, 0.15)
    one_sided = draw.chance(0.5)
    bridge = [box((wide if not one_sided else 0.5 * wide + 0.1, thick, thick), (-0.25 * wide * one_sided, 0, high))]
    bridge += [box((thick, thick, high), (s * 0.5 * wide, 0, 0.5 * high)) for s in ((-1,) if one_sided else (-1, 1))]
    low, top = draw.between(0.05, 0.7) * high, high + draw.between(0.1, 0.4)
    pieces = [cylinder(radius, top - low, "z", (0, 0, 0.5 * (low + top)), 12)]
    pieces.append(cylinder(draw.between(1.2, 3.0) * radius, 0.04, "z", (0, 0, low), 16))
    kind = draw.pick(["bar", "loose bar", "wheel", "knob"])
    half, across = draw.between(0.08, 0.2), draw.pick([X, Y])
    bar = sweep(np.array([-half * across, half * across]) + Z * top, 0.4 * radius, 8)
    if kind == "bar":
        pieces.append(bar)
    elif kind == "loose bar":
        pieces.append(cylinder(1.5 * radius, 3 * radius, "z", (0, 0, top), 16))
    else:
        pieces.append(cylinder(draw.between(0.06, 0.2) if kind == "wheel" else 2 * radius, 0.05, "z", (0, 0, top), 20))
    bounds = -0.5 * low, 0.5 * low
    motion = slider(Z, *bounds) if draw.chance(0.25) else screw((0, 0, 0), Z * draw.sign(), *bounds)
    moving = [MovingPart(draw.pick(["screw", "rod", "spindle"]), pieces, motion)]
    if kind == "loose bar":  # the bar slides in the head
        moving.append(
            MovingPart(draw.pick(["bar", "lever", "handle"]), [bar], slider(across, -0.8 * half, 0.8 * half), moving[0])
        )
    return Mechanism(moving, bridge)


def _tube_motion(draw: Draw, long: float, out: float) -> Motion:
    """Joint of a tube in a tube: mostly a slider, sometimes a screw or a hinge."""
    kind = draw.pick(["slide", "screw", "turn"], [5, 2, 2])
    if kind == "turn":
        return spinner((0, 0, 0), Z)
    bounds = (-0.9 * out, 0.8 * (long - out))
    return slider(Z, *bounds) if kind == "slide" else screw((0, 0, 0), Z, *bounds, turns=draw.pick([None, 180.0]))


STRETCHABLE_SLIDING = (drawer, keys, carriage, slot, pane)
"""Mechanisms that may be stretched to fill a side."""
SLIDING = (
    *(drawer, drawer, pusher, keys, telescope, sheath, cap, carriage),
    *(slot, slot, pane, drawbar, cord, spindle, cover),
)
"""All sliding mechanisms. Frequent ones are listed more than once."""
