"""Laptops whose screen side turns about a line near the rear edge of the base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.resting_details import add_resting, key_caps
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    box,
    box_between,
    cylinder,
    ellipsoid,
    facing,
    move,
    rounded_box,
    rounded_path,
    sheet,
    sweep,
    transform,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge

KEY_HEIGHT = 0.01
"""Largest height of keys above the base."""


@dataclass(frozen=True)
class _Plan:
    """Sizes of one laptop. The hinge line runs along x at (`hinge_y`, `hinge_z`), and the base stands on y = 0."""

    width: float
    depth: float
    thickness: float
    hinge_y: float
    hinge_z: float
    screen_thickness: float
    screen_front: float
    screen_bottom: float
    screen_top: float


def build(draw: Draw) -> SynthObject:
    """Laptop, built with the screen upright.

    Most have one or two visible shafts on the hinge line. Keys, touchpad buttons, ports, grilles, stickers, screws and feet
    rest on the base. A rare variant has a mouse beside it, marked as junk.
    """
    plan = _plan(draw)
    root = Node("laptop")
    screen_side, base_side = root.add("screen_side"), root.add("base_side")
    _fill_screen_side(draw, plan, screen_side)
    _fill_base_side(draw, plan, base_side)
    moving, still = [screen_side], [base_side]
    if draw.chance(0.75):
        connector = root.add("connector")
        _add_shafts(draw, plan, connector)
        (moving if draw.chance(0.75) else still).append(connector)
    if draw.chance(0.2):
        feet = root.add("other")
        feet.add("other_leaf", *_feet(plan, draw.between(0.02, 0.06)))
        still.append(feet)
    if draw.chance(0.12):
        size = plan.width * draw.between(0.05, 0.2)
        middle = 0.5 * (plan.screen_bottom + plan.screen_top)
        logo = root.add("other")
        logo.add("other_leaf", box((size, size, 0.004), (0.0, middle, plan.screen_front - plan.screen_thickness)))
        moving.append(logo)
    if draw.chance(0.6):
        still += _base_details(draw, plan, root.add("other"))
    if draw.chance(0.3):
        moving += _screen_details(draw, plan, root.add("other"))
    base = Link("base_side", still, kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    tilt = draw.pick([draw.between(2.0, 45.0), draw.between(-85.0, 2.0), -90.0, 80.0], [0.84, 0.08, 0.06, 0.02])
    origin = (draw.between(-0.5, 0.5) * plan.width, plan.hinge_y, plan.hinge_z)
    back = max(draw.pick([0.0, 30.0, 45.0, 80.0]), tilt)
    screen = Link(draw.pick(["screen_side", "shaft", "screen"]), moving, base, hinge(origin, X, -back, 90.0, rest=-tilt))
    links = [base, screen]
    if draw.chance(0.08):
        links.append(Link("other_leaf", [_mouse(draw, plan, root.add("other"))], kind=JointType.JUNK))
    return SynthObject("Laptop", root, links)


def _plan(draw: Draw) -> _Plan:
    """Random sizes with which the closed screen lies above the base."""
    width = draw.between(1.0, 1.7)
    depth = draw.between(0.78, 1.05)
    thickness = draw.between(0.025, 0.11) if draw.chance(0.92) else draw.between(0.11, 0.22)
    screen_thickness = draw.between(0.012, 0.06)
    hinge_z = -0.5 * depth + draw.between(-0.01, 0.07) * depth
    # The closed screen needs room above the base: a lower hinge needs a screen further back.
    hinge_y = thickness * draw.between(0.45, 1.35)
    above = hinge_y - thickness - KEY_HEIGHT
    forward = above > 0.0 and draw.chance(0.5)
    screen_front = hinge_z + min(screen_thickness, above) if forward else hinge_z + min(above, 0.0) - draw.between(0.0, 0.01)
    behind = screen_front < -0.5 * depth
    screen_bottom = thickness * draw.between(0.2, 1.0) if behind else max(thickness, hinge_y - 0.5 * screen_thickness)
    screen_bottom += draw.between(0.0, 0.015)
    height = depth * draw.between(0.9, 1.02)
    return _Plan(
        width, depth, thickness, hinge_y, hinge_z, screen_thickness, screen_front, screen_bottom, screen_bottom + height
    )


def _fill_screen_side(draw: Draw, plan: _Plan, screen_side: Node) -> None:
    """Add the screen, its frame and a camera."""
    width = plan.width * draw.between(0.97, 1.0)
    height = plan.screen_top - plan.screen_bottom
    middle = 0.5 * (plan.screen_bottom + plan.screen_top)
    bezel = draw.between(0.02, 0.09)
    chin = bezel * draw.between(1.0, 2.0)
    pane = (width - 2 * bezel, height - bezel - chin)
    pane_middle = middle + 0.5 * (chin - bezel)
    recess = draw.pick([0.0, 0.003, -0.004])
    screen_at = plan.screen_front - recess
    screen = sheet((pane[0], pane[1]), (0.0, pane_middle, screen_at), axis="z")
    if draw.chance(0.6):
        screen = box((*pane, 0.3 * plan.screen_thickness), (0.0, pane_middle, screen_at - 0.15 * plan.screen_thickness))
    screen_side.add("screen", screen)
    back_thickness = 0.7 * plan.screen_thickness
    back_at = plan.screen_front - plan.screen_thickness + 0.5 * back_thickness
    back = rounded_box((width, height, back_thickness), draw.between(0.005, 0.06), "z", (0.0, middle, back_at))
    frame = [back]
    low, high = plan.screen_front - plan.screen_thickness + back_thickness, plan.screen_front
    for side in (-1.0, 1.0):
        edge, inner = side * 0.5 * width, side * (0.5 * width - bezel)
        frame.append(box_between((min(edge, inner), plan.screen_bottom, low), (max(edge, inner), plan.screen_top, high)))
    half = 0.5 * width - bezel
    frame.append(box_between((-half, plan.screen_bottom, low), (half, plan.screen_bottom + chin, high)))
    frame.append(box_between((-half, plan.screen_top - bezel, low), (half, plan.screen_top, high)))
    screen_side.add("screen_frame", *(frame if draw.chance(0.85) else frame[:1]))
    if draw.chance(0.3):
        at = (0.0, plan.screen_top - 0.5 * bezel, plan.screen_front)
        screen_side.add("camera", draw.pick([ellipsoid((0.012, 0.012, 0.006), at), box((0.05, 0.02, 0.01), at)]))


def _fill_base_side(draw: Draw, plan: _Plan, base_side: Node) -> None:
    """Add the base, the keyboard and a touchpad."""
    top = plan.thickness
    frame = [rounded_box((plan.width, top, plan.depth), draw.between(0.005, 0.08), "y", (0.0, 0.5 * top, 0.0))]
    keys_depth = plan.depth * draw.between(0.32, 0.45)
    keys_middle = -0.5 * plan.depth + 0.1 * plan.depth + 0.5 * keys_depth
    keys_width = plan.width * draw.between(0.78, 0.94)
    if draw.chance(0.25):
        frame = _base_with_well(plan, keys_width, keys_depth, keys_middle, draw.between(0.3, 0.9) * top)
    if draw.chance(0.25):
        frame += _feet(plan, draw.between(0.02, 0.06))
    _add_keyboard(draw, base_side, keys_width, keys_depth, top, keys_middle)
    if draw.chance(0.85):
        front = keys_middle + 0.5 * keys_depth
        pad_depth = (0.5 * plan.depth - front) * draw.between(0.5, 0.75)
        pad_width = plan.width * draw.between(0.15, 0.35)
        middle = front + 0.5 * (0.5 * plan.depth - front)
        touchpad, proud = base_side.add("touchpad"), draw.pick([0.004, 0.0015, 0.008])
        aside = draw.pick([0.0, draw.between(-0.15, 0.1) * plan.width], [3, 1])
        pad = box((pad_width, proud, pad_depth), (0.0, top, middle))
        if draw.chance(0.3):
            pad = rounded_box((pad_width, proud, pad_depth), draw.between(0.01, 0.05), "y", (0.0, top, middle))
        touchpad.add("touchpad_surface", move(pad, (aside, 0.0, 0.0)))
        buttons = draw.integer(0, 3)
        for index in range(buttons):
            wide = pad_width / buttons * 0.96
            x = aside + (index - 0.5 * (buttons - 1)) * pad_width / buttons
            touchpad.add("button", box((wide, 0.008, 0.2 * pad_depth), (x, top, middle + 0.62 * pad_depth)))
    base_side.add("base_frame", *frame)


def _base_with_well(plan: _Plan, width: float, depth: float, middle: float, floor: float) -> list[Mesh]:
    """Pieces of a base with a well for the keys, whose floor is at the height `floor`."""
    x, z, top, half = 0.5 * plan.width, 0.5 * plan.depth, plan.thickness, 0.51 * width
    rear, front = middle - 0.52 * depth, middle + 0.52 * depth
    return [
        box_between((-x, 0.0, -z), (x, floor, z)),
        box_between((-x, floor, -z), (x, top, rear)),
        box_between((-x, floor, front), (x, top, z)),
        box_between((-x, floor, rear), (-half, top, front)),
        box_between((half, floor, rear), (x, top, front)),
    ]


def _add_keyboard(draw: Draw, base_side: Node, width: float, depth: float, top: float, middle: float) -> None:
    """Add the keyboard: one block, or rows of loose keys, each a piece of one leaf or a leaf of its own."""
    height = draw.between(0.4, 1.0) * KEY_HEIGHT
    if draw.chance(0.15):
        base_side.add("keyboard", box((width, height, depth), (0.0, top + 0.5 * height, middle)))
        return
    # Tall keys stand deeper, so that the closed screen clears them.
    tall = height * draw.pick([1.0, draw.between(1.0, 3.0)], [2, 1])
    place = facing(Y, -Z, (0.0, top + height - tall, middle))
    keys = [[transform(piece, place) for piece in key] for key in key_caps(draw, width, depth, tall)]
    if draw.chance(0.25):
        keys.append([box((1.03 * width, 0.2 * height, 1.06 * depth), (0.0, top, middle))])
    if draw.chance(0.5):
        base_side.add("keyboard", *(piece for key in keys for piece in key))
        return
    keyboard, name = base_side.add("keyboard"), draw.pick(["key", "button", "other_leaf"], [4, 1, 1])
    for key in keys:
        keyboard.add(name, *key)


def _base_details(draw: Draw, plan: _Plan, above: Node) -> list[Node]:
    """Leaves of ports at the sides, and of grilles, stickers, lamps, keys, screws and feet on the upper and lower face."""
    x, top, z = 0.5 * plan.width, plan.thickness, 0.5 * plan.depth
    nodes: list[Node] = []
    for side in (-1.0, 1.0):
        count, size = draw.integer(0, 5), min(draw.between(0.03, 0.08), 1.5 * top)
        line = np.linspace(draw.between(-0.8, -0.3), draw.between(0.2, 0.7), count) * z
        frames = [facing(side * X, Y, (side * x, 0.5 * top, at)) for at in line]
        nodes += add_resting(draw, above, "port", size, frames, alike=False) if frames else []

    def upper(right: float, rear: float) -> np.ndarray:
        return facing(Y, -Z, (right * x, top, -rear * z))

    def lower(right: float, rear: float) -> np.ndarray:
        return facing(-Y, Z, (right * x, 0.0, -rear * z))

    corners = [(i, j) for i in (-0.85, 0.85) for j in (-0.85, 0.85)]
    places_of = {
        "grille": [upper(i, 0.4) for i in (-0.94, 0.94)] if draw.chance(0.5) else [upper(draw.between(-0.3, 0.3), 0.9)],
        "sticker": [upper(draw.pick([-0.75, 0.75]) + 0.1 * i, -draw.between(0.5, 0.8)) for i in range(draw.integer(1, 3))],
        "lamp": [upper(draw.between(-0.8, 0.4) + 0.05 * i, draw.pick([-0.93, 0.92])) for i in range(draw.integer(1, 5))],
        "key": [upper(draw.between(-0.9, 0.6) + 0.07 * i, 0.91) for i in range(draw.integer(1, 5))],
        "screw": [lower(*at) for at in (*corners, (0.0, 0.85), (0.0, -0.85), (-0.4, 0.0), (0.4, 0.0))[: draw.integer(4, 8)]],
        "foot": [lower(0.98 * i, 0.9 * j) for i, j in corners],
    }
    sizes = {"grille": (0.04, 0.07), "sticker": (0.05, 0.15), "lamp": (0.01, 0.03), "key": (0.02, 0.05)}
    for kind, places in places_of.items():
        if draw.chance(0.4):
            nodes += add_resting(draw, above, kind, draw.between(*sizes.get(kind, (0.02, 0.06))), places)
    return nodes or add_resting(draw, above, "sticker", 0.1, [upper(-0.8, -0.7)])


def _screen_details(draw: Draw, plan: _Plan, above: Node) -> list[Node]:
    """Leaves of bumpers, lamps or a sticker on the frame of the screen."""
    half, low, high = 0.44 * plan.width, plan.screen_bottom + 0.02, plan.screen_top - 0.015
    if draw.chance(0.5):
        spots = [(s * half, y) for s in (-1.0, 1.0) for y in (low, high)] + ([(0.3 * half, high)] if draw.chance(0.5) else [])
        kind = draw.pick(["foot", "screw"])
    else:
        kind, at = draw.pick(["sticker", "lamp", "grille"]), draw.between(-0.3, 0.3) * half
        spots = [(at, low)] if kind != "lamp" else [(at + 0.05 * i, low) for i in range(draw.integer(1, 4))]
    size = draw.between(0.012, 0.03)
    return add_resting(draw, above, kind, size, [facing(Z, Y, (x, y, plan.screen_front)) for x, y in spots])


def _add_shafts(draw: Draw, plan: _Plan, connector: Node) -> None:
    """Add one long shaft or two short ones on the hinge line."""
    radius = draw.between(0.25, 0.6) * plan.thickness
    if draw.chance(0.5):
        shafts = [(0.0, plan.width * draw.between(0.3, 0.95))]
    else:
        offset = plan.width * draw.between(0.25, 0.42)
        shafts = [(side * offset, plan.width * draw.between(0.04, 0.14)) for side in (-1.0, 1.0)]
    is_round = draw.chance(0.75)
    for x, length in shafts:
        at = (x, plan.hinge_y, plan.hinge_z)
        reach = (length, 2 * radius, 2.5 * radius)
        connector.add("shaft", cylinder(radius, length, "x", at, 14) if is_round else box(reach, at))


def _feet(plan: _Plan, size: float) -> list[Mesh]:
    """Four round feet."""
    places = [(x * 0.42 * plan.width, z * 0.4 * plan.depth) for x in (-1, 1) for z in (-1, 1)]
    return [cylinder(size, 0.015, "y", (x, -0.0075, z), 12) for x, z in places]


def _mouse(draw: Draw, plan: _Plan, other: Node) -> Node:
    """A mouse with its cable, beside the laptop."""
    x, z = 0.5 * plan.width + draw.between(0.15, 0.3), draw.between(-0.1, 0.3)
    body = turn(ellipsoid((0.07, 0.04, 0.12)), Y, draw.between(-25.0, 25.0))
    path = rounded_path(
        np.array([(x, 0.03, z - 0.1), (x, 0.01, z - 0.3), (x - 0.1, 0.01, z - 0.4), (x - 0.05, 0.01, z - 0.6)]), 0.1
    )
    return other.add("other_leaf", move(body, (x, 0.03, z)), sweep(rounded_path(path, 0.1), 0.006, 6))
