"""Displays with a screen that tilts on a stand, and buttons."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, cylinder, lathe, move, rounded_box, rounded_path, sheet, sweep, turn
from kinmo.synth.synth_object import Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Display whose screen tilts about a horizontal line.

    The neck is fixed, turns on the foot, or slides up. Buttons on the front or the lower edge slide in.
    """
    width = draw.between(1.2, 1.8)
    height = width / draw.pick([4 / 3, 1.6, 16 / 9, 2.1])
    thick = draw.between(0.03, 0.2)
    root = Node("display")
    stand = root.add("base_support")
    foot = Link("base", [stand.add("base", *_foot(draw, 0.5 * width))])
    links = [foot]
    rise = height / 2 + draw.between(0.1, 0.3)
    carrier = _neck(draw, stand, links, rise)
    front = draw.between(0.02, 0.12)
    screen = root.add("display_screen")
    center = np.array([0, rise + draw.pick([0.0, draw.between(-0.15, 0.15)]) * height, front + thick / 2])
    case = box((width, height, thick), center) if draw.chance(0.6) else rounded_box((width, height, thick), 0.05, "z", center)
    screen.add("frame", case)
    rim = draw.between(0.02, 0.08)
    pane = (width - 2 * rim, height - 2 * rim)
    at = center + [0, 0, thick / 2 + draw.pick([0.0, 0.003])]
    screen.add("screen", sheet(pane, at, "z") if draw.chance(0.6) else box((*pane, 0.01), at))
    if draw.chance(0.4):
        bulge = rounded_box((0.5 * width, 0.5 * height, front), 0.05, "z", center - [0, 0, thick / 2 + front / 2])
        screen.add("back", bulge)
    axis, limits = (0, rise, front * draw.between(0.0, 1.0)), (-draw.between(5, 20), draw.between(5, 25))
    tilt = hinge(axis, (1, 0, 0), *limits, rest=draw.pick([0.0, draw.between(-5, 5)]))
    panel = Link("screen", [screen], carrier, tilt, leaf_name="screen")
    links.append(panel)
    if draw.chance(0.5):
        links += _buttons(draw, root, panel, center, width, height, thick)
    return SynthObject("Display", root, links)


def _foot(draw: Draw, reach: float) -> list[Mesh]:
    """The foot on y = 0: a plate, a disc, an oval or two feet."""
    depth = reach * draw.between(0.5, 1.0)
    kind = draw.pick(["plate", "disc", "oval", "feet"])
    if kind == "plate":
        return [rounded_box((reach, 0.03, depth), 0.1, "y", (0, 0.015, 0))]
    if kind == "disc":
        return [lathe(np.array([[0, 0], [reach / 2, 0], [0.9 * reach / 2, 0.03], [0.1, 0.06], [0, 0.06]]), 32)]
    if kind == "oval":
        plate = cylinder(0.5, 0.03, "y", (0, 0.015, 0), 32)
        return [Mesh(plate.vertices * [reach, 1, depth], plate.faces)]
    return [turn(box((0.06, 0.03, depth), (0, 0.015, 0.3 * depth)), (0, 1, 0), a) for a in (-45, 45)]


def _neck(draw: Draw, stand: Node, links: list[Link], rise: float) -> Link:
    """Add the neck, fixed to the foot, turning on it, or sliding up; returns the link that carries the screen."""
    kind = draw.pick(["fixed", "swivel", "lift"], [5, 3, 2])
    foot = links[0]
    if draw.chance(0.3):
        path = rounded_path(np.array([[0, 0.03, -0.1], [0, 0.6 * rise, -0.12], [0, rise, 0.0]]), 0.1)
        post = sweep(path, draw.between(0.025, 0.05), 12)
    else:
        post = box((draw.between(0.06, 0.3), rise, draw.between(0.03, 0.08)), (0, rise / 2 + 0.02, -0.03))
    node = stand.add("support", post)
    if kind == "fixed":
        foot.nodes.append(node)
        return foot
    if kind == "swivel":
        link = Link(
            "support", [node], foot, draw.pick([spinner((0, 0, -0.03), (0, 1, 0)), hinge((0, 0, -0.03), (0, 1, 0), -45, 45)])
        )
    else:
        sleeve = stand.add("support", move(box((0.36, 0.5 * rise, 0.12)), (0, 0.25 * rise + 0.02, -0.05)))
        foot.nodes.append(sleeve)
        reach = draw.between(0.1, 0.3) * rise
        link = Link("support", [node], foot, slider((0, 1, 0), draw.pick([0.0, -0.5 * reach]), reach))
    links.append(link)
    return link


def _buttons(draw: Draw, root: Node, panel: Link, center: np.ndarray, width: float, height: float, thick: float) -> list[Link]:
    """Buttons below the screen, on the front or on the lower edge."""
    links = []
    travel, size = draw.between(0.004, 0.012), draw.between(0.02, 0.04)
    below = draw.chance(0.3)
    group = root.add("control_buttons")
    for index in range(draw.integer(1, 6)):
        x = center[0] + 0.4 * width - 2 * size * index
        if below:
            at, direction = (x, center[1] - height / 2 - travel / 2, center[2]), (0, 1, 0)
            mesh = box((size, travel, 0.5 * thick), at)
        else:
            at, direction = (x, center[1] - height / 2 + 0.01, center[2] + thick / 2 + travel / 2), (0, 0, -1)
            mesh = cylinder(size / 2, travel, "z", at, 14) if draw.chance(0.5) else box((size, 0.5 * size, travel), at)
        links.append(Link("button", [group.add("button", mesh)], panel, slider(direction, 0, travel)))
    return links
