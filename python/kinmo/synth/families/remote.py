"""Remote controls with many keys, a battery lid, and a dial or rocker on some."""

from __future__ import annotations

from kinmo.synth.details.controls import dial
from kinmo.synth.details.keypads import keypad, side_keys
from kinmo.synth.details.posture import turn_about_up
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Z, box, cylinder, rotation_about, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Remote control whose keys slide in.

    A dial turns, a rocker tips, and the battery lid slides. Built standing, keys to +z; most are shown lying on their back.
    """
    width, height, depth = draw.between(0.3, 0.55), draw.between(0.9, 1.6), draw.between(0.06, 0.2)
    body = Node("base_body", pieces=[rounded_box((width, height, depth), draw.between(0.01, 0.4) * width, "z")])
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    front = 0.5 * depth
    share = draw.between(0.55, 0.95)
    links = [base, *keypad(draw, base, width, height, front, share)]
    if share < 0.7:
        y, radius = 0.38 * height, draw.between(0.2, 0.35) * width
        if draw.chance(0.5):
            knob = Node("knob", pieces=dial(draw, radius, draw.between(0.02, 0.06), (0, y, front)))
            links.append(Link("knob", [knob], base, spinner((0, y, draw.pick([0.0, front])), Z)))
        else:
            ring = Node("rocker", pieces=[cylinder(radius, 0.03, "z", (0, y, front + 0.01), 20)])
            links.append(Link("toggle_button", [ring], base, hinge((0, y, front), X, -6.0, 6.0)))
    if draw.chance(0.3):
        links += side_keys(draw, base, width, height)
    if draw.chance(0.3):
        long = height * draw.between(0.2, 0.4)
        cover = Node("lid", pieces=[box((0.8 * width, long, 0.02), (0, 0.55 * long - 0.5 * height, -front))])
        links.append(Link("slider", [cover], base, slider((0, -1, 0), 0.0, long)))
    shape = SynthObject.flat("Remote", links)
    if draw.chance(0.6):
        shape.move(rotation_about(X, -90.0))
        turn_about_up(draw, shape, (0.0, 0.0, 90.0, 180.0))
    return shape
