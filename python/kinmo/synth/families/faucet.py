"""Faucets with switches on vertical, horizontal or leaning stems, and spouts that may swivel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.details.spouts import add_spout, arm_path, neck_path, pull_out_head
from kinmo.synth.details.turning_handles import lever, revolved_cap, turning_handle
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    along,
    box,
    cylinder,
    ellipsoid,
    lathe,
    move,
    rotation,
    rounded_box,
    rounded_path,
    sweep,
    torus,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, screw, slider, spinner


@dataclass
class _Faucet:
    """A faucet under construction: its groups as PartNet names them, and its links."""

    draw: Draw
    frame: Node
    spout: Node
    unit: Node
    base: Link
    links: list[Link]

    def add_switch(self, pieces: list[Mesh], motion: Motion) -> None:
        """Add a switch with its link."""
        node = self.unit.add("switch", *pieces)
        self.links.append(Link("switch", [node], self.base, motion))

    def swivel_spout(self, motion: Motion) -> None:
        """Give the spout a joint. A head that pulls out moves along."""
        swivelling = Link("spout", [self.spout], self.base, motion)
        for link in self.links:
            if link.name == "head":
                link.parent = swivelling
        self.links.append(swivelling)


def build(draw: Draw) -> SynthObject:
    """Faucet with one or two switches.

    Variants: one lever on top, a stick that turns and tips, a lever at the side, two handles, a bridge between two risers, a
    pillar tap, a wall tap, and a wall bar with a switch at each end. Switches turn about their stem or tip; some screw. Some
    spouts swivel, some heads pull out, and some faucets have a pull rod, a spray or a soap pump that slides.
    """
    root = Node("faucet")
    unit = root.add("normal_faucet")
    frame, spout = Node("frame"), Node("spout")
    base = Link("frame", [frame], kind=draw.pick([JointType.STATIC, JointType.FREE, JointType.HEAVY], [4, 1, 1]))
    faucet = _Faucet(draw, frame, spout, unit, base, [base])
    kinds = [_single_lever, _stick, _side_lever, _two_handles, _wall_tap, _wall_pair, _bridge, _pillar_tap]
    draw.pick(kinds, [7, 2, 3, 4, 2, 1, 1.5, 1.5])(faucet)
    if draw.chance(0.12):
        _deck_fitting(faucet)
    unit.children += [node for node in (frame, spout) if node.children]
    if not any(spout in link.nodes for link in faucet.links) and spout.children:
        base.nodes.append(spout)
    if not frame.children:
        base.nodes.remove(frame)
    return SynthObject("Faucet", root, faucet.links)


def _single_lever(faucet: _Faucet) -> None:
    """A post with the spout in front and the switch on top, vertical or leaning forwards."""
    draw = faucet.draw
    radius, height = draw.ratio(0.05, 0.2), draw.ratio(0.3, 1.3)
    _post(faucet, radius, height)
    reach, root_height = draw.ratio(0.35, 1.3), height * draw.between(0.4, 0.9)
    _add_spout(faucet, arm_path(draw, reach, root_height, radius), radius * draw.between(0.4, 0.85))
    if draw.chance(0.15):
        turned = draw.pick([(-90, 90), (-60, 60), (-180, 180)])
        faucet.swivel_spout(hinge((0, draw.pick([0.0, root_height]), 0), Y, *turned))
    top = height + draw.pick([0.0, 0.003, draw.between(-0.02, 0.0)])
    cap = radius * draw.between(0.85, 1.15)
    cap_height = draw.ratio(0.05, 0.35)
    length = draw.ratio(0.2, 1.1)
    arm = lever(draw, length, draw.between(0.018, 0.04), cap_height * draw.between(0.4, 0.95))
    pieces = [revolved_cap(draw, cap, cap_height), *arm]
    if draw.chance(0.18):
        pieces = turning_handle(draw, draw.ratio(0.1, 0.35), cap_height)
    pieces = [move(piece, (0, top, 0)) for piece in pieces]
    lean = draw.between(-30.0, 25.0) if draw.chance(0.2) else 0.0
    axis = np.array([0.0, np.cos(np.radians(lean)), np.sin(np.radians(lean))])
    pieces = [turn(piece, X, lean, (0, top, 0)) for piece in pieces]
    low = (0.0, draw.pick([0.0, top, 0.5 * top]), 0.0) if lean == 0.0 else (0.0, top, 0.0)
    if lean == 0.0 and draw.chance(0.2):
        # The lever lifts about the rear edge of its cap, or in its middle.
        up = draw.between(15.0, 45.0)
        limits, rest = draw.pick([(0.0, up), (-0.3 * up, up)]), draw.pick([0.0, 0.5 * up], [4, 1])
        pivot = (0.0, top + draw.between(0.0, 0.6) * cap_height, draw.pick([0.0, -0.8 * cap]))
        faucet.add_switch(pieces, hinge(pivot, -X, *limits, rest=rest))
        return
    rest = draw.between(-70.0, 70.0) if draw.chance(0.15) else 0.0
    swing = draw.pick([90.0, 60.0, 45.0, 120.0], [5, 1, 1, 1])
    faucet.add_switch(pieces, hinge(low, axis * draw.sign(), -swing, swing, rest=rest))
    if draw.chance(0.2):
        rod = [
            cylinder(0.012, draw.between(0.2, 0.5), "y", (0, height * 0.7, 0), 8),
            cylinder(0.03, 0.04, "y", (0, height, 0), 12),
        ]
        back = -radius - 0.04
        other = faucet.unit.add("other").add("other_leaf")
        # The rod slides along its own axis.
        lean = draw.pick([0.0, draw.between(-35.0, 0.0)])
        other.pieces = [turn(move(p, (0, 0, back)), X, lean, (0, height, back)) for p in rod]
        faucet.links.append(Link("slider", [other], faucet.base, slider(rotation(X, lean) @ Y, 0.0, draw.between(0.03, 0.1))))


def _stick(faucet: _Faucet) -> None:
    """A post with a cap that turns and a stick or lever on it that tips; one of the two joints may be missing."""
    draw = faucet.draw
    radius, height = draw.ratio(0.05, 0.2), draw.ratio(0.15, 1.0)
    _post(faucet, radius, height)
    cap, tall = radius * draw.between(0.7, 1.2), draw.ratio(0.04, 0.25)
    turns, tips = draw.pick([(True, True), (True, False), (False, True)], [3, 1, 2])
    level = height + tall * draw.between(0.3, 1.0)
    lean, length = draw.between(0.0, 80.0), draw.ratio(0.15, 0.8)
    rod = radius * draw.between(0.12, 0.35)
    stick = sweep(np.array([(0, level, 0), (0, level + length, 0)]), rod * np.array([1.0, draw.between(0.5, 1.5)]), 10)
    pieces = [turn(stick, X, lean, (0, level, 0)), ellipsoid(np.full(3, 1.6 * rod), (0, level, 0), 12, 8)]
    if draw.chance(0.3):
        pieces.append(turn(ellipsoid(np.full(3, 1.8 * rod), (0, level + length, 0), 12, 8), X, lean, (0, level, 0)))
    dome = move(revolved_cap(draw, cap, tall), (0, height, 0))
    swing, up, down = draw.between(30.0, 90.0), draw.between(10.0, 40.0), draw.between(0.0, 15.0)
    tipping = hinge((0, level, 0), X * draw.sign(), -up, down) if lean > 45.0 else hinge((0, level, 0), X, -up, up)
    if turns and tips:
        node = faucet.unit.add("switch", dome)
        turning = Link("switch", [node], faucet.base, hinge((0, height, 0), Y * draw.sign(), -swing, swing))
        faucet.links += [turning, Link("lever", [faucet.unit.add(draw.pick(["lever", "switch"]), *pieces)], turning, tipping)]
    elif turns:
        faucet.add_switch([dome, *pieces], hinge((0, height, 0), Y, -swing, swing))
    else:
        faucet.frame.add("vertical_support", dome)
        faucet.add_switch(pieces, tipping)
    if draw.chance(0.5):
        path = arm_path(draw, draw.ratio(0.4, 1.2), height * draw.between(0.4, 0.9), radius)
        _add_spout(faucet, path, radius * draw.between(0.4, 0.85))
    else:
        # The spout stands beside the post.
        _high_spout(faucet, 0.0, radius * draw.between(0.4, 0.9), aside=draw.sign() * draw.between(2.2, 5.0) * radius)


def _side_lever(faucet: _Faucet) -> None:
    """A tall post with a curved spout that may swivel, and a lever on a stub at the side."""
    draw = faucet.draw
    radius, height = draw.ratio(0.04, 0.14), draw.ratio(0.2, 1.0)
    _post(faucet, radius, height)
    stem = height * draw.between(0.35, 0.8)
    side = draw.sign()
    stub = draw.ratio(0.02, 0.25)
    thick = radius * draw.between(0.5, 0.9)
    faucet.frame.add("horizontal_support", cylinder(thick, radius + stub, "x", (side * 0.5 * (radius + stub), stem, 0), 16))
    pieces = turning_handle(draw, draw.between(0.2, 0.45), draw.between(0.05, 0.15))
    pieces = [turn(along(piece, "x"), X, draw.pick([0.0, 90.0, 180.0, draw.between(0.0, 360.0)])) for piece in pieces]
    if side < 0:
        pieces = [turn(piece, Y, 180.0) for piece in pieces]
    at = (side * (radius + stub), stem, 0.0)
    origin = (0, stem, 0) if draw.chance(0.5) else at
    motion = spinner(origin, X) if draw.chance(0.1) else hinge(origin, X, -draw.between(20.0, 90.0), draw.between(0.0, 90.0))
    faucet.add_switch([move(p, at) for p in pieces], motion)
    _high_spout(faucet, height, radius * draw.between(0.6, 1.0))


def _two_handles(faucet: _Faucet) -> None:
    """Two switches beside a spout in the middle, on one plate or each on its own foot."""
    draw = faucet.draw
    apart = draw.ratio(0.25, 0.9)
    foot, stem = draw.ratio(0.04, 0.14), draw.ratio(0.05, 0.4)
    plate = draw.between(0.03, 0.08)
    joined = draw.chance(0.6)
    if joined:
        size = (2 * apart + 3 * foot, plate, 3 * foot)
        faucet.frame.add("surface_base", rounded_box(size, 1.4 * foot, "y", (0, 0.5 * plate, 0), 6))
    else:
        faucet.frame.add("surface_base", *(cylinder(1.4 * foot, plate, "y", (x, 0.5 * plate, 0)) for x in (-apart, 0.0, apart)))
        if draw.chance(0.5):
            level = plate + draw.between(0.2, 0.8) * stem
            faucet.frame.add("horizontal_support", cylinder(0.4 * foot, 2 * apart, "x", (0, level, 0), 14))
    stems = [cylinder(0.8 * foot, stem, "y", (x, plate + 0.5 * stem, 0), 18, top_radius=0.6 * foot) for x in (-apart, apart)]
    faucet.frame.add("vertical_support", *stems)
    lean = draw.between(5.0, 30.0) if draw.chance(0.2) else 0.0
    grip = turning_handle(draw, draw.between(0.15, 0.32), draw.between(0.08, 0.2))
    facing = draw.pick([90.0, 0.0, 45.0])
    screws = draw.chance(0.15)
    for side in (-1.0, 1.0):
        at = (side * apart, plate + stem, 0.0)
        pieces = [turn(move(turn(p, Y, side * facing), at), Z, -side * lean, at) for p in grip]
        axis = (side * np.sin(np.radians(lean)), np.cos(np.radians(lean)), 0.0)
        if screws:
            motion = screw(at, axis, 0.0, draw.between(0.02, 0.06), turns=draw.pick([180.0, 360.0, None]))
        else:
            limits = [(-90, 90), (0, 90), (-45, 45), (0, 180)]
            motion = spinner(at, axis) if draw.chance(0.2) else hinge(at, axis, *draw.pick(limits))
        faucet.add_switch(pieces, motion)
    _high_spout(faucet, plate, foot * draw.between(0.4, 0.7))


def _bridge(faucet: _Faucet) -> None:
    """Two risers with switches on top, a pipe between them, and a spout on its middle."""
    draw = faucet.draw
    apart, radius, rise = draw.ratio(0.2, 0.6), draw.ratio(0.025, 0.07), draw.ratio(0.1, 0.6)
    level, stem = rise * draw.between(0.6, 1.0), radius * draw.between(0.5, 2.5)
    for side in (-1.0, 1.0):
        faucet.frame.add("surface_base", cylinder(radius * draw.between(1.4, 2.2), 0.04, "y", (side * apart, 0.02, 0)))
        faucet.frame.add("vertical_support", cylinder(radius, rise + stem, "y", (side * apart, 0.5 * (rise + stem), 0), 16))
    faucet.frame.add("horizontal_support", cylinder(0.8 * radius, 2 * apart, "x", (0, level, 0), 14))
    grip, spun = turning_handle(draw, draw.between(0.1, 0.3), draw.between(0.06, 0.15)), draw.between(0.0, 180.0)
    for side in (-1.0, 1.0):
        at = (side * apart, rise + stem, 0.0)
        pieces = [move(turn(piece, Y, side * spun), at) for piece in grip]
        motion = draw.pick([hinge(at, side * Y, 0, 90), hinge(at, Y, -90, 90), spinner(at, Y)], [3, 2, 1])
        faucet.add_switch(pieces, motion)
    _high_spout(faucet, level, radius * draw.between(0.6, 1.0))


def _pillar_tap(faucet: _Faucet) -> None:
    """One or two separate taps: a post with a short spout in front and a switch on top that turns or screws."""
    draw = faucet.draw
    radius, height = draw.ratio(0.06, 0.16), draw.ratio(0.25, 0.7)
    places = (0.0,) if draw.chance(0.6) else (-draw.between(2.5, 6.0) * radius, 0.0)
    reach, level, wide = draw.ratio(0.25, 0.8), height * draw.between(0.5, 0.9), draw.between(0.1, 0.28)
    path = np.array([(0, level, 0), (0, level, reach), (0, level - draw.between(0.05, 0.25), reach + 0.02)])
    grip, stem = turning_handle(draw, wide, draw.between(0.06, 0.18)), draw.between(0.02, 0.15)
    rise, limits = draw.between(0.02, 0.06), draw.pick([(-90, 90), (0, 180), (0, 90)])
    style = draw.pick(["screw", "turn", "limited"])
    for x, own in zip(places, draw.identical(len(places)), strict=True):
        drum = cylinder(radius, height, "y", (x, 0.5 * height, 0), 20, top_radius=radius * own.between(0.7, 1.1))
        faucet.frame.add("vertical_support", drum, cylinder(0.5 * radius, stem, "y", (x, height + 0.5 * stem, 0), 12))
        if own.chance(0.6):
            faucet.frame.add("surface_base", cylinder(1.5 * radius, 0.03, "y", (x, 0.015, 0), 24))
        add_spout(own, faucet.spout, rounded_path(path, 0.15, 6) + (x, 0.0, 0.0), radius * own.between(0.4, 0.7))
        at = (x, height + stem, 0.0)
        turning = {"screw": screw(at, Y, 0.0, rise, turns=None), "turn": spinner(at, Y), "limited": hinge(at, Y, *limits)}
        faucet.add_switch([move(piece, at) for piece in grip], turning[style])


def _deck_fitting(faucet: _Faucet) -> None:
    """A hand spray in a holder or a soap pump beside the faucet, both of which slide up and down, or a plug that rests."""
    draw = faucet.draw
    x, radius, tall = draw.sign() * draw.between(0.5, 0.9), draw.ratio(0.03, 0.07), draw.ratio(0.1, 0.35)
    holder = cylinder(1.5 * radius, 0.4 * tall, "y", (x, 0.2 * tall, 0), 16, top_radius=1.2 * radius)
    faucet.frame.add(draw.pick(["surface_base", "vertical_support"]), holder)
    kind = draw.pick(["spray", "pump", "plug"])
    if kind == "plug":
        faucet.frame.add("other_leaf", cylinder(0.8 * radius, 0.2 * tall, "y", (x, 0.45 * tall, 0), 16))
    elif kind == "spray":
        body = cylinder(radius, tall, "y", (x, 0.2 * tall + 0.5 * tall, 0), 14, top_radius=radius * draw.between(0.8, 1.4))
        node = faucet.unit.add(draw.pick(["head", "spray"]), body)
        faucet.links.append(Link("head", [node], faucet.base, slider(Y, 0.0, tall * draw.between(0.8, 2.0))))
    else:
        rod = cylinder(0.4 * radius, tall, "y", (x, 0.3 * tall + 0.5 * tall, 0), 10)
        nozzle = box((0.7 * radius, 0.5 * radius, 4 * radius), (x, 1.3 * tall, 1.5 * radius))
        node = faucet.unit.add(draw.pick(["switch", "other"]), rod, nozzle)
        faucet.links.append(Link("slider", [node], faucet.base, slider(-Y, 0.0, 0.3 * tall)))


def _wall_tap(faucet: _Faucet) -> None:
    """A horizontal pipe from the wall behind, with a bent spout and the switch on a vertical stem."""
    draw = faucet.draw
    radius, length = draw.between(0.06, 0.1), draw.between(0.4, 0.9)
    faucet.frame.add("surface_base", cylinder(radius * draw.between(1.5, 2.5), 0.05, "z", (0, 0, 0.025)))
    faucet.frame.add("horizontal_support", cylinder(radius, length, "z", (0, 0, 0.5 * length), 18))
    mouth = length + draw.between(0.1, 0.4)
    path = [(0, 0, length - 0.05), (0, 0, mouth), (0, -draw.between(0.15, 0.5), mouth + draw.between(0.0, 0.15))]
    _add_spout(faucet, rounded_path(np.array(path), 0.2, 8), 0.85 * radius)
    z, stem = length * draw.between(0.5, 0.9), draw.between(0.12, 0.3)
    faucet.frame.add("vertical_support", cylinder(0.7 * radius, stem, "y", (0, 0.5 * stem, z), 16))
    tilt = draw.pick([0.0, draw.between(-35.0, 35.0)], [3, 1])
    grip = turning_handle(draw, draw.between(0.15, 0.3), draw.between(0.05, 0.12))
    pieces = [turn(move(p, (0, stem, z)), X, tilt, (0, 0, z)) for p in grip]
    axis = (0.0, np.cos(np.radians(tilt)), np.sin(np.radians(tilt)))
    if tilt:
        faucet.frame.children[-1].pieces = [turn(p, X, tilt, (0, 0, z)) for p in faucet.frame.children[-1].pieces]
    rise = draw.between(0.03, 0.08)
    motion = draw.pick([screw((0, 0, z), axis, 0, rise, turns=None), spinner((0, 0, z), axis), hinge((0, 0, z), axis, -90, 90)])
    faucet.add_switch(pieces, motion)


def _wall_pair(faucet: _Faucet) -> None:
    """A horizontal bar with a switch at each end that turns about the bar, and a spout in the middle."""
    draw = faucet.draw
    radius, half = draw.between(0.07, 0.12), draw.between(0.4, 0.7)
    faucet.frame.add("horizontal_support", cylinder(radius, 2 * half, "x", (0, 0, 0), 20))
    feet = [cylinder(0.7 * radius, 0.3, "z", (x, 0, -0.15), 14) for x in (-0.6 * half, 0.6 * half)]
    faucet.frame.add("surface_base", *feet)
    grip = turning_handle(draw, draw.between(0.12, 0.25), draw.between(0.1, 0.2))
    for side in (-1.0, 1.0):
        pieces = [move(turn(along(p, "x"), Y, 0.0 if side > 0 else 180.0), (side * half, 0, 0)) for p in grip]
        faucet.add_switch(pieces, hinge((side * half * draw.pick([0.0, 1.0]), 0, 0), X, *draw.pick([(-90, 90), (0, 120)])))
    path = [(0, 0, 0.5 * radius), (0, 0, draw.between(0.3, 0.6)), (0, -draw.between(0.1, 0.3), draw.between(0.55, 0.8))]
    _add_spout(faucet, rounded_path(np.array(path), 0.15), 0.5 * radius)


def _post(faucet: _Faucet, radius: float, height: float) -> None:
    """Add the post, round, conical, square or vase-shaped, with its flange and rings."""
    draw = faucet.draw
    foot = draw.between(0.02, 0.08)
    if draw.chance(0.6):
        flange = radius * draw.between(1.15, 1.7)
        faucet.frame.add("surface_base", cylinder(flange, foot, "y", (0, 0.5 * foot, 0), 24))
    kind = draw.pick(["round", "cone", "square", "vase"], [5, 2, 2, 1])
    if kind == "square":
        post = box((1.8 * radius, height, 1.8 * radius), (0, 0.5 * height, 0))
    elif kind == "vase":
        profile = [[0, 0], [1.2, 0], [0.8, 0.2], [0.7, 0.5], [1.05, 0.75], [1.0, 1.0], [0, 1]]
        post = lathe(np.array(profile) * (radius, height), 20)
    else:
        wide = radius * (draw.between(1.1, 1.6) if kind == "cone" else 1.0)
        post = cylinder(wide, height, "y", (0, 0.5 * height, 0), 24, top_radius=radius)
    rings = [torus(1.02 * radius, 0.015, "y", (0, height * draw.between(0.2, 0.95), 0))] if draw.chance(0.25) else []
    faucet.frame.add("vertical_support", post, *rings)


def _high_spout(faucet: _Faucet, foot: float, radius: float, aside: float = 0.0) -> None:
    """Add a spout that stands on `foot`, `aside` along x, and may swivel about a vertical line."""
    draw = faucet.draw
    _add_spout(faucet, neck_path(draw, foot) + (aside, 0.0, 0.0), radius)
    if aside:
        faucet.frame.add("surface_base", cylinder(1.4 * radius, 0.04, "y", (aside, foot + 0.02, 0)))
    if draw.chance(0.55):
        turned = draw.between(-60.0, 60.0) if draw.chance(0.2) else 0.0
        limits = draw.pick([(-90, 90), (-60, 60), (-180, 180)])
        faucet.swivel_spout(hinge((aside, draw.pick([0.0, foot]), 0), Y, *limits, rest=turned))


def _add_spout(faucet: _Faucet, path: NDArray[np.float64], radius: float) -> None:
    """Add the spout along a path [N, 3], sometimes with a head that pulls out of its end."""
    draw = faucet.draw
    add_spout(draw, faucet.spout, path, radius)
    if draw.chance(0.15):
        pieces, motion = pull_out_head(draw, path, radius)
        faucet.links.append(Link("head", [faucet.unit.add(draw.pick(["head", "spray"]), *pieces)], faucet.base, motion))
