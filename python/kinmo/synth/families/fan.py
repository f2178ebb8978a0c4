"""Fans with a rotor, and heads, controls and cords that move."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, dome, lathe, move, sweep, torus, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Fan whose blades turn about the motor's axis.

    Variants: a table or floor fan whose head may tip or swing, and a ceiling fan with a pull cord. Dials turn and buttons
    slide.
    """
    root = Node("fan")
    kind = draw.pick(["table", "stand", "ceiling"], [4, 3, 3])
    if kind == "ceiling":
        return _ceiling_fan(draw, root)
    radius = 0.5
    unit = root.add("table_fan" if kind == "table" else "floor_fan")
    height = radius + (draw.between(0.2, 0.4) if kind == "table" else draw.between(0.9, 1.5))
    foot = unit.add("base", *_foot(draw, height))
    base = Link("base", [foot], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    center = np.array([0.0, height, 0.12])
    frame = unit.add("fan_frame")
    motor = frame.add(
        "motor", cylinder(0.12, 0.25, "z", (0, height, -0.08), 20), dome((0.12, 0.08, 0.12), (0, height, -0.2), "z")
    )
    nodes = [motor]
    if draw.chance(0.8):
        nodes.append(frame.add("frame", *_guard(draw, radius, center)))
    holder = base
    tips = draw.pick(["tips", "swings", "fixed"], [3, 2, 3])
    if tips == "fixed":
        base.nodes += nodes
    else:
        pivot = (0, height - draw.between(0.0, 0.15), draw.between(-0.1, 0.0))
        motion = hinge(pivot, X, -30.0, 30.0) if tips == "tips" else hinge(pivot, Y, -60.0, 60.0)
        holder = Link("fan_frame", nodes, base, motion)
        links.append(holder)
    pieces = [cylinder(0.07, 0.08, "z", center, 16), *_blades(draw, 0.9 * radius, center, "z")]
    if draw.chance(0.7):
        motion = spinner((0, height, draw.pick([0.0, 0.12])), Z * draw.sign())
        links.append(Link("rotor", [unit.add("rotor", *pieces)], holder, motion))
    else:
        rotor = unit.add("rotor")
        rotor.add("hub", pieces[0])
        for blade in pieces[1:]:
            rotor.add("blade", blade)
        links.append(Link("rotor", [rotor], holder, spinner(center, Z)))
    links += _controls(draw, unit, base)
    return SynthObject("Fan", root, links)


def _ceiling_fan(draw: Draw, root: Node) -> SynthObject:
    """A ceiling fan: blades below a rod, sometimes with a lamp and a pull cord that slides."""
    unit = root.add("ceiling_fan")
    drop = draw.between(0.1, 0.6)
    rod = [cylinder(0.03, drop, "y", (0, 0.5 * drop, 0), 12), cylinder(0.1, 0.08, "y", (0, drop, 0), 20)]
    base = Link("base", [unit.add("base", *rod)], kind=draw.pick([JointType.STATIC, JointType.FREE]))
    hub = cylinder(draw.between(0.1, 0.16), 0.15, "y", (0, -0.07, 0), 24)
    blades = _blades(draw, draw.between(0.7, 1.1), np.array([0, -draw.between(0.02, 0.12), 0]), "y")
    links = [base, Link("rotor", [unit.add("rotor", hub, *blades)], base, spinner((0, 0, 0), Y * draw.sign()))]
    if draw.chance(0.5):
        light = unit.add("light", move(turn(dome((0.13, 0.1, 0.13)), X, 180.0), (0, -0.15, 0)))
        base.nodes.append(light)
    if draw.chance(0.3):
        cord = sweep(np.array([(0.08, -0.15, 0), (0.08, -0.45, 0)]), 0.005, 6)
        links.append(Link("cord", [unit.add("cord", cord)], base, slider(Y, -0.05, 0.0)))
    return SynthObject("Fan", root, links)


def _blades(draw: Draw, radius: float, center: np.ndarray, axis: str) -> list[Mesh]:
    """Blades about y or z, pitched, broad or narrow."""
    count = draw.pick([2, 3, 4, 5, 6], [1, 4, 3, 4, 1])
    wide = draw.between(0.15, 0.5) * radius * 3.0 / count
    pitch = draw.between(5.0, 35.0)
    blade = box((0.95 * radius, 0.01, wide), (0.55 * radius, 0, 0))
    if draw.chance(0.5):
        flare = blade.vertices.copy()
        flare[flare[:, 0] > 0.5 * radius, 2] *= draw.between(0.6, 1.6)
        blade = Mesh(flare, blade.faces)
    blade = turn(blade, X, pitch)
    start = draw.between(0.0, 90.0)
    blades = [turn(blade, Y, start + 360.0 * i / count) for i in range(count)]
    return [move(turn(b, X, 90.0) if axis == "z" else b, center) for b in blades]


def _guard(draw: Draw, radius: float, center: np.ndarray) -> list[Mesh]:
    """A cage of rings and spokes in front of and behind the blades."""
    deep = 0.12
    pieces = [torus(radius, 0.015, "z", center, 32, 6)]
    for side in (-1.0, 1.0):
        pieces.append(torus(0.5 * radius, 0.006, "z", center + side * deep * Z, 24, 4))
        path = np.array([(0.1, 0, side * deep), (0.6 * radius, 0, side * deep), (radius, 0, 0)])
        spoke = sweep(path, 0.006, 4)
        count = draw.pick([6, 8, 12])
        pieces += [move(turn(spoke, Z, 360.0 * i / count), center) for i in range(count)]
    pieces.append(cylinder(0.1, 0.02, "z", center + deep * Z, 16))
    return pieces


def _foot(draw: Draw, height: float) -> list[Mesh]:
    """The foot, round or square, with the column."""
    wide = draw.between(0.25, 0.45)
    column = cylinder(0.04, height - 0.1, "y", (0, 0.5 * height - 0.05, -0.08), 14)
    if draw.chance(0.6):
        profile = np.array([[0, 0], [wide, 0], [wide, 0.05], [0.3 * wide, 0.12], [0, 0.12]])
        return [lathe(profile, 28), column]
    return [box((2 * wide, 0.06, 1.4 * wide), (0, 0.03, 0)), column]


def _controls(draw: Draw, unit: Node, base: Link) -> list[Link]:
    """Buttons in a row, or a dial, on top of the foot."""
    if draw.chance(0.5):
        at = (0, 0.1, 0.12)
        knob = [turn(piece, X, -80.0, at) for piece in dial(draw, 0.05, 0.05, at)]
        axis = (0, np.sin(np.radians(80.0)), np.cos(np.radians(80.0)))
        return [Link("knob", [unit.add("knob", *knob)], base, spinner(at, axis))] if draw.chance(0.6) else []
    links = []
    for index in range(draw.integer(2, 4)):
        place = (0.06 * (index - 1.5), 0.09, 0.18)
        pressed = turn(button(draw, 0.05, 0.05, 0.03, (0, 0, 0)), X, -90.0)
        links.append(Link("button", [unit.add("button", move(pressed, place))], base, slider(Y, -0.02, 0.0)))
    return links
