"""Lighters with lids, spark wheels and push keys."""

from __future__ import annotations

from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, rounded_box, tube
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Lighter with a hinged lid, a spark wheel that turns, or both.

    A lighter without a lid has a key that slides or tips. Built with the lid closed, hinged at -x or at the rear.
    """
    width, height, depth = draw.between(0.35, 0.6), draw.between(0.6, 1.1), draw.between(0.15, 0.3)
    lid_height = height * draw.between(0.35, 0.6)
    edge = draw.between(0.005, 0.4) * depth
    root = Node("lighter")
    still = [root.add("body", rounded_box((width, height, depth), edge, "y", (0, 0.5 * height, 0)))]
    base = Link("body", still, kind=draw.pick([JointType.FREE, JointType.STATIC]))
    links = [base]
    kind = draw.pick(["lid", "wheel", "both"], [3, 2, 4])
    tall = 0.6 * lid_height
    if kind != "lid":
        chimney = tube(0.28 * depth, 0.2 * depth, tall, "y", (-0.1 * width, height + 0.5 * tall, 0), 14)
        still.append(
            root.add("other_leaf", chimney, box((0.3 * width, 0.5 * tall, 0.7 * depth), (0.2 * width, height + 0.2 * tall, 0)))
        )
        at = (0.22 * width, height + 0.6 * tall, 0)
        radius = 0.35 * tall
        sparked = spinner((at[0], at[1], draw.pick([0.0, 0.1])), Z * draw.sign())
        links.append(Link("wheel", [root.add("wheel", cylinder(radius, 0.5 * depth, "z", at, 20))], base, sparked))
    if kind == "wheel":
        press = root.add("button", box((0.3 * width, 0.06, 0.6 * depth), (0.38 * width, height + 0.05, 0)))
        tipped = hinge((0.25 * width, height + 0.03, 0), Z, -15.0, 0.0)
        motion = slider(Y, -0.05, 0.0) if draw.chance(0.5) else tipped
        links.append(Link("button", [press], base, motion))
    else:
        wall = 0.03 * width
        top, middle = height + lid_height, height + 0.5 * lid_height
        shell = [box((width, wall, depth), (0, top - wall / 2, 0))]
        shell += [box((wall, lid_height, depth), (s * 0.5 * (width - wall), middle, 0)) for s in (-1, 1)]
        shell += [box((width, lid_height, wall), (0, middle, s * 0.5 * (depth - wall))) for s in (-1, 1)]
        if kind == "lid" and draw.chance(0.5):
            shell = [rounded_box((width, lid_height, depth), edge, "y", (0, middle, 0))]
        out = draw.between(-0.01, 0.03)
        line = (-0.5 * width - out, height + draw.pick([0.0, 0.02]), 0.0)
        opening = draw.between(90.0, 180.0)
        rest = draw.pick([0.0, draw.between(20.0, opening)])
        if draw.chance(0.8):
            still[0].pieces.append(cylinder(draw.between(0.015, 0.03), 0.6 * depth, "z", line, 10))
        if draw.chance(0.85):
            motion = hinge(line, Z * draw.sign(), 0.0, opening)
            sense = float(motion.direction[2])
            motion = hinge(line, motion.direction, *sorted((0.0, sense * opening)), rest=sense * rest)
        else:
            # The lid is hinged at the rear.
            motion = hinge((0, height, -0.5 * depth), X, -opening, 0.0, rest=-rest)
        links.append(Link("lid", [root.add("lid", *shell)], base, motion))
    return SynthObject("Lighter", root, links)
