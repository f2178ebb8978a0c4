"""Kettles and teapots with lids, bows, switches and a base to lift off from."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.lid_hinges import lid_hinge
from kinmo.synth.details.vessels import beak, swinging_bow, vessel, vessel_lid
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, box, cylinder, lathe, rounded_path, sweep
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Kettle whose lid lifts off or folds up.

    The handle is a bow that swings, or is fixed. An electric kettle has a switch that tips or slides, and may lift off its
    base.
    """
    radius, height = 0.5, draw.between(0.5, 1.5)
    mouth = radius * draw.between(0.35, 0.95)
    segments = draw.pick([12, 20, 28])
    root = Node(draw.pick(["Kettle", "kettle"], [3, 1]))
    body = root.add("base_body", *vessel(draw, radius, mouth, height, segments), beak(draw, height))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC], [4, 1]))
    links = [base]
    lid, crown = vessel_lid(draw, mouth, height, segments)
    root.children.append(lid)
    motion = _lid_motion(draw, mouth, height)
    if motion.is_hinge:
        draw.pick([lid, body]).pieces.extend(lid_hinge(draw, motion.origin, mouth, 0.04 * radius))
    links.append(Link("lid", [lid], base, motion))
    if draw.chance(0.35):
        bow = swinging_bow(draw, base, mouth, height, crown)
        root.children += bow.nodes
        if draw.chance(0.75):
            links.append(bow)
        else:
            base.nodes += bow.nodes
    else:
        body.pieces.append(_side_handle(draw, radius, mouth, height))
        if draw.chance(0.5):
            links.append(_switch(draw, root, base, radius, height))
    if draw.chance(0.3):
        _stand(draw, root, links, radius)
    return SynthObject("Kettle", root, links)


def _lid_motion(draw: Draw, mouth: float, height: float) -> Motion:
    """Joint of the lid: it lifts off, or folds up about a line at its rim."""
    if draw.chance(0.55):
        return slider(Y, 0.0, draw.between(0.02, 0.5), rest=draw.pick([0.0, 0.02]))
    opening = draw.between(60.0, 110.0)
    rest = draw.between(10.0, opening) if draw.chance(0.3) else 0.0
    return hinge((0, height + draw.between(0.0, 0.03), -mouth * draw.between(0.9, 1.1)), -X, 0.0, opening, rest=rest)


def _side_handle(draw: Draw, radius: float, mouth: float, height: float) -> Mesh:
    """A grip at the rear, opposite the spout."""
    low, high, out = draw.between(0.1, 0.4) * height, draw.between(0.8, 1.0) * height, radius + draw.between(0.2, 0.4)
    path = [(0, low, -0.8 * radius), (0, low, -out), (0, high, -out), (0, high, -0.9 * mouth)]
    return sweep(rounded_path(np.array(path), 0.15), draw.between(0.03, 0.06), 10)


def _switch(draw: Draw, root: Node, base: Link, radius: float, height: float) -> Link:
    """The switch of an electric kettle: a paddle below or on the handle that tips, or a button that slides in."""
    size = draw.between(0.06, 0.14)
    at = (0.0, draw.pick([0.08, draw.between(0.7, 0.9)]) * height + size, -radius - draw.between(0.05, 0.25))
    if draw.chance(0.6):
        node = root.add(draw.pick(["switch", "lever"]), box((size, 0.4 * size, size), (at[0], at[1], at[2] - 0.5 * size)))
        return Link("lever", [node], base, hinge(at, X, *draw.pick([(0.0, 20.0), (-15.0, 15.0), (-30.0, 0.0)])))
    node = root.add("button", cylinder(0.4 * size, 0.4 * size, "y", at, 14))
    return Link("button", [node], base, slider(-Y, 0.0, 0.2 * size))


def _stand(draw: Draw, root: Node, links: list[Link], radius: float) -> None:
    """Add the powered base. The kettle becomes its child and lifts off it."""
    foot = radius * draw.between(1.0, 1.2)
    profile = np.array([[0, -0.12], [foot, -0.12], [foot, -0.06], [0.8 * foot, 0.0], [0, 0.0]])
    stand = Link("stand", [root.add("base", lathe(profile, 28))], kind=JointType.FREE)
    jug = links[0]
    jug.parent, jug.motion = stand, slider(Y, 0.0, draw.between(0.05, 0.6))
    jug.name = jug.leaf_name = "container"
    links.insert(0, stand)
