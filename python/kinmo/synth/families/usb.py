"""USB sticks with swivelling covers, caps or sliding plugs."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.posture import lay_down
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Y, Z, box, box_between, cylinder, rounded_box, torus
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """USB stick.

    Variants: a cover that turns about a pin, a cap that slides off, and a plug that slides out. Built along z with the plug to
    +z, flat across y.
    """
    width, length, thickness = draw.between(0.28, 0.5), draw.between(0.6, 1.1), draw.between(0.1, 0.22)
    plug_length, plug = draw.between(0.2, 0.4), (0.65 * width, 0.5 * thickness)
    root = Node("usb")
    body = root.add("body", rounded_box((width, thickness, length), draw.between(0.01, 0.5) * width, "y"))
    plug_node = root.add("interface", *_plug(draw, plug, plug_length, 0.5 * length))
    base = Link("body", [body, plug_node], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    if draw.chance(0.3):
        body.pieces.append(torus(0.06, 0.015, "y", (0, 0, -0.5 * length - 0.04), 16, 6))
    links = [base]
    kind = draw.pick(["swivel", "cap", "slide"], [5, 4, 2])
    if kind == "swivel":
        links.append(_swivel(draw, root, base, (width, thickness, length), plug_length))
    elif kind == "cap":
        wall, low = draw.between(0.0, 0.04), 0.5 * length
        reach = plug_length + 0.05
        fit = (plug[0] + 0.02, plug[1] + 0.02) if draw.chance(0.2) else (width - 2 * wall, thickness - 2 * wall)
        cap = _sleeve((0.5 * fit[0], 0.5 * fit[1]), 0.03, low, low + reach)
        off = reach * draw.between(0.9, 1.5)
        rest = draw.pick([0.0, draw.between(0.2, 1.0) * off], [3, 1])
        motion = slider(Z, 0.0, off, rest=rest)
        links.append(Link(draw.pick(["cap", "lid"]), [root.add("lid", *cap)], base, motion))
    else:
        base.nodes.remove(plug_node)
        tab = root.add("button", box((0.3 * width, 0.04, 0.12), (0, 0.5 * thickness + 0.015, 0)))
        out = plug_length * draw.between(0.7, 1.0)
        motion = slider(Z, -out, 0.0, rest=draw.pick([0.0, -out, -draw.between(0.0, out)]))
        links.append(Link("interface", [plug_node, tab], base, motion))
    shape = SynthObject("USB", root, links)
    lay_down(draw, shape)
    return shape


def _plug(draw: Draw, size: tuple[float, float], length: float, start: float) -> list[Mesh]:
    """The plug: a shell with a tongue, or a block."""
    shell = _sleeve((0.5 * size[0], 0.5 * size[1]), 0.015, start - 0.3 * length, start + length)
    tongue = box((0.85 * size[0], 0.3 * size[1], 0.9 * length), (0, 0.15 * size[1], start + 0.45 * length))
    return [*shell, tongue] if draw.chance(0.7) else [box((*size, 1.3 * length), (0, 0, start + 0.35 * length))]


def _sleeve(half: tuple[float, float], wall: float, low: float, high: float) -> list[Mesh]:
    """Four walls around the z axis."""
    x, y = half
    sides = [box_between((s * x - 0.5 * wall, -y, low), (s * x + 0.5 * wall, y, high)) for s in (-1, 1)]
    return sides + [box_between((-x, s * y - 0.5 * wall, low), (x, s * y + 0.5 * wall, high)) for s in (-1, 1)]


def _swivel(draw: Draw, root: Node, base: Link, size: tuple[float, float, float], plug_length: float) -> Link:
    """A cover bent around both faces, on a pin near the far end. Built over the plug, it turns to uncover it."""
    width, thickness, length = size
    wall, gap = draw.between(0.01, 0.03), 0.004
    pin = np.array([draw.pick([0.0, draw.between(-0.1, 0.1)]) * width, 0.0, -0.5 * length * draw.between(0.1, 0.85)])
    front, back = 0.5 * length + 1.05 * plug_length, pin[2] - 0.4 * width
    wide = width * draw.between(0.7, 1.0)
    leaf = (wide, wall, front - back)
    level = 0.5 * (thickness + wall) + gap
    faces = [rounded_box(leaf, 0.3 * wide, "y", (pin[0], s * level, 0.5 * (front + back))) for s in (-1, 1)]
    pieces = faces if draw.chance(0.8) else faces[1:]
    if len(pieces) == 2:
        pieces.append(box((wide, 2 * level, wall), (pin[0], 0, front)))
    if draw.chance(0.7):
        pieces.append(cylinder(draw.between(0.03, 0.07), 2 * level + 2 * wall, "y", tuple(pin), 16))
    rest = draw.pick([0.0, 180.0, draw.between(20.0, 160.0)], [1, 1, 3])
    free = rest == 0.0 and draw.chance(0.3)
    motion = spinner(pin, Y) if free else hinge(pin, Y * draw.sign(), 0.0, 180.0, rest=rest)
    return Link("rotation_lid", [root.add(draw.pick(["rotation_lid", "lid"]), *pieces)], base, motion)
