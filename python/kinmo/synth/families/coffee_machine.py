"""Coffee machines and blenders with lids, containers, levers, dials, buttons, trays and steam wands."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, dial, grid_places
from kinmo.synth.details.turning_handles import lever
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    box,
    box_between,
    cylinder,
    ellipsoid,
    lathe,
    move,
    rounded_box,
    rounded_path,
    sweep,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, slider, spinner


@dataclass
class _Machine:
    """A machine under construction: x across, +z to the front, standing on y = 0."""

    draw: Draw
    body: Node
    base: Link
    links: list[Link] = field(default_factory=list)

    def add(self, name: str, node_name: str, pieces: list[Mesh], motion: Motion, parent: Link | None = None) -> Link:
        """Add a link with one node, on `parent` or the base."""
        link = Link(name, [Node(node_name, pieces=pieces)], parent or self.base, motion)
        self.links.append(link)
        return link


def build(draw: Draw) -> SynthObject:
    """Coffee machine or blender.

    Variants: a blender, a drip machine, an espresso machine and a capsule machine. Containers slide off, and lids lift off or
    fold up. Levers, steam wands and dials turn. Buttons and trays slide.
    """
    body = Node("base_body")
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY], [4, 1, 1]))
    machine = _Machine(draw, body, base)
    draw.pick([_blender, _drip_machine, _espresso_machine, _capsule_machine], [3, 3, 3, 2])(machine)
    return SynthObject.flat("CoffeeMachine", [base, *machine.links])


def _blender(machine: _Machine) -> None:
    """A motor base with a jar on top and a lid on the jar. Each lifts off."""
    draw = machine.draw
    radius, foot = draw.between(0.22, 0.32), draw.between(0.25, 0.6)
    round_foot = draw.chance(0.5)
    lean = draw.between(0.0, 35.0)
    front = radius
    if round_foot:
        profile = np.array([[0, 0], [1, 0], [1, 0.15], [0.85, 0.75], [0.75, 1], [0, 1]]) * (radius, foot)
        machine.body.pieces.append(lathe(profile, 24))
        front = 0.95 * radius
    else:
        # The front of the block leans back.
        back = np.tan(np.radians(lean)) * foot
        block = box((2 * radius, foot, 2 * radius), (0, 0.5 * foot, 0))
        corners = block.vertices.copy()
        corners[(corners[:, 1] > 0.5 * foot) & (corners[:, 2] > 0), 2] -= min(back, radius)
        machine.body.pieces.append(Mesh(corners, block.faces))
    jar_height, jar = draw.between(0.5, 0.9), radius * draw.between(0.75, 1.05)
    wall = 0.02
    bottom = 0.8 * jar
    profile = np.array([[0, 0], [bottom, 0], [jar, jar_height], [jar - wall, jar_height], [bottom - wall, wall], [0, wall]])
    pieces = [move(lathe(profile, draw.pick([8, 20, 28])), (0, foot, 0))]
    if draw.chance(0.6):
        out = draw.between(0.1, 0.2)
        ends = [(0.9 * jar, 0.2, 0), (jar + out, 0.25, 0), (jar + out, 0.8, 0), (0.95 * jar, 0.85, 0)]
        path = rounded_path(np.array(ends) * (1, jar_height, 1), 0.08)
        grip = move(sweep(path, 0.03, 8), (0, foot, 0))
        pieces.append(turn(grip, Y, draw.pick([0.0, 180.0, 90.0, -90.0])))
    container = machine.add("container", "container", pieces, slider(Y, 0.0, draw.pick([0.01, 0.05, 0.3])))
    top = foot + jar_height
    cap = [cylinder(1.04 * jar, 0.06, "y", (0, top + 0.03, 0)), cylinder(0.3 * jar, 0.12, "y", (0, top + 0.1, 0), 16)]
    machine.add("lid", "lid", cap, slider(Y, 0.0, draw.pick([0.01, 0.05, 0.2])), container)
    tilt = -lean if not round_foot else draw.pick([0.0, -8.0])
    if not round_foot:
        front -= 0.4 * np.tan(np.radians(lean)) * foot
    _panel(machine, 1.3 * radius, 0.5 * foot, 0.4 * foot, front, tilt)


def _drip_machine(machine: _Machine) -> None:
    """A tower with an overhanging top. The pot below slides out, and the lid above folds up at the rear."""
    draw = machine.draw
    width, depth, height = draw.between(0.4, 0.7), draw.between(0.45, 0.7), draw.between(0.75, 1.1)
    plate, top = draw.between(0.08, 0.15), draw.between(0.2, 0.35)
    tower = draw.between(0.3, 0.45) * depth
    half = 0.5 * depth
    machine.body.pieces += [
        rounded_box((width, plate, depth), draw.between(0.01, 0.15), "y", (0, 0.5 * plate, 0)),
        box_between((-width / 2, plate, -half), (width / 2, height - top, -half + tower)),
        rounded_box((width, top, depth), draw.between(0.01, 0.1), "y", (0, height - 0.5 * top, 0)),
    ]
    radius = 0.4 * min(width, depth - tower)
    pot_height = (height - top - plate) * draw.between(0.7, 0.95)
    z = half - 1.15 * radius
    profile = np.array([[0, 0], [0.85, 0], [1, 0.25], [0.9, 0.7], [0.65, 1], [0, 1]]) * (radius, pot_height)
    ends = [(0, 0.2 * pot_height, 0.9 * radius), (0, 0.25 * pot_height, 1.7 * radius), (0, 0.85 * pot_height, 1.6 * radius)]
    handle = sweep(rounded_path(np.array([*ends, (0, 0.9 * pot_height, 0.6 * radius)]), 0.1), 0.025, 8)
    pot = [move(lathe(profile, 24), (0, plate, z)), move(turn(handle, Y, draw.pick([0.0, 45.0, -45.0])), (0, plate, z))]
    out = draw.between(0.3, 0.6)
    machine.add("container", "container", pot, slider(*draw.pick([((0, 0, 1), 0.0, out), (Y, 0.0, 0.05)], [3, 1])))
    lid_depth, thick = depth * draw.between(0.5, 0.95), draw.between(0.02, 0.08)
    lid_z = -half + draw.between(0.0, 0.05) * depth
    lid = [rounded_box((0.95 * width, thick, lid_depth), 0.05, "y", (0, height + 0.5 * thick, lid_z + 0.5 * lid_depth))]
    opening = draw.between(60.0, 110.0)
    rest = -draw.between(15.0, opening) if draw.chance(0.3) else 0.0
    lid_hinge = hinge((0, height + draw.pick([0.0, 0.5 * thick, thick]), lid_z), X, -opening, 0.0, rest=rest)
    machine.add("lid", "lid", lid, lid_hinge)
    _panel(machine, 0.8 * width, height - 0.5 * top, 0.7 * top, half, 0.0)


def _espresso_machine(machine: _Machine) -> None:
    """A wide block with group heads that take a lever, a drip tray, a steam wand and dials."""
    draw = machine.draw
    width, depth, height = draw.between(0.6, 1.3), draw.between(0.5, 0.7), draw.between(0.6, 0.9)
    half, tray = 0.5 * depth, draw.between(0.06, 0.12)
    back = draw.between(0.4, 0.55) * depth
    over = draw.between(0.25, 0.4) * height
    machine.body.pieces += [
        box_between((-width / 2, 0, -half), (width / 2, tray, half)),
        box_between((-width / 2, tray, -half), (width / 2, height, -half + back)),
        rounded_box((width, over, depth), 0.05, "x", (0, height - 0.5 * over, 0)),
    ]
    drip = box((0.9 * width, 0.02, 0.8 * (depth - back)), (0, tray + 0.01, half - 0.45 * (depth - back)))
    drip_motion = slider(*draw.pick([(Y, 0.0, 0.02), ((0, 0, 1), 0.0, 0.3)]))
    machine.add("lid", draw.pick(["lid", "tray"]), [drip], drip_motion)
    under, z = height - over, half - 0.45 * (depth - back)
    for x in [0.0] if width < 0.9 else [-0.22 * width, 0.22 * width]:
        machine.body.pieces.append(cylinder(0.09, 0.06, "y", (x, under - 0.03, z), 20))
        arm = [cylinder(0.08, 0.07, "y", (0, -0.035, 0), 20), *lever(draw, draw.between(0.3, 0.45), 0.025, -0.03)]
        rest = draw.between(-50.0, 0.0) if draw.chance(0.3) else 0.0
        turned = hinge((x, draw.pick([0.0, under]), z), Y, *draw.pick([(-60.0, 0.0), (-90.0, 90.0), (-45.0, 10.0)]), rest=rest)
        machine.add(draw.pick(["lever", "handle"]), "lever", [move(p, (x, under - 0.06, z)) for p in arm], turned)
    if draw.chance(0.5):
        x = draw.sign() * 0.42 * width
        path = [(x, under, z), (x, under - 0.1, z + 0.1), (x, tray + 0.15, z + 0.15)]
        wand = [ellipsoid((0.03, 0.03, 0.03), path[0], 12, 8), sweep(rounded_path(np.array(path), 0.08), 0.012, 8)]
        machine.add("lever", "lever", wand, hinge(path[0], Y, -60.0, 60.0))
    if draw.chance(0.5):
        side = draw.sign()
        grip = dial(draw, draw.between(0.05, 0.09), draw.between(0.05, 0.1), (0, 0, 0))
        at = (side * 0.5 * width, height - 0.5 * over, draw.between(-0.2, 0.2) * depth)
        machine.add("knob", "knob", [move(turn(p, Y, side * 90.0), at) for p in grip], spinner(at, X))
    if draw.chance(0.4):
        _hand_levers(machine, width, height, half)
    _panel(machine, 0.7 * width, height - 0.5 * over, 0.7 * over, half, 0.0)


def _hand_levers(machine: _Machine, width: float, height: float, half: float) -> None:
    """Add one or two hand levers on the top or the front: long ones for a piston, short ones for steam."""
    draw = machine.draw
    name = draw.pick(["lever", "knob", "handle"], [2, 2, 1])
    for _ in range(draw.integer(1, 2)):
        long = draw.chance(0.5)
        length, x = draw.between(0.25, 0.5) if long else draw.between(0.06, 0.15), draw.between(-0.4, 0.4) * width
        foot = (x, height if draw.chance(0.6) else draw.between(0.7, 0.9) * height, half * draw.between(0.5, 1.0))
        rod = cylinder(length * draw.between(0.04, 0.1), length, "y", (0, 0.5 * length, 0), 10)
        ball = ellipsoid(np.full(3, length * draw.between(0.08, 0.18)), (0, length, 0), 12, 8)
        lean = draw.between(-10.0, 90.0)
        axis, sense = draw.pick([(X, 1.0), (Z, draw.sign())], [3, 1])
        pieces = [move(turn(piece, axis, sense * lean), foot) for piece in (rod, ball)]
        swing = draw.between(30.0, 90.0)
        machine.body.pieces.append(box(np.full(3, 0.3 * length), foot))
        machine.add(name, name, pieces, hinge(foot, axis, *draw.pick([(0.0, swing), (-swing, 0.0), (-30.0, 30.0)])))


def _capsule_machine(machine: _Machine) -> None:
    """A rounded body on a foot. A lever over the top turns about a horizontal line; a cup stand and a cap lift off."""
    draw = machine.draw
    radius, neck = draw.between(0.25, 0.4), draw.between(0.4, 0.6)
    machine.body.pieces += [
        cylinder(radius, 0.06, "y", (0, 0.03, 0.1)),
        cylinder(0.5 * radius, neck, "y", (0, 0.5 * neck, -0.15), 20),
        ellipsoid((0.9 * radius, 0.9 * radius, 1.2 * radius), (0, neck + 0.6 * radius, 0), 20, 12),
        cylinder(0.25 * radius, 0.5 * radius, "y", (0, neck + 0.1 * radius, 0.8 * radius), 16),
    ]
    y, z = neck + 0.6 * radius, draw.between(-0.3, 0.5) * radius
    reach, rise = 0.93 * radius, draw.between(1.0, 1.4) * radius
    corners = [(reach, 0, 0), (reach, 0.8 * rise, 0), (0.6 * reach, rise, 0)]
    corners += [(-x, up, 0) for x, up, _ in corners[::-1]]
    bow = turn(sweep(rounded_path(np.array(corners), 0.1), 0.025, 8), X, draw.between(0.0, 60.0))
    rest = draw.between(-60.0, 0.0) if draw.chance(0.4) else 0.0
    machine.add("lever", "lever", [move(bow, (0, y, z))], hinge((0, y, z), X, -draw.between(60.0, 100.0), 0.0, rest=rest))
    stand = cylinder(0.7 * radius, 0.03, "y", (0, 0.075, 0.5 * radius), 20)
    machine.add("lid", "lid", [stand], slider(Y, 0.0, 0.01))
    top = neck + 1.5 * radius
    cap = cylinder(0.4 * radius, 0.05, "y", (0, top, -0.3 * radius), 20)
    machine.add("lid", "lid", [cap], slider(Y, 0.0, draw.pick([0.03, 0.1])))
    _panel(machine, 0.6 * radius, neck + 0.6 * radius, 0.3 * radius, 1.17 * radius, 0.0)


def _panel(machine: _Machine, width: float, y: float, height: float, z: float, tilt: float) -> None:
    """Add a dial, buttons or both on a front that leans by `tilt` degrees about the panel's middle."""
    draw = machine.draw
    kind = draw.pick(["dial", "buttons", "both", "none"], [4, 4, 2, 1])
    middle = (0.0, y, z)
    normal = np.array([0.0, -np.sin(np.radians(tilt)), np.cos(np.radians(tilt))])
    if kind in ("dial", "both"):
        radius = 0.5 * min(height, width) * draw.between(0.4, 0.9)
        x = 0.0 if kind == "dial" else -0.5 * width + radius
        pieces = dial(draw, radius, radius * draw.between(0.3, 1.0), (x, y, z))
        at = (x, y, z)
        motion = spinner(at, normal) if draw.chance(0.7) else hinge(at, normal, 0.0, draw.pick([90.0, 180.0, 270.0]))
        machine.add("knob", "knob", [turn(p, X, tilt, middle) for p in pieces], motion)
    if kind in ("buttons", "both"):
        columns, rows = draw.integer(1, 5), draw.integer(1, 2)
        span = width * (0.55 if kind == "both" else 1.0)
        shift = 0.25 * width if kind == "both" else 0.0
        cell = min(span / columns, height / rows)
        size, depth = 0.7 * min(cell, 0.12), draw.between(0.006, 0.03)
        for x, up in grid_places(columns, rows, span, min(height, rows * 0.15)):
            pressed = turn(button(draw, size, 0.6 * size, depth, (x + shift, y + up, z)), X, tilt, middle)
            machine.add("button", "button", [pressed], slider(normal, -0.7 * depth, 0.0))
