"""Washing machines with a round front door or a lid on top, knobs, buttons and a drawer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.synth.details.appliances import add_dial, add_feet
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.details.resting_details import add_body_details
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    along,
    box,
    box_between,
    cylinder,
    dome,
    join,
    lathe,
    move,
    rotation_about,
    rounded_box,
    sheet,
    torus,
    tube,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Washing machine.

    Variants: a front loader whose door turns about its side, and a top loader whose lid turns about its rear edge or side.
    Knobs turn; buttons and the detergent drawer slide.
    """
    width, height, depth = draw.between(0.9, 1.2), draw.between(1.0, 1.6), draw.between(0.8, 1.25)
    x, y, z = width / 2, height / 2, depth / 2
    root = Node(draw.pick(["WashingMachine", "washing_machine"], [3, 1]))
    shell = (
        rounded_box((width, height, depth), draw.between(0.01, 0.1), "y") if draw.chance(0.4) else box((width, height, depth))
    )
    body = root.add("base_body", shell)
    base = Link("base_body", [body], kind=draw.pick([JointType.HEAVY, JointType.STATIC, JointType.FREE], [5, 1, 1]))
    links = [base]
    if draw.chance(0.7):
        links.append(_porthole(draw, root, body, base, x, y, z))
        links += _front_controls(draw, root, base, x, y, z)
    else:
        links += _top_loader(draw, root, body, base, x, y, z)
    if draw.chance(0.4):
        base.nodes.append(add_feet(draw, root, x, z, -y))
    if draw.chance(0.3):
        base.nodes += add_body_details(draw, root, (-x, -y, -z), (x, y, z))
    return SynthObject("WashingMachine", root, links)


def _porthole(draw: Draw, root: Node, body: Node, base: Link, x: float, y: float, z: float) -> Link:
    """A round door with a bulging glass, hinged beside its rim."""
    radius = draw.between(0.5, 0.75) * x
    up = draw.between(-0.2, 0.05) * y
    thickness = draw.between(0.03, 0.1)
    center = np.array([draw.pick([0.0, draw.between(-0.1, 0.1)]) * x, up, z])
    if draw.chance(0.5):
        body.pieces.append(move(tube(1.12 * radius, radius, 0.04, "z"), center))
    if draw.chance(0.5):
        body.pieces.append(move(cylinder(0.85 * radius, 0.02, "z"), center))
    node = root.add("door")
    segments = draw.pick([20, 28, 40])
    if draw.chance(0.7):
        node.pieces.append(move(tube(radius, 0.72 * radius, thickness, "z", (0, 0, thickness / 2), segments), center))
        bulge = draw.between(-0.35, 0.2) * radius
        glass = dome((0.74 * radius, abs(bulge), 0.74 * radius), axis="z", segments=segments)
        flipped = turn(glass, (0, 1, 0), 180) if bulge < 0 else glass
        node.pieces.append(move(flipped, center + [0, 0, thickness / 2]))
    else:
        profile = np.array([[1, 0], [1, 0.6], [0.8, 1], [0.4, 1.2], [0, 1.2]]) * (radius, thickness)
        node.pieces.append(move(along(lathe(profile, segments), "z"), center))
    side = draw.pick([-1.0, 1.0], [2, 1])
    if draw.chance(0.6):
        grip = box((0.1 * radius, 0.3 * radius, 0.5 * thickness), (-side * 0.88 * radius, 0, 1.1 * thickness))
        node.pieces.append(move(grip, center))
    reach = radius * draw.between(0.95, 1.1)
    axis = center + [side * reach, 0, thickness * draw.pick([0.0, 0.5])]
    if draw.chance(0.25):
        # A ring of screws.
        places = np.radians(np.arange(0.0, 360.0, draw.pick([45.0, 60.0, 90.0])))
        head = cylinder(0.03 * radius, 0.2 * thickness, "z", (0, 0, thickness), 10)
        node.pieces += [move(head, center + [0.9 * radius * np.cos(a), 0.9 * radius * np.sin(a), 0]) for a in places]
    if draw.chance(0.5):
        bracket = box((0.14 * radius, 0.4 * radius, 0.6 * thickness), (side * reach, 0, 0.3 * thickness))
        (node if draw.chance(0.5) else body).pieces.append(move(bracket, center))
    rest = draw.between(20, 130) if draw.chance(0.3) else 0.0
    return Link("door", [node], base, hinge(axis, (0, side, 0), 0, draw.pick([90.0, 120.0, 178.0]), rest=rest))


