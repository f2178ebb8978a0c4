"""Trash cans: wheeled, pedal, swing-top, drum, front-flap and split-lid bins."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.lid_hinges import lid_hinge
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    box,
    box_between,
    cylinder,
    dome,
    extrude,
    lathe,
    move,
    rounded_box,
    rounded_outline,
    sweep,
    tube,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Trash can, round or square.

    Lids and flaps turn about horizontal lines, pedals tip or slide, wheels roll, a drum tips over, and an inner bin slides out.
    """
    root = Node(draw.pick(["Trashcan", "trash_can"], [3, 1]))
    kinds = {"wheeled": _wheeled, "pedal": _pedal, "swing": _swing, "open": _drum, "front": _front_flap, "split": _split_lid}
    links = draw.pick(list(kinds.values()), [3, 3, 3, 1, 1.5, 1])(draw, root)
    return SynthObject("TrashCan", root, links)


def _tapered(width: float, depth: float, height: float, taper: float, radius: float) -> Mesh:
    """An open bin that widens upwards, with its rim at y = height."""
    top = rounded_outline(depth, width, radius)
    shell = extrude(top, height, "y", (0, height / 2, 0), capped=False)
    shrink = np.where(shell.vertices[:, 1:2] < 0.5 * height, taper, 1.0) * np.array([1.0, 0.0, 1.0]) + np.array([0.0, 1.0, 0.0])
    return Mesh(shell.vertices * shrink, shell.faces)


def _wheeled(draw: Draw, root: Node) -> list[Link]:
    """A tall bin with a lid hinged at the rear rim, and two wheels at the lower rear edge."""
    width, depth, height = draw.between(0.6, 0.95), draw.between(0.65, 0.9), draw.between(1.2, 1.7)
    taper = draw.between(0.65, 0.95)
    body = _tapered(width, depth, height, taper, draw.between(0.01, 0.12))
    floor = box((taper * width, 0.02, taper * depth), (0, 0.02, 0))
    node = root.add("base_body", body, floor)
    node.pieces.append(box((1.04 * width, 0.06, 1.04 * depth), (0, height - 0.05, 0)))
    base = Link("base_body", [node], kind=draw.pick([JointType.FREE, JointType.STATIC], [5, 1]))
    thick, over = draw.between(0.03, 0.1), draw.between(0.0, 0.05)
    rear = -depth / 2 - draw.between(0.0, 0.06)
    lid = root.add("lid", box_between((-width / 2 - over, height, rear), (width / 2 + over, height + thick, depth / 2 + over)))
    if draw.chance(0.5):
        lid.pieces.append(dome((0.5 * width, draw.between(0.05, 0.15), 0.48 * depth), (0, height + thick, 0)))
    if draw.chance(0.6):
        grip = cylinder(0.025, 0.9 * width, "x", (0, height + 0.02, rear - 0.03), 12)
        draw.pick([lid, node]).pieces.append(grip)
    opens = draw.pick([110.0, 180.0, 250.0, 270.0])
    rest = draw.between(30, 200) * opens / 270 if draw.chance(0.2) else 0.0
    axis = (0, height + draw.pick([0.0, 0.5 * thick, -0.03]), rear + draw.pick([0.0, 0.03]))
    links = [base, Link("lid", [lid], base, hinge(axis, (-1, 0, 0), 0, opens, rest=rest))]
    radius, thick = draw.between(0.09, 0.15), draw.between(0.03, 0.07)
    for side in (-1, 1):
        at = np.array(
            [side * (0.5 * taper * width + thick * draw.pick([-0.5, 0.5])), radius - 0.03, -0.5 * taper * depth + 0.4 * radius]
        )
        pieces = [cylinder(radius, thick, "x", at, 24)]
        if not draw.chance(0.5):
            pieces = [tube(radius, 0.7 * radius, thick, "x", at), cylinder(0.7 * radius, 0.7 * thick, "x", at)]
        links.append(Link("wheel", [root.add("wheel", *pieces)], base, spinner(at, (1, 0, 0))))
    return links


