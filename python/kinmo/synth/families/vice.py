"""Vices with a sliding jaw, a spindle and a bar through its head."""

from __future__ import annotations

import numpy as np

from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Z, box, cylinder, move, sweep, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, screw, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Vice whose jaw slides towards the fixed jaw.

    The spindle turns on the sliding jaw, or screws through the base. The bar slides through the spindle's head.
    """
    width, depth = draw.between(0.4, 0.7), draw.between(0.7, 1.1)
    root = Node("Vice")
    fixed = [box((width, 0.2, depth), (0, 0.1, 0)), box((width, 0.35, 0.2), (0, 0.37, -0.5 * depth + 0.1))]
    if draw.chance(0.5):
        fixed.append(cylinder(0.4 * width, 0.15, "y", (0, -0.07, -0.2 * depth), 24))
    base = Link("base_body", [root.add("base_body", *fixed)], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    z = draw.between(-0.1, 0.35) * depth
    jaw_node = root.add("slider", box((width, 0.35, 0.18), (0, 0.38, z)), box((0.4 * width, 0.1, 0.5 * depth), (0, 0.25, z)))
    jaw = Link("slider", [jaw_node], base, slider(Z, -0.5 * depth + 0.3 - z, 0.5 * depth - z))
    y, out = 0.33, z + draw.between(0.2, 0.4)
    rod = [cylinder(0.04, 0.6 * depth, "z", (0, y, out - 0.3 * depth), 14), cylinder(0.07, 0.1, "z", (0, y, out), 18)]
    holder = jaw if draw.chance(0.6) else base
    motion = spinner((0, y, 0), Z) if holder is jaw else screw((0, y, 0), Z, -0.2, 0.2, turns=None)
    spindle = Link("screw", [root.add("screw", *rod)], holder, motion)
    half = draw.between(0.15, 0.25)
    turned = draw.pick([0.0, 90.0, draw.between(0.0, 180.0)])
    path = np.array([(-half, 0, 0), (half, 0, 0)])
    bar = turn(sweep(path, 0.018, 8), Z, turned)
    pieces = [move(bar, (0, y, out))]
    direction = np.array([np.cos(np.radians(turned)), np.sin(np.radians(turned)), 0.0])
    lever = Link("lever", [root.add("lever", *pieces)], spindle, slider(direction, -0.8 * half, 0.8 * half))
    return SynthObject("Vice", root, [base, jaw, spindle, lever])
