"""Valves on pipes, with wheels, levers or tees that turn about their stem."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.turning_handles import lever, lobed_knob, revolved_cap, spokes, wheel
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    box,
    cylinder,
    ellipsoid,
    move,
    rotation_about,
    rounded_path,
    sweep,
    torus,
    transform,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, screw, spinner


def build(draw: Draw) -> SynthObject:
    """Pipe with one to three valves. Wheels turn freely or rise as screws; levers turn by a quarter.

    The pipe is straight, bent, or branches off; flanges, bolts, gauges and supports are fixed.
    """
    root = Node("faucet")
    radius = draw.ratio(0.05, 0.14)
    count = draw.pick([1, 2, 3], [5, 2, 1])
    pitch = radius * draw.between(6.0, 10.0)
    half = 0.5 * count * pitch * draw.between(0.9, 1.4)
    base = Link("pipe", [], kind=draw.pick([JointType.STATIC, JointType.FREE, JointType.HEAVY]))
    links = [base]
    _add_pipe(draw, root, base, half, radius)
    same = draw.identical(count) if draw.chance(0.7) else [draw] * count
    about = draw.pick([0.0, 0.0, 90.0, -90.0, 180.0, draw.between(-180.0, 180.0)])
    for index, own in enumerate(same):
        at = np.array([pitch * (index + 0.5 - count / 2), 0.0, 0.0])
        place = rotation_about(X, about)
        place[:3, 3] = at
        links.append(_valve(own, root, base, radius, place))
    shape = SynthObject("Faucet", root, links)
    if draw.chance(0.4):
        shape.move(rotation_about(draw.pick([Y, Z]), draw.pick([90.0, -90.0, 180.0])))
    return shape


def _add_pipe(draw: Draw, root: Node, base: Link, half: float, radius: float) -> None:
    """Add a pipe along x, with flanges at its ends, a bend or a branch, and sometimes supports."""
    kind = draw.pick(["straight", "bent", "branch"], [4, 2, 2])
    if kind == "bent":
        drop = draw.between(0.3, 0.8) * half * draw.sign()
        corners = [(-half, 0, 0), (half, 0, 0), (half, drop, 0)]
        if draw.chance(0.4):
            corners = [(-half, draw.sign() * drop, 0), *corners]
        pipe = [sweep(rounded_path(np.array(corners), 2.5 * radius), 0.75 * radius, 16)]
    else:
        pipe = [cylinder(0.75 * radius, 2 * half, "x", segments=20)]
        if kind == "branch":
            place = draw.between(-0.9, 0.9) * half
            pipe.append(cylinder(0.7 * radius, 0.7 * half, "z", (place, 0, -0.35 * half), 20))
    base.nodes.append(root.add(draw.pick(["pipe", "body", "tube"]), *pipe))
    if draw.chance(0.6):
        for end in (-1, 1) if kind != "bent" else (-1,):
            flange = cylinder(1.5 * radius, 0.35 * radius, "x", (end * half, 0, 0), 24)
            bolt = cylinder(0.14 * radius, 0.6 * radius, "x", (end * half, 1.2 * radius, 0), 6)
            bolts = [turn(bolt, X, 60.0 * i) for i in range(6)] if draw.chance(0.5) else []
            base.nodes.append(root.add("flange", flange, *bolts))
    if draw.chance(0.3):
        low = draw.between(3.0, 7.0) * radius
        posts = [box((0.6 * radius, low, 1.2 * radius), (s * 0.7 * half, -low / 2, 0)) for s in (-1, 1)]
        base.nodes.append(root.add("support", *posts, box((2 * half, 0.3 * radius, 4 * radius), (0, -low, 0))))
    if draw.chance(0.2):
        face = cylinder(0.9 * radius, 0.4 * radius, "z", (0.45 * half, 2.2 * radius, 0), 20)
        base.nodes.append(root.add("gauge", face, cylinder(0.2 * radius, 2 * radius, "y", (0.45 * half, radius, 0), 10)))


def _valve(draw: Draw, root: Node, base: Link, radius: float, place: np.ndarray) -> Link:
    """Add a valve's body, bonnet and stem along +y of a place on the pipe, and its handle; returns the handle's link."""
    body: list[Mesh] = []
    kind = draw.pick(["ball", "barrel", "block", "wafer"], [3, 3, 2, 1])
    if kind == "ball":
        body.append(ellipsoid(np.array([1.3, 1.1, 1.1]) * radius, (0, 0, 0), 18, 10))
    elif kind == "barrel":
        body.append(cylinder(1.15 * radius, 2.6 * radius, "x", segments=20))
        body.append(cylinder(radius, 1.4 * radius, "y", (0, 0.7 * radius, 0), 18))
    elif kind == "block":
        body.append(box(np.array([2.2, 2.0, 2.0]) * radius))
    else:
        body.append(cylinder(1.5 * radius, 0.7 * radius, "x", segments=24))
    for side in (-1, 1) if draw.chance(0.6) else ():
        hexagon = cylinder(1.1 * radius, 0.5 * radius, "x", (side * 1.5 * radius, 0, 0), draw.pick([6, 20]))
        body.append(hexagon)
    stem = radius * draw.between(1.6, 3.5)
    body.append(cylinder(radius * draw.between(0.5, 0.8), 0.8 * stem, "y", (0, 0.4 * stem, 0), draw.pick([6, 16])))
    if draw.chance(0.5):
        body.append(cylinder(0.2 * radius, stem, "y", (0, 0.5 * stem, 0), 10))
    if draw.chance(0.25):
        yoke = [box((0.2 * radius, 0.8 * stem, 0.3 * radius), (s * 0.7 * radius, 0.6 * stem, 0)) for s in (-1, 1)]
        body += [*yoke, box((1.6 * radius, 0.2 * radius, 0.4 * radius), (0, stem, 0))]
    base.nodes.append(root.add(draw.pick(["valve_body", "body", "base_body"]), *(transform(p, place) for p in body)))
    handle, turns, name = _handle(draw, radius)
    pieces = [transform(move(piece, (0, stem, 0)), place) for piece in handle]
    node = root.add(draw.pick([name, "switch", "handle"]), *pieces)
    axis, origin = place[:3, :3] @ Y, place[:3, :3] @ (Y * stem) + place[:3, 3]
    return Link("switch", [node], base, _motion(draw, origin, axis, radius, turns=turns), leaf_name="switch")


def _handle(draw: Draw, radius: float) -> tuple[list[Mesh], bool, str]:
    """Meshes of a handle about y, whether it makes whole turns, and its name."""
    reach, rod = radius * draw.between(1.5, 3.5), radius * draw.between(0.12, 0.25)
    hub = revolved_cap(draw, radius * draw.between(0.3, 0.5), 2.5 * rod)
    kind = draw.pick(["wheel", "lever", "tee", "spokes", "lobed", "butterfly"], [5, 6, 2, 2, 1, 1])
    if kind == "wheel":
        pieces = [hub, *wheel(draw, reach, rod, rod)]
        if draw.chance(0.2):
            pieces.append(cylinder(rod, 4 * rod, "y", (0, 2 * rod, reach), 10))
        return pieces, True, "wheel"
    if kind == "spokes":
        return [hub, *spokes(draw, reach, rod, rod)], True, "wheel"
    if kind == "lobed":
        return lobed_knob(draw, 0.6 * reach, 3 * rod), True, "knob"
    angle = draw.pick([0.0, 90.0, -90.0, 180.0])
    if kind == "tee":
        return [hub, turn(cylinder(rod, 2 * reach, "x", (0, 1.5 * rod, 0), 10), Y, angle)], True, "lever"
    if kind == "butterfly":
        wing = box((1.2 * reach, 2.0 * rod, 0.5 * rod), (0, 2 * rod, 0))
        return (
            [hub, turn(wing, Y, angle), turn(torus(0.3 * reach, 0.3 * rod, "z", (0, 2 * rod, 0), 14), Y, angle)],
            False,
            "lever",
        )
    arm = lever(draw, 1.4 * reach, rod, 1.5 * rod)
    if draw.chance(0.4):
        arm.append(cylinder(1.5 * rod, 0.6 * reach, "z", (0, 1.5 * rod, 1.1 * reach), 10))
    return [hub, *(turn(piece, Y, angle) for piece in arm)], False, "lever"


def _motion(draw: Draw, origin: np.ndarray, axis: np.ndarray, radius: float, *, turns: bool) -> Motion:
    """Free turns or a screw for wheels, a quarter turn for levers."""
    if not turns:
        return hinge(origin, axis * draw.sign(), *draw.pick([(0.0, 90.0), (-90.0, 0.0), (-45.0, 45.0)], [4, 2, 1]))
    if draw.chance(0.12):
        return screw(origin, axis, 0.0, draw.between(0.3, 0.9) * radius)
    return spinner(origin, axis)