def _pedal(draw: Draw, root: Node) -> list[Link]:
    """A round or square can with a hinged lid and a pedal at the foot."""
    is_round = draw.chance(0.5)
    width, height = draw.between(0.5, 1.0), draw.between(0.9, 1.5)
    if is_round:
        shell, depth = lathe(np.array([[0, 0], [width / 2, 0], [width / 2, height]]), 32), width
    else:
        depth = draw.between(0.5, 0.95)
        shell = rounded_box((width, height, depth), draw.between(0.02, 0.15), "y", (0, height / 2, 0))
    node = root.add("base_body", shell)
    base = Link("base_body", [node])
    thick = draw.between(0.03, 0.12)
    rear = -depth / 2
    if is_round:
        lid_mesh = dome((0.52 * width, thick, 0.52 * width), (0, height, 0), segments=32)
        if not draw.chance(0.6):
            lid_mesh = cylinder(0.52 * width, thick, "y", (0, height + thick / 2, 0), 32)
    else:
        lid_mesh = rounded_box((1.03 * width, thick, 1.03 * depth), 0.08, "y", (0, height + thick / 2, 0))
    lid = root.add("lid", lid_mesh)
    rest = draw.between(20, 85) if draw.chance(0.2) else 0.0
    opens = draw.pick([80.0, 90.0, 180.0])
    axis = (0, height + draw.pick([0.0, 0.3 * thick]), rear)
    draw.pick([lid, node]).pieces.extend(lid_hinge(draw, axis, 0.6 * width, 0.03))
    links = [base, Link("lid", [lid], base, hinge(axis, (-1, 0, 0), 0, opens, rest=rest))]
    reach, wide = draw.between(0.08, 0.18), draw.between(0.15, 0.4) * width
    pedal = root.add("foot_pad", box_between((-wide / 2, 0.03, depth / 2 - 0.05), (wide / 2, 0.06, depth / 2 + reach)))
    if draw.chance(0.75):
        motion = hinge((0, 0.045, depth / 2 - 0.05), (1, 0, 0), 0, draw.between(8, 30))
        links.append(Link("foot_pad", [pedal], base, motion))
    else:
        links.append(Link("foot_pad", [pedal], base, slider((0, -1, 0), 0, 0.03)))
    return links


def _swing(draw: Draw, root: Node) -> list[Link]:
    """A can under a hood with a flap that swings about a line across it."""
    width, depth, height = draw.between(0.5, 0.9), draw.between(0.4, 0.8), draw.between(0.9, 1.4)
    node = root.add("base_body", _tapered(width, depth, height, draw.between(0.7, 1.0), draw.between(0.01, 0.15)))
    base = Link("base_body", [node])
    hood = draw.between(0.25, 0.5)
    for side in (-1, 1):
        outline = np.array([[height, -depth / 2], [height, depth / 2], [height + hood, 0.0]])[:, :]
        node.pieces.append(extrude(outline, 0.02, "x", (side * (width / 2 - 0.01), 0, 0)))
    slope = np.degrees(np.arctan2(hood, depth / 2))
    length = float(np.hypot(hood, depth / 2))
    front = draw.chance(0.5)
    back = turn(box((width - 0.04, 0.02, length)), (1, 0, 0), -slope)
    node.pieces.append(move(back, (0, height + hood / 2, -depth / 4)))
    flap = move(turn(box((width - 0.06, 0.02, 0.98 * length)), (1, 0, 0), slope), (0, height + hood / 2, depth / 4))
    lid = root.add(draw.pick(["lid", "door", "cover"]), flap)
    place = 0.0 if front else draw.between(0.2, 0.45)
    tangent = np.array([0, -np.sin(np.radians(slope)), np.cos(np.radians(slope))])
    axis = np.array([0, height + hood / 2, depth / 4]) - place * length * tangent
    limit = draw.between(40, 80)
    rest = draw.between(-30, 30) if draw.chance(0.2) else 0.0
    limits = (-limit, limit) if front else (0.0, limit)
    return [base, Link("lid", [lid], base, hinge(axis, (1, 0, 0), *limits, rest=rest if front else 0.0))]


