"""Wall switches: rockers, toggles, sliders, dials or buttons on a plate."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, box, box_between, cylinder, extrude, rounded_box
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Plate with one to four equal controls.

    Rockers and toggles tip about a line across their middle, or rarely about an edge. Sliders and buttons slide, and dials
    turn.
    """
    cell, height, thickness = draw.between(0.45, 0.9), draw.between(0.9, 1.3), draw.between(0.06, 0.25)
    count = draw.pick([1, 2, 3, 4], [4, 4, 2, 1])
    stacked = count > 1 and draw.chance(0.25)
    cell = max(cell, 0.5) if count > 1 else cell * draw.between(1.0, 1.6)
    width = cell if stacked else cell * count
    body = Node("base_body")
    base = Link("base_body", [body], kind=draw.pick([JointType.STATIC, JointType.FREE], [3, 1]))
    links = [base]
    share = draw.between(0.5, 0.85)
    kind = draw.pick(["rocker", "toggle", "slider", "dial", "button"], [6, 3, 1, 1, 1])
    for index in range(count):
        place = (index - 0.5 * (count - 1)) / count
        x, y = (0.0, -place * height) if stacked else (place * width, 0.0)
        room = (share * cell, share * height / count) if stacked else (share * cell, share * height)
        name, pieces, motion = _control(draw, kind, room, (x, y, thickness))
        links.append(Link(name, [Node("switch", pieces=pieces)], base, motion))
        if kind in ("rocker", "slider") and draw.chance(0.6):
            body.pieces += _rim(room, (x, y, thickness), draw.between(0.01, 0.04))
    radius = draw.between(0.0, 0.2) * min(width, height)
    plate = rounded_box((width, height, thickness), max(radius, 0.005), "z", (0, 0, 0.5 * thickness), draw.pick([3, 6]))
    body.pieces.insert(0, plate)
    if draw.chance(0.3):
        body.pieces.append(rounded_box((1.05 * width, 1.05 * height, 0.4 * thickness), radius, "z", (0, 0, 0.2 * thickness)))
    if draw.chance(0.4):
        body.pieces += [cylinder(0.025, 0.015, "z", (0, s * 0.43 * height, thickness), 12) for s in (-1, 1)]
    return SynthObject.flat("Switch", links)


def _control(
    draw: Draw, kind: str, room: tuple[float, float], at: tuple[float, float, float]
) -> tuple[str, list[Mesh], Motion]:
    """One control on the plate.

    Args:
        draw: Source of all random values.
        kind: "rocker", "toggle", "slider", "dial" or "button".
        room: Width and height of the control.
        at: Centre [3] on the plate.

    Returns:
        Name of the link, pieces, and joint.
    """
    x, y, z = at
    width, height = room
    if kind == "rocker":
        return "toggle_button", *_rocker(draw, width, height, at)
    if kind == "toggle":
        return "toggle_button", *_toggle(draw, min(width, height), at)
    if kind == "slider":
        travel = 0.35 * height
        return "slider", [box((0.5 * width, 0.15 * height, 0.08), (x, y, z + 0.04))], slider(Y, -travel, travel)
    if kind == "dial":
        radius = 0.35 * min(width, height)
        pieces = dial(draw, radius, radius * draw.between(0.2, 0.6), at)
        origin = (x, y, draw.pick([0.0, z]))
        return "knob", pieces, spinner(origin, (0, 0, 1)) if draw.chance(0.6) else hinge(origin, (0, 0, 1), 0.0, 270.0)
    depth = draw.between(0.02, 0.06)
    return "button", [button(draw, 0.6 * width, 0.5 * height, depth, at)], slider((0, 0, -1), 0.0, 0.7 * depth)


def _rocker(draw: Draw, width: float, height: float, at: tuple[float, float, float]) -> tuple[list[Mesh], Motion]:
    """A broad cap that tips about its middle, or rarely about an edge: flat, wedged or hollow."""
    x, y, z = at
    sunk, proud = draw.pick([0.0, draw.between(0.0, 0.05)], [1, 2]), draw.between(0.03, 0.12)
    # The cap tips along its longer side.
    upright = height > draw.between(0.8, 1.1) * width
    long = height if upright else width
    kind = draw.pick(["flat", "wedge", "hollow"])
    if kind == "flat":
        shape = rounded_box((width, height, proud + sunk), draw.between(0.001, 0.05), "z", (x, y, z + 0.5 * (proud - sunk)))
        pieces = [shape]
    else:
        middle = draw.between(1.2, 2.0) if kind == "wedge" else draw.between(0.4, 0.9)
        profile = np.array([[0.5, -sunk], [0.5, proud], [0.0, middle * proud], [-0.5, proud], [-0.5, -sunk]]) * (long, 1.0)
        if upright:
            pieces = [extrude(profile + np.array([y, z]), width, "x", (x, 0, 0))]
        else:
            pieces = [extrude(profile[:, ::-1] + np.array([z, x]), height, "y", (0, y, 0))]
    if draw.chance(0.25):
        pieces.append(box((0.15 * width, 0.04 * height, 0.01), (x, y + 0.3 * height, z + proud)))
    # The swing ends where the low edge meets the plate.
    swing = min(draw.between(3.0, 18.0), float(np.degrees(np.arctan2(proud + 0.5 * sunk, 0.5 * long))))
    axis = X if upright else Y
    deep = z + draw.pick([0.0, draw.between(-0.5, 0.3)]) * proud
    rest = draw.pick([0.0, draw.sign() * swing], [1, 2])
    if draw.chance(0.1):
        # A paddle is hinged at its upper or left edge.
        edge = (0.0, y + 0.5 * height, deep) if upright else (x - 0.5 * width, 0.0, deep)
        return pieces, hinge(edge, axis, 0.0, swing)
    return pieces, hinge((x if draw.chance(0.6) else 0.0, y, deep), axis, -swing, swing, rest=rest)


def _toggle(draw: Draw, size: float, at: tuple[float, float, float]) -> tuple[list[Mesh], Motion]:
    """A small stick through the plate that tips."""
    x, y, z = at
    length, thick = size * draw.between(0.25, 0.5), size * draw.between(0.06, 0.12)
    if draw.chance(0.5):
        stick = cylinder(thick, length, "z", (x, y, z + 0.5 * length), 12, top_radius=thick * draw.between(0.6, 1.5))
    else:
        stick = box_between((x - 1.2 * thick, y - thick, z - 0.02), (x + 1.2 * thick, y + thick, z + length))
    upright = draw.chance(0.85)
    swing = draw.between(12.0, 35.0)
    deep = z - draw.between(0.0, 0.2) * length
    axis = X if upright else Y
    foot = [cylinder(1.8 * thick, 3.0 * thick, "x" if upright else "y", (x, y, deep), 14)] if draw.chance(0.4) else []
    lean = draw.sign() * swing * draw.pick([1.0, 0.0], [5, 1])
    return [stick, *foot], hinge((x, y, deep), axis, -swing, swing, rest=lean)


def _rim(room: tuple[float, float], at: tuple[float, float, float], proud: float) -> list[Mesh]:
    """A raised frame around a control."""
    (width, height), (x, y, z), bar = room, at, 0.03
    outer = (0.5 * width + bar, 0.5 * height + bar)
    sides = [box((bar, 2 * outer[1], proud), (x + s * outer[0], y, z + 0.5 * proud)) for s in (-1, 1)]
    return sides + [box((2 * outer[0], bar, proud), (x, y + s * outer[1], z + 0.5 * proud)) for s in (-1, 1)]
