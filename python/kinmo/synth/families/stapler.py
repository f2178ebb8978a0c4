"""Staplers: a magazine and a lid over a base, both on one pin near the rear."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Y, box, box_between, cylinder, extrude, rotation_about, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge


def build(draw: Draw) -> SynthObject:
    """Stapler whose magazine and lid both turn about one horizontal pin."""
    length, width = 1.5, draw.between(0.18, 0.38)
    thickness, pin_y = draw.between(0.04, 0.12), draw.between(0.12, 0.28)
    pin_z = -0.5 * length * draw.between(0.75, 0.95)
    root = Node("Stapler")
    base_node = Node("base_body", pieces=_base(draw, length, width, thickness, pin_y, pin_z))
    base = Link("base_body", [base_node], kind=draw.pick([JointType.FREE, JointType.STATIC]))

    front = 0.5 * length * draw.between(0.8, 1.0)
    magazine_height, magazine_width = draw.between(0.08, 0.14), width * draw.between(0.4, 0.75)
    low = max(thickness, pin_y - 0.5 * magazine_height) + 0.005
    behind = pin_z - draw.between(0.0, 0.08)
    magazine = [box_between((-magazine_width / 2, low, behind), (magazine_width / 2, low + magazine_height, front))]
    if draw.chance(0.5):
        magazine.append(box((magazine_width * 1.1, magazine_height * 0.7, 0.05), (0, low + 0.35 * magazine_height, front)))
    body = Node("body", pieces=magazine)
    lid = Node("lid", pieces=_lid(draw, width * draw.between(0.6, 1.0), low + magazine_height + 0.005, behind, front))

    lift = draw.pick([0.0, draw.between(4.0, 18.0), draw.between(30.0, 120.0)], [1, 6, 1])
    more = draw.pick([0.0, draw.between(3.0, 12.0), draw.between(30.0, 90.0)], [1, 6, 1])
    sense = draw.sign()
    origin = (draw.pick([0.0, draw.between(-0.1, 0.1)]), pin_y, pin_z)
    axis = (sense, 0.0, 0.0)
    # A positive turn about +x lowers the front.
    both = [_span(sense, upper, rest) for upper, rest in ((max(150.0, lift), lift), (max(160.0, lift + more), lift + more))]
    links = [base]
    for name, node, (low_limit, high_limit, rest) in (("body", body, both[0]), ("lid", lid, both[1])):
        links.append(Link(name, [node], base, hinge(origin, axis, low_limit, high_limit, rest=rest)))
    if draw.chance(0.3):
        knob = box((0.5 * magazine_width, 0.03, 0.08), (0, low - 0.02, 0.0))
        body.pieces.append(knob)
    root.children = draw.pick([[body, lid, base_node], [lid, body, base_node]])
    facing = 180.0 if draw.chance(0.3) else 0.0
    shape = SynthObject("Stapler", root, links)
    if facing:
        shape.move(rotation_about(Y, 180.0))
    return shape


def _span(sense: float, upper: float, rest: float) -> tuple[float, float, float]:
    """Limits and rest value (degrees) of a part that opens by up to `upper`, about +x (`sense` 1) or -x."""
    return (-upper, 0.0, -rest) if sense > 0 else (0.0, upper, rest)


def _base(draw: Draw, length: float, width: float, thickness: float, pin_y: float, pin_z: float) -> list[Mesh]:
    """The base plate with two cheeks, a pin and an anvil."""
    plate = rounded_box((width, thickness, length), 0.4 * width * draw.between(0.2, 1.0), "y", (0, 0.5 * thickness, 0))
    pieces = [plate]
    cheek, tall = draw.between(0.015, 0.04), pin_y + draw.between(0.04, 0.1)
    deep = draw.between(0.1, 0.25)
    for side in (-1.0, 1.0):
        x = side * 0.5 * (width * draw.between(0.85, 0.9) + cheek)
        pieces.append(box_between((x - cheek / 2, 0.5 * thickness, pin_z - deep / 2), (x + cheek / 2, tall, pin_z + deep / 2)))
    if draw.chance(0.7):
        pieces.append(cylinder(draw.between(0.015, 0.03), width, "x", (0, pin_y, pin_z), 12))
    if draw.chance(0.6):
        pieces.append(box((0.4 * width, 0.015, 0.15), (0, thickness, 0.42 * length)))
    return pieces


def _lid(draw: Draw, width: float, low: float, behind: float, front: float) -> list[Mesh]:
    """A long cover: a block, a wedge or an arched back."""
    height = draw.between(0.05, 0.16)
    back, nose = behind - draw.between(-0.03, 0.05), front + draw.between(-0.02, 0.1)
    kind = draw.pick(["block", "wedge", "arched"], [1, 2, 3])
    if kind == "block":
        return [box_between((-width / 2, low, back), (width / 2, low + height, nose))]
    share = np.linspace(0.0, 1.0, 9)
    z = back + (nose - back) * share
    swell = draw.between(0.3, 1.0)
    rise = height * (0.5 + 0.5 * share)
    if kind != "wedge":
        rise = height * (1 - swell + swell * np.sin(np.pi * (0.15 + 0.75 * share)))
    outline = np.concatenate([np.stack([np.full(9, low), z], 1), np.stack([low + rise, z], 1)[::-1]])
    pieces = [extrude(outline[::-1], width, "x")]
    if draw.chance(0.3):
        pieces.append(rounded_box((0.7 * width, 0.02, 0.3 * (nose - back)), 0.05, "y", (0, low + float(rise[6]), nose - 0.25)))
    return pieces
