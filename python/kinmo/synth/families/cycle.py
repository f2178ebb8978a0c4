"""Bicycles, tricycles, kick scooters and motor scooters with steered forks, wheels, cranks, pedals and stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.synth.details.wheels import wheel_pieces
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    box,
    box_between,
    cylinder,
    ellipsoid,
    extrude,
    join,
    move,
    rounded_box,
    rounded_path,
    sweep,
    torus,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, spinner


@dataclass(frozen=True, eq=False)
class _Head:
    """The steering head: the lower and the upper end [3] of its axis, and the front axle [3]."""

    low: Vector
    high: Vector
    axle: Vector

    @property
    def axis(self) -> Vector:
        """Unit direction [3] upwards."""
        return np.asarray((self.high - self.low) / np.linalg.norm(self.high - self.low))

    def at(self, height: float) -> Vector:
        """Point [3] of the axis at a height."""
        return np.asarray(self.low + self.axis * (height - self.low[1]) / self.axis[1])


def build(draw: Draw) -> SynthObject:
    """Cycle that heads for +z. The fork turns with the handlebar and carries the front wheel.

    Variants: a bicycle, a tricycle, a kick scooter and a motor scooter. Wheels and cranks turn, pedals turn on their crank,
    and a side stand folds.
    """
    kind = draw.pick(["bicycle", "tricycle", "kick", "motor"], [4, 1.5, 3, 2])
    root = Node("vehicle")
    base = Link("frame", [], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    radius = {"kick": draw.ratio(0.06, 0.15), "motor": draw.ratio(0.18, 0.32)}.get(kind, draw.ratio(0.2, 0.36))
    base_length = {"kick": draw.between(0.7, 1.0), "motor": draw.between(1.1, 1.5)}.get(kind, draw.between(0.9, 1.2))
    z, rake = base_length / 2, draw.between(0.0, 28.0)
    axle = np.array([0.0, radius, z])
    slope = np.array([0.0, np.cos(np.radians(rake)), -np.sin(np.radians(rake))])
    offset = np.array([0.0, 0.0, -draw.between(0.0, 0.25) * radius])
    low = axle + offset + slope * 1.25 * radius / slope[1]
    tall = {"kick": draw.between(0.1, 0.2)}.get(kind, draw.between(0.12, 0.3))
    head = _Head(low, low + slope * tall, axle)
    links = [base]
    rod = draw.ratio(0.012, 0.03)
    if kind == "kick":
        _kick_frame(draw, root, base, head, radius, z, rod)
    elif kind == "motor":
        links += _motor_frame(draw, root, base, head, radius, z, rod)
    else:
        links += _bicycle_frame(draw, root, base, head, radius, z, rod)
    links += _fork(draw, root, base, head, radius, rod, kind)
    thick = radius * (draw.between(0.08, 0.2) if kind in ("bicycle", "tricycle") else draw.between(0.2, 0.5))
    sides = (-1.0, 1.0) if kind == "tricycle" or (kind == "kick" and draw.chance(0.15)) else (0.0,)
    for own, side in zip(draw.identical(len(sides)), sides, strict=True):
        at = np.array([side * 0.3, radius, -z])
        links.append(_wheel(own, root, base, at, radius, thick))
    if len(sides) > 1:
        base.nodes.append(root.add("axle", cylinder(rod, 0.6, "x", (0, radius, -z), 10)))
    front = next(link for link in links if link.name == "fork")
    links.append(_wheel(draw, root, front, axle, radius * draw.pick([1.0, 1.0, 0.97]), thick))
    if draw.chance(0.35) and len(sides) == 1:
        foot = np.array([-2 * rod - thick, radius, -0.5 * z])
        drop = min(1.0, 0.95 * radius / 0.3) * 0.3
        stand = sweep(np.array([foot, foot + (-0.05, -0.9 * min(drop, radius), 0.05)]), 0.6 * rod, 8)
        links.append(
            Link("stand", [root.add(draw.pick(["stand", "kickstand", "leg"]), stand)], base, hinge(foot, X, 0.0, 90.0))
        )
    return SynthObject("vehicle", root, links)


def _wheel(draw: Draw, root: Node, carrier: Link, at: Vector, radius: float, thick: float) -> Link:
    """Add a wheel that rolls about x: a thin tyre with spokes, or any wheel."""
    if draw.chance(0.5):
        rim = 0.5 * max(thick, 0.05 * radius)
        count = draw.integer(3, 14)
        spoke = cylinder(draw.between(0.01, 0.04) * radius, radius - rim, "y", (0, (radius - rim) / 2, 0), 6)
        pieces = [torus(radius - rim, rim, "x"), cylinder(0.1 * radius, 2 * thick, "x", segments=12)]
        pieces += [turn(spoke, X, 360.0 * index / count) for index in range(count)]
    else:
        pieces = wheel_pieces(draw, radius, thick)
    node = root.add("wheel", *(move(piece, at) for piece in pieces))
    return Link("wheel", [node], carrier, spinner(at, X))


def _fork(draw: Draw, root: Node, base: Link, head: _Head, radius: float, rod: float, kind: str) -> list[Link]:
    """Add the fork, steerer and handlebar as one part that turns in the head."""
    gap = radius * (0.25 if kind in ("kick", "motor") else 0.15) + rod + 0.02
    pieces: list[Mesh] = []
    sides = (-1.0, 1.0) if draw.chance(0.85) else (1.0,)
    for side in sides:
        path = np.array([head.axle + (side * gap, 0, 0), head.low + (side * gap, 0, 0), head.low])
        pieces.append(sweep(rounded_path(path, 0.3 * gap), 0.8 * rod, 8))
    rise = {"kick": draw.between(0.6, 0.9)}.get(kind, draw.between(0.1, 0.35))
    top = head.at(head.high[1] + rise)
    pieces.append(sweep(np.array([head.low, top]), 0.9 * rod, 10))
    half, form = draw.between(0.2, 0.35), draw.pick(["straight", "raised", "swept", "drop"], [4, 3, 3, 1])
    ahead = draw.pick([0.0, draw.between(0.02, 0.1)])
    stem = top + (0, 0, ahead)
    if ahead:
        pieces.append(sweep(np.array([top, stem]), 0.9 * rod, 8))
    shapes: dict[str, list[tuple[float, float, float]]] = {
        "straight": [(half, 0, 0)],
        "raised": [(0.3 * half, 0, 0), (0.45 * half, 0.1, -0.03), (half, 0.12, -0.08)],
        "swept": [(0.5 * half, 0.03, 0.0), (half, 0.02, -0.18)],
        "drop": [(half, 0, 0.0), (half, 0, 0.1), (half, -0.14, 0.1), (half, -0.14, -0.05)],
    }
    right = [stem + np.array(end) for end in shapes[form]]
    left = [point * (-1, 1, 1) for point in reversed(right)]
    bar = rounded_path(np.array([*left, stem, *right]), 0.05)
    pieces.append(sweep(bar, 0.8 * rod, 8))
    for end, before in ((right[-1], right[-2] if len(right) > 1 else stem), (left[0], left[1] if len(left) > 1 else stem)):
        along = (end - before) / np.linalg.norm(end - before)
        pieces.append(sweep(np.array([end - 0.1 * along, end]), 1.3 * rod, 10))
    if draw.chance(0.3):
        pieces.append(rounded_box((0.25, 0.2, 0.18), 0.05, "y", head.high + (0, 0.05, 0.15 + 2 * rod)))
    if draw.chance(0.25):
        pieces.append(cylinder(0.05, 0.06, "z", head.high + (0, 0.03, 0.05 + rod), 16))
    node = root.add(draw.pick(["fork", "steering", "handlebar"]), *([join(*pieces)] if draw.chance(0.4) else pieces))
    swing = draw.between(35.0, 90.0)
    rest = draw.pick([0.0, draw.sign() * draw.between(0.1, 0.6) * swing], [3, 1])
    return [Link("fork", [node], base, hinge(head.low, head.axis, -swing, swing, rest=rest))]


def _head_tube(head: _Head, rod: float) -> Mesh:
    """The tube of the frame that the steerer turns in."""
    return sweep(np.array([head.low + 0.01 * head.axis, head.high]), 1.5 * rod, 14)


def _saddle(draw: Draw, root: Node, base: Link, at: Vector) -> None:
    """A saddle: a wedge, a long seat or an ellipsoid."""
    kind = draw.pick(["wedge", "ellipsoid", "box"])
    if kind == "wedge":
        outline = np.array([(-0.13, -0.08), (0.15, -0.02), (0.15, 0.02), (-0.13, 0.08)])
        seat = extrude(outline, 0.05, "y", at)
    elif kind == "ellipsoid":
        seat = ellipsoid((0.08, 0.04, 0.15), at, 14, 8)
    else:
        seat = rounded_box((0.16, 0.06, 0.28), 0.05, "y", at)
    base.nodes.append(root.add(draw.pick(["seat", "saddle"]), seat))


def _bicycle_frame(draw: Draw, root: Node, base: Link, head: _Head, radius: float, z: float, rod: float) -> list[Link]:
    """Tubes between head, seat, crank and rear axle; the crank with its pedals."""
    crank = np.array([0.0, radius * draw.between(0.8, 1.0), draw.between(-0.15, 0.0) * z])
    seat = np.array([0.0, max(head.high[1], 2.2 * radius) + draw.between(0.0, 0.15), crank[2] - draw.between(0.1, 0.25)])
    rear = np.array([0.0, radius, -z])
    lower_seat = crank + 0.8 * (seat - crank)
    tubes = [(head.low + 0.3 * (head.high - head.low), crank), (crank, seat)]
    if draw.chance(0.75):
        tubes.append((head.high, lower_seat))
    pieces = [sweep(np.array(pair), rod, 10) for pair in tubes]
    gap = 0.15 * radius + 0.03
    for side in (-1.0, 1.0):
        stays = [(side * 0.5 * gap, 0, 0), (side * gap, 0, 0)]
        pieces.append(sweep(np.array([crank + stays[0], rear + stays[1]]), 0.6 * rod, 8))
        pieces.append(sweep(np.array([lower_seat + stays[0], rear + stays[1]]), 0.6 * rod, 8))
    pieces.append(cylinder(1.6 * rod, 0.08, "x", crank, 14))
    pieces.append(_head_tube(head, rod))
    base.nodes.append(root.add("frame", *([join(*pieces)] if draw.chance(0.5) else pieces)))
    _saddle(draw, root, base, seat + (0, 0.03, 0))
    if draw.chance(0.3):
        rack = box((0.14, 0.02, 0.35), (0, 2.15 * radius, -z))
        base.nodes.append(root.add("rack", rack))
    if draw.chance(0.2):
        return []
    arm, wide = draw.between(0.4, 0.6) * radius, draw.between(0.07, 0.1)
    angle = draw.between(0.0, 360.0)
    reach = turn(cylinder(0.5 * rod, arm, "y", (0, arm / 2, 0), 8), X, angle)
    ends = {side: crank + (side * wide, 0, 0) for side in (-1.0, 1.0)}
    spindle = [cylinder(0.6 * rod, 2 * wide, "x", crank, 10), move(reach, ends[1.0]), move(turn(reach, X, 180.0), ends[-1.0])]
    if draw.chance(0.8):
        spindle.append(cylinder(draw.between(0.2, 0.4) * radius, 0.01, "x", crank + (0.6 * wide, 0, 0), 24))
    link = Link("crank", [root.add("crank", *spindle)], base, spinner(crank, X))
    links = [link]
    tip = np.array([0.0, np.cos(np.radians(angle)), np.sin(np.radians(angle))]) * arm
    for side in (1.0, -1.0):
        at = ends[side] + side * tip + (side * 0.06, 0, 0)
        pedal = root.add("pedal", box((0.09, 0.02, 0.08), at))
        if draw.chance(0.7):
            links.append(Link("pedal", [pedal], link, spinner(at, X)))
        else:
            link.nodes.append(pedal)
    return links


def _kick_frame(draw: Draw, root: Node, base: Link, head: _Head, radius: float, z: float, rod: float) -> None:
    """A deck with a neck up to the head, and cheeks or a mudguard at the rear wheel."""
    thick, half = draw.between(0.02, 0.05), draw.between(0.05, 0.09)
    level = radius * draw.between(0.8, 1.4)
    near, far = head.low[2] - 1.6 * radius, -z + 1.2 * radius
    deck = rounded_box((2 * half, thick, near - far), 0.3 * half, "y", (0, level, (near + far) / 2))
    neck = sweep(np.array([(0, level, near - 0.02), 0.5 * (head.low + head.high)]), 1.4 * rod, 10)
    cheeks = [box_between((s * half - 0.008, 0.7 * radius, -z - 0.02), (s * half + 0.008, level, far + 0.02)) for s in (-1, 1)]
    base.nodes.append(root.add(draw.pick(["frame", "deck", "body"]), deck, neck, *cheeks, _head_tube(head, rod)))
    if draw.chance(0.4):
        guard = box((1.4 * half, 0.01, 1.6 * radius), (0, 2.2 * radius, -z))
        base.nodes.append(
            root.add("fender", guard, box((0.02, 2.2 * radius - level, 0.02), (0, 1.1 * radius + level / 2, far)))
        )


def _motor_frame(draw: Draw, root: Node, base: Link, head: _Head, radius: float, z: float, rod: float) -> list[Link]:
    """A step-through body: a shield behind the head, a floor, and a block over the rear wheel with a seat that may fold up."""
    half, level = draw.between(0.12, 0.2), radius * draw.between(0.9, 1.2)
    seat = level + draw.between(0.35, 0.5)
    back = head.high[2] - 0.06
    shield = turn(box((2 * half, head.high[1] - level + 0.1, 0.05)), X, -draw.between(0.0, 15.0))
    shield = move(shield, (0, 0.5 * (head.high[1] + level), min(back, head.low[2] - 2 * rod - 0.08)))
    floor = box_between((-half, level - 0.05, -0.25 * z), (half, level, shield.vertices[:, 2].max()))
    low = max(2.15 * radius, level + 0.05)
    block = box_between((-half, low, -z - 0.1), (half, max(seat, low + 0.1), -0.2 * z))
    link = box_between((-0.9 * half, level - 0.05, -0.35 * z), (0.9 * half, low + 0.02, -0.2 * z))
    arms = [box((0.03, 0.04, z), (s * (half + 0.02), radius, -0.65 * z)) for s in (-1, 1)]
    neck = sweep(np.array([shield.vertices.mean(axis=0), 0.5 * (head.low + head.high)]), 1.5 * rod, 8)
    base.nodes.append(root.add("body", shield, floor, block, link, *arms, neck, _head_tube(head, rod)))
    cushion = rounded_box((1.7 * half, 0.08, 0.8 * z), 0.05, "y", (0, max(seat, low + 0.1) + 0.04, -0.65 * z))
    node, links = root.add("seat", cushion), []
    if draw.chance(0.5):
        low, high = cushion.vertices.min(axis=0), cushion.vertices.max(axis=0)
        links.append(Link("seat", [node], base, hinge((0, low[1], high[2]), X, 0.0, draw.between(50.0, 90.0))))
    else:
        base.nodes.append(node)
    return links