def _front_controls(draw: Draw, root: Node, base: Link, x: float, y: float, z: float) -> list[Link]:
    """A knob, a row of buttons, and a detergent drawer, in the upper strip of the front."""
    links: list[Link] = []
    level = draw.between(0.75, 0.85) * y
    if draw.chance(0.8):
        at = (draw.between(-0.3, 0.6) * x, level, z)
        links += add_dial(draw, root, base, at, draw.between(0.03, 0.13) * x, draw.pick(["button", "knob", "switch"]))
    if draw.chance(0.6):
        count, size, travel = draw.integer(2, 8), draw.between(0.03, 0.06), draw.between(0.002, 0.015)
        for index in range(count):
            node = root.add(
                "button", box((size, size, travel), (0.9 * x - 1.5 * size * (index + 1), level - 0.09, z + travel / 2))
            )
            links.append(Link("button", [node], base, slider((0, 0, -1), 0, travel)))
    if draw.chance(0.4):
        width, height, deep = 0.5 * x, draw.between(0.1, 0.16), draw.between(0.3, 0.6) * z
        left = -0.95 * x
        corners = (left, level - height / 2), (left + width, level + height / 2)
        front = box_between((left, level - height / 2, z - 0.01), (left + width, level + height / 2, z + 0.03))
        inner = box_between((left + 0.02, level - 0.4 * height, z - deep), (left + width - 0.02, level + 0.2 * height, z))
        node = root.add("drawer", *([front, inner] if draw.chance(0.6) else [front]))
        fittings = add_fittings(draw, root, *corners, z + 0.03)
        motion = slider((0, 0, 1), 0, draw.between(0.6, 0.95) * deep)
        links.append(Link("drawer", [node, *fittings], base, motion, leaf_name="translation_drawer"))
    return links


def _top_loader(draw: Draw, root: Node, body: Node, base: Link, x: float, y: float, z: float) -> list[Link]:
    """A lid on top, hinged at the rear or a side, in front of a raised and tilted control panel."""
    rear = -z + draw.between(0.25, 0.4) * z
    tilt = draw.between(0, 35)
    panel_height = draw.between(0.2, 0.35)
    panel = turn(box((2 * x, panel_height, 0.12)), (1, 0, 0), -tilt)
    at = np.array([0, y + 0.4 * panel_height, rear - 0.12])
    body.pieces.append(move(panel, at))
    front = z - draw.between(0.05, 0.15) * z
    half = x * draw.between(0.6, 0.95)
    thick = draw.between(0.02, 0.05)
    round_lid = draw.chance(0.25)
    center = np.array([0, y + thick / 2, 0.5 * (rear + front)])
    span = min(half, 0.5 * (front - rear))
    slab = cylinder(span, thick, segments=28) if round_lid else box((2 * half, thick, front - rear))
    lid = root.add(draw.pick(["door", "lid"]), move(slab, center))
    if draw.chance(0.5):
        lid.pieces.append(move(torus(0.08, 0.015, "y"), center + [0, thick / 2, 0.35 * (front - rear)]))
    if draw.chance(0.5):
        lid.pieces.append(
            join(*(sheet((0.3 * half, 0.5 * half), center + [s * 0.3 * half, 0.51 * thick, 0], "y") for s in (-1, 1)))
        )
    rest = draw.between(20, 90) if draw.chance(0.35) else 0.0
    if draw.chance(0.75):
        edge = center + [0, 0, -(span if round_lid else 0.5 * (front - rear))]
        motion = hinge(edge, (-1, 0, 0), 0, draw.pick([90.0, 100.0]), rest=rest)
    else:
        motion = hinge(center + [-(span if round_lid else half), 0, 0], (0, 0, 1), 0, 95.0, rest=rest)
    links = [Link("door", [lid], base, motion, leaf_name="door")]
    links += _console(draw, root, base, x, panel_height, rotation_about(X, -tilt), at)
    if draw.chance(0.2):
        links += add_keypad(draw, root, base, (0.4 * x, 0.5 * y, z), (0.3 * x, 0.2 * y), "button", lookalikes=False)
    return links


def _console(
    draw: Draw, root: Node, base: Link, x: float, height: float, tilt: NDArray[np.float64], at: NDArray[np.float64]
) -> list[Link]:
    """Knobs and keys on the panel of a top loader. Built on a vertical front at the origin, then tilted and moved to `at`."""
    links: list[Link] = []
    kept = len(base.nodes)  # dials that do not move are added to the base behind these
    name = draw.pick(["button", "knob", "switch"], [3, 1, 1])
    front = 0.06
    small = draw.between(0.022, 0.05)
    spacing = draw.between(0.2, 0.4) * x
    start = draw.between(0.4, 0.85) * x
    for index in range(draw.integer(1, 5)):
        radius = small if index else draw.between(1.0, 2.5) * small
        place = (start - spacing * index, draw.pick([0.0, draw.between(-0.2, 0.2)]) * height, front)
        links += add_dial(draw, root, base, place, radius, name)
    if draw.chance(0.5):
        center = (draw.between(-0.7, -0.2) * x, 0.0, front)
        links += add_keypad(draw, root, base, center, (0.3 * x, 0.6 * height), "button", lookalikes=False)
    tilt = tilt.copy()
    tilt[:3, 3] = at
    for link in [*links, Link("console", base.nodes[kept:])]:
        link.move(tilt)
    return links
