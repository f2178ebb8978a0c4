"""Knives with folding blades, sliding blades or sheaths."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.posture import lay_down
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Z, box, box_between, cylinder, extrude, mirror, move, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Knife.

    Variants: one to four blades that fold out of the handle, a cutter whose blade slides out, and a fixed blade in a sheath
    that slides off. Built along z, flat across y, the blade to +z.
    """
    root = Node("knife")
    unit = root.add("cutting_instrument")
    shape = draw.pick([_folding, _cutter, _sheathed], [4, 3, 2])(draw, root, unit)
    lay_down(draw, shape)
    return shape


def _blade(draw: Draw, length: float, width: float, thickness: float) -> Mesh:
    """A blade from the origin to +z with its back at +x."""
    point = draw.between(0.55, 0.95)
    edge = draw.between(0.3, 1.0)
    outline = np.array([[0, -0.5], [0.7, -0.5 * edge], [1.0, 0.3], [point, 0.5], [0, 0.5]]) * (length, width)
    return extrude(outline, thickness, "y")


def _folding(draw: Draw, root: Node, unit: Node) -> SynthObject:
    """Blades or tools that turn about pins near the handle's ends; when closed they lie in the handle."""
    length, width, thickness = draw.between(0.8, 1.2), draw.between(0.14, 0.3), draw.between(0.08, 0.2)
    cheek = 0.2 * thickness
    handle_side = unit.add("handle_side")
    round_ends = draw.between(0.1, 0.5) * width
    cheeks = [rounded_box((width, cheek, length), round_ends, "y", (0, s * 0.5 * (thickness - cheek), 0)) for s in (-1, 1)]
    back = box_between((0.3 * width, -0.5 * thickness, -0.45 * length), (0.45 * width, 0.5 * thickness, 0.45 * length))
    handle_side.add("handle", *cheeks, back)
    base = Link("handle", [handle_side], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    links = [base]
    count = draw.pick([1, 2, 3, 4], [5, 2, 1, 1])
    room = (thickness - 2 * cheek) / count
    for index in range(count):
        end = 1.0 if index % 2 == 0 or draw.chance(0.5) else -1.0
        pin = np.array([draw.between(-0.15, 0.15) * width, 0.0, end * 0.45 * length])
        reach = length * draw.between(0.75, 0.88)
        blade = _blade(draw, reach, width * draw.between(0.45, 0.8), 0.6 * room)
        if end < 0:
            blade = mirror(blade, 2)
        y = (index - 0.5 * (count - 1)) * room
        pieces = [move(blade, (pin[0], y, pin[2]))]
        if draw.chance(0.6):
            pieces.append(cylinder(0.12 * width, 1.1 * thickness if count == 1 else 0.8 * room, "y", (pin[0], y, pin[2]), 12))
        side = unit.add("blade_side")
        side.add("blade", *pieces)
        # The blade is straight out at 0 degrees and folded in at 180, past the side away from the handle's back.
        turned = draw.pick([0.0, 180.0, draw.between(20.0, 160.0)], [2, 2, 3])
        motion = hinge((pin[0], draw.pick([0.0, y]), pin[2]), (0, -end, 0), 0.0, 180.0, rest=turned)
        links.append(Link("blade", [side], base, motion))
    return SynthObject("Knife", root, links)


def _cutter(draw: Draw, root: Node, unit: Node) -> SynthObject:
    """A utility knife: a thin blade slides out of the handle along it, with a button on top."""
    length, width, thickness = draw.between(0.9, 1.4), draw.between(0.12, 0.25), draw.between(0.06, 0.14)
    handle_side = unit.add("handle_side")
    handle = [rounded_box((width, thickness, length), 0.3 * width, "y")]
    if draw.chance(0.4):
        handle = [box((width, 0.3 * thickness, length), (0, s * 0.35 * thickness, 0)) for s in (-1, 1)]
        handle.append(box((0.2 * width, thickness, length), (0.4 * width, 0, 0)))
    handle_side.add("handle", *handle)
    base = Link("handle", [handle_side], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    side = unit.add("blade_side")
    reach = length * draw.between(0.5, 0.9)
    blade = _blade(draw, reach, 0.7 * width, 0.15 * thickness)
    side.add("blade", move(blade, (0, 0, 0.5 * length - reach)))
    moving = [side]
    if draw.chance(0.7):
        at = (0, 0.5 * thickness + 0.015, draw.between(-0.1, 0.2) * length)
        moving.append(unit.add("button", box((0.4 * width, 0.04, 0.12), at)))
    out = 0.8 * reach
    motion = slider(Z, 0.0, out, rest=draw.pick([0.0, draw.between(0.1, 1.0) * out]))
    return SynthObject("Knife", root, [base, Link("blade", moving, base, motion)])


def _sheathed(draw: Draw, root: Node, unit: Node) -> SynthObject:
    """A fixed blade in a sheath that slides off."""
    length, width, thickness = draw.between(0.6, 1.2), draw.between(0.1, 0.2), draw.between(0.05, 0.1)
    grip = draw.between(0.3, 0.6)
    handle_side, blade_side = unit.add("handle_side"), unit.add("blade_side")
    handle_side.add("handle", rounded_box((width, thickness, grip), 0.3 * width, "y", (0, 0, -0.5 * grip)))
    if draw.chance(0.5):
        handle_side.add("guard", box((2 * width, 1.3 * thickness, 0.04)))
    blade_side.add("blade", _blade(draw, length, 0.8 * width, 0.2 * thickness))
    base = Link("handle", [handle_side, blade_side], kind=JointType.FREE)
    wall, low = 0.02, 0.03
    high, x, y = length * draw.between(0.9, 1.05), 0.5 * width, 0.5 * thickness
    sheath = [box_between((s * x - wall, -y, low), (s * x + wall, y, high)) for s in (-1, 1)]
    sheath += [box_between((-x, s * y - wall / 2, low), (x, s * y + wall / 2, high)) for s in (-1, 1)]
    motion = slider(Z, 0.0, length, rest=draw.pick([0.0, draw.between(0.1, 1.0) * length], [2, 1]))
    return SynthObject("Knife", root, [base, Link("sheath", [root.add("sheath", *sheath)], base, motion)])
