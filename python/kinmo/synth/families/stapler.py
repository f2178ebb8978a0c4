"""Staplers: a magazine and a lid over a base, mostly both on one pin near the rear."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.posture import turn_about_up
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, extrude, move, open_box, rounded_box, sweep
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner

TURNED_SHARE = 0.2
"""Share of staplers that are turned about the vertical by any quarter."""


def build(draw: Draw) -> SynthObject:
    """Stapler whose magazine and lid turn about one horizontal pin.

    Variants: the magazine turns, is fixed to the base, or slides out to the front, and the lid turns on the base or on it. A
    heavy stapler has a fixed body with a lever on top. A pusher in the magazine slides, and the anvil turns.
    """
    length, width = 1.5, draw.ratio(0.12, 0.5)
    thickness, pin_y = draw.ratio(0.02, 0.15), draw.ratio(0.1, 0.35)
    pin_z = -0.5 * length * draw.pick([draw.between(0.75, 0.97), draw.between(0.45, 0.75)], [5, 1])
    root = Node("Stapler")
    base_node = Node("base_body", pieces=_base(draw, length, width, thickness, pin_y, pin_z))
    base = Link("base_body", [base_node], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    if draw.chance(0.12):
        links = [base, *_heavy(draw, base, length, width, thickness, pin_y)]
    else:
        links = [base, *_jaws(draw, base, length, width, thickness, (pin_y, pin_z))]
    if draw.chance(0.2):
        at = (0.0, thickness, 0.5 * length * draw.between(0.75, 0.92))
        plate = box((0.5 * width, draw.between(0.01, 0.03), draw.between(0.3, 0.9) * width), at)
        turned = spinner(at, Y) if draw.chance(0.6) else hinge(at, Y, 0.0, 180.0)
        links.append(Link("anvil", [Node(draw.pick(["anvil", "button"]), pieces=[plate])], base, turned))
    moving = [node for link in links[1:] for node in link.nodes]
    first = draw.integer(0, len(moving))
    root.children = [*moving[:first], *(node for node in base.nodes), *moving[first:]]
    shape = SynthObject("Stapler", root, links)
    if draw.chance(TURNED_SHARE):
        turn_about_up(draw, shape)
    return shape


def _jaws(draw: Draw, base: Link, length: float, width: float, thickness: float, pin: tuple[float, float]) -> list[Link]:
    """A magazine and a lid on the pin at `pin` (y, z)."""
    pin_y, pin_z = pin
    front = 0.5 * length * draw.between(0.75, 1.0)
    tall, wide = draw.ratio(0.05, 0.2), width * draw.between(0.35, 0.9)
    low = max(thickness, pin_y - 0.5 * tall) + 0.005
    behind = pin_z - draw.between(0.0, 0.08)
    holds = draw.pick(["turns", "fixed", "slides"], [7, 2, 1])
    magazine: list[Mesh] = [box_between((-wide / 2, low, behind), (wide / 2, low + tall, front))]
    if draw.chance(0.35):
        sheet = min(0.15 * wide, 0.2 * tall)
        rail = open_box((-wide / 2, -tall / 2, behind), (wide / 2, tall / 2, front), sheet)
        magazine = [move(rail, (0, low + tall / 2, 0))]
    if draw.chance(0.5):
        magazine.append(box((wide * 1.1, tall * 0.7, 0.05), (0, low + 0.35 * tall, front)))
    if draw.chance(0.3):
        magazine.append(box((0.5 * wide, 0.03, 0.08), (0, low - 0.02, 0.0)))
    if holds != "turns" and low - thickness > 0.01:
        support = box_between((-0.3 * wide, 0.5 * thickness, pin_z), (0.3 * wide, low, pin_z + 0.4 * length))
        base.nodes[0].pieces.append(support)
    body = Node(draw.pick(["body", "magazine"], [4, 1]), pieces=magazine)
    lid_width = max(width * draw.between(0.6, 1.1), wide)
    lid_node = Node("lid", pieces=_lid(draw, lid_width, low + tall + 0.005, behind, front))

    sense = draw.sign()
    origin, axis = (draw.pick([0.0, draw.between(-0.1, 0.1)]), pin_y, pin_z), (sense, 0.0, 0.0)
    lift = draw.pick([0.0, draw.between(4.0, 18.0), draw.between(30.0, 120.0)], [2, 6, 1]) if holds == "turns" else 0.0
    more = draw.pick([0.0, draw.between(3.0, 12.0), draw.between(30.0, 90.0)], [2, 6, 1])
    most = draw.pick([150.0, draw.between(20.0, 100.0)])
    links, carrier, above = [], base, lift
    if holds == "fixed":
        base.nodes.append(body)
    else:
        low_limit, high_limit, rest = _span(sense, max(most, lift), lift)
        motion = hinge(origin, axis, low_limit, high_limit, rest=rest)
        if holds == "slides":
            out = 0.6 * (front - behind)
            motion = slider(Z, 0.0, out, rest=draw.pick([0.0, draw.between(0.1, 0.9) * out], [3, 1]))
        links.append(Link("body", [body], base, motion))
        if holds == "turns" and draw.chance(0.2):
            carrier, above = links[0], 0.0
    low_limit, high_limit, rest = _span(sense, max(most + 10.0, above + more), above + more)
    links.append(Link("lid", [lid_node], carrier, hinge(origin, axis, low_limit, high_limit, rest=rest)))
    if draw.chance(0.15):
        block = box((0.7 * wide, 1.1 * tall, 0.1), (0, low + 0.5 * tall, front - 0.15))
        travel = 0.6 * (front - behind)
        pusher = Node(draw.pick(["slider", "pusher"]), pieces=[block])
        links.append(Link("pusher", [pusher], base if holds == "fixed" else links[0], slider(Z, -travel, 0.0)))
    return links


def _heavy(draw: Draw, base: Link, length: float, width: float, thickness: float, pin_y: float) -> list[Link]:
    """A fixed body over the base with a lever on top that tips, and sometimes a magazine that slides out to the front."""
    tall, rear = draw.between(0.15, 0.4), -0.5 * length * 0.95
    low, front = pin_y + 0.02, 0.5 * length * draw.between(0.6, 0.95)
    body = box_between((-0.4 * width, low, rear), (0.4 * width, low + tall, front))
    post = box_between((-0.4 * width, 0.5 * thickness, rear), (0.4 * width, low, rear + 0.35 * length))
    base.nodes.append(Node("body", pieces=[body, post]))
    top, pin_z = low + tall, front - draw.between(0.1, 0.5) * length
    reach = length * draw.between(0.5, 1.0)
    bar = sweep(np.array([(0, top + 0.06, pin_z), (0, top + 0.06, pin_z + reach)]), draw.between(0.02, 0.05), draw.pick([4, 8]))
    ears = [box((0.04, 0.14, 0.12), (s * (0.06 + 0.02), top + 0.05, pin_z)) for s in (-1, 1)]
    base.nodes[0].pieces += ears
    grip = cylinder(0.06, 0.25, "z", (0, top + 0.06, pin_z + reach), 12)
    lifted = draw.between(20.0, 70.0)
    motion = hinge((0, top + 0.06, pin_z), -X, 0.0, lifted, rest=draw.pick([lifted, 0.0, 0.5 * lifted], [3, 1, 1]))
    links = [Link("lid", [Node(draw.pick(["lid", "lever", "handle"]), pieces=[bar, grip])], base, motion)]
    if draw.chance(0.5):
        tray = box_between((-0.25 * width, low - 0.07, rear + 0.4 * length), (0.25 * width, low, front))
        links.append(Link("body", [Node("magazine", pieces=[tray])], base, slider(Z, 0.0, 0.4 * length)))
    return links


def _span(sense: float, upper: float, rest: float) -> tuple[float, float, float]:
    """Limits and rest value (degrees) of a part that opens by up to `upper`, about +x (`sense` 1) or -x."""
    return (-upper, 0.0, -rest) if sense > 0 else (0.0, upper, rest)


def _base(draw: Draw, length: float, width: float, thickness: float, pin_y: float, pin_z: float) -> list[Mesh]:
    """The base plate with two cheeks, a pin and an anvil."""
    wide = width * draw.pick([1.0, draw.between(1.0, 1.6)])
    plate = rounded_box((wide, thickness, length), 0.4 * wide * draw.between(0.0, 1.0), "y", (0, 0.5 * thickness, 0))
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
    height = draw.ratio(0.03, 0.3)
    back, nose = behind - draw.between(-0.03, 0.08), front + draw.between(-0.05, 0.12)
    kind = draw.pick(["block", "rounded", "wedge", "arched"], [1, 1, 2, 3])
    if kind == "rounded":
        middle = (0, low + 0.5 * height, 0.5 * (back + nose))
        return [rounded_box((width, height, nose - back), 0.45 * width, "y", middle)]
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