def _front_flap(draw: Draw, root: Node) -> list[Link]:
    """A closed cabinet with a flap at the top of its front, and sometimes a door or drawer below it."""
    width, depth, height = draw.between(0.5, 0.9), draw.between(0.4, 0.8), draw.between(0.9, 1.5)
    x, z, wall = width / 2, depth / 2, 0.03
    walls = [box((wall, height, depth), (s * (x - wall / 2), height / 2, 0)) for s in (-1, 1)]
    walls += [box_between((-x, 0, -z), (x, height, -z + wall)), box_between((-x, height, -z), (x, height + wall, z))]
    high, low = height * draw.between(0.85, 0.95), height * draw.between(0.55, 0.7)
    below = draw.pick(["plain", "door", "bin"], [3, 2, 2])
    if below == "plain":
        walls.append(box_between((-x, 0, z - wall), (x, low, z)))
    node = root.add("base_body", *walls, box_between((-x, high, z - wall), (x, height, z)))
    base = Link("base_body", [node])
    flap = root.add(draw.pick(["lid", "door", "cover"]), box_between((-x + wall, low, z - wall), (x - wall, high, z)))
    upper = draw.chance(0.75)
    axis = (0, high if upper else low, z - 0.5 * wall)
    opens = draw.between(30.0, 80.0)
    limits = draw.pick([(0.0, opens), (-opens, 0.0), (-opens, opens)], [3, 2, 1]) if upper else (-opens, 0.0)
    links = [base, Link("lid", [flap], base, hinge(axis, X, *limits, rest=draw.pick([0.0, 0.4 * limits[1]], [4, 1])))]
    front = box_between((-x + wall, 0.02, z - wall), (x - wall, low - 0.01, z))
    if below == "door":
        side = draw.sign()
        turned = hinge((side * (x - wall), 0, z - 0.5 * wall), (0, side, 0), 0.0, draw.pick([90.0, 120.0]))
        links.append(Link("door", [root.add("door", front)], base, turned))
    elif below == "bin":
        tub = rounded_box((1.7 * x, 0.8 * low, 1.6 * z), 0.05, "y", (0, 0.45 * low, -0.05))
        out = slider((0, 0, 1), 0.0, draw.between(0.5, 1.0) * depth)
        links.append(Link("drawer", [root.add(draw.pick(["drawer", "container"]), front, tub)], base, out))
    return links


def _split_lid(draw: Draw, root: Node) -> list[Link]:
    """A can with two half lids, hinged at its sides or at a bar across its middle, and sometimes a pedal."""
    width, depth, height = draw.between(0.5, 1.1), draw.between(0.5, 0.8), draw.between(0.7, 1.4)
    node = root.add("base_body", _tapered(width, depth, height, draw.between(0.75, 1.0), draw.between(0.01, 0.15)))
    base = Link("base_body", [node])
    links, thick, outer = [base], draw.between(0.02, 0.07), draw.chance(0.6)
    opens = draw.pick([80.0, 90.0, 100.0])
    if not outer:
        node.pieces.append(box((0.03, thick, depth), (0, height + 0.5 * thick, 0)))
    for side in (-1.0, 1.0):
        half = box((0.5 * width - 0.02, thick, depth), (side * (0.25 * width + 0.01), height + 0.5 * thick, 0))
        edge = (side * (0.5 * width if outer else 0.02), height + draw.pick([0.0, 0.5 * thick]), 0)
        rest = draw.between(10.0, 80.0) if draw.chance(0.25) else 0.0
        motion = hinge(edge, (0, 0, -side if outer else side), 0.0, opens, rest=rest)
        links.append(Link("lid", [root.add("lid", half)], base, motion))
    if draw.chance(0.5):
        wide = draw.between(0.1, 0.3) * width
        pedal = root.add("foot_pad", box((wide, 0.03, 0.2), (0, 0.05, 0.5 * depth + 0.05)))
        press = hinge((0, 0.05, 0.5 * depth - 0.05), (1, 0, 0), 0.0, draw.between(8.0, 25.0))
        links.append(Link("foot_pad", [pedal], base, press))
    return links


def _drum(draw: Draw, root: Node) -> list[Link]:
    """An open bin between two posts that tips over about a line across it."""
    radius, height = draw.between(0.3, 0.45), draw.between(0.7, 1.1)
    lift = draw.between(0.15, 0.35)
    vessel = lathe(np.array([[0.0, lift], [0.85 * radius, lift], [radius, lift + height], [0.96 * radius, lift + height]]), 28)
    bin_node = root.add(draw.pick(["base_body", "drum", "rotation_container"]), vessel)
    axle_height = lift + draw.between(0.55, 0.75) * height
    posts = [box((0.05, axle_height + 0.05, 0.06), (s * (radius + 0.08), (axle_height + 0.05) / 2, 0)) for s in (-1, 1)]
    path = np.array([[-radius - 0.08, 0.02, 0.0], [radius + 0.08, 0.02, 0.0]])
    feet = [box((0.1, 0.03, 0.7), (s * (radius + 0.08), 0.015, 0)) for s in (1, -1)]
    stand = root.add(draw.pick(["frame", "base_body"]), *posts, sweep(path, 0.03, 8), *feet)
    base = Link("frame", [stand], kind=JointType.STATIC)
    motion = hinge((0, axle_height, 0), (1, 0, 0), *draw.pick([(-120.0, 120.0), (0.0, 110.0)]))
    return [base, Link("drum", [bin_node], base, motion, leaf_name="rotation_container")]
