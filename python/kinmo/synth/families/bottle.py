"""Bottles, jars, jugs and cans with caps, flip tops, nozzles, stoppers, clasps, pumps, sprays or trigger sprayers."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.bottle_tops import (
    add_aerosol,
    add_cap,
    add_flip_top,
    add_nozzle_top,
    add_pump,
    add_stopper,
    add_swing_top,
    add_trigger,
    cap_pieces,
)
from kinmo.synth.details.vessels import swinging_bow
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, box, lathe, move, rotation_about, rounded_path, sweep, torus, tube, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject

STANDS_ON_CAP_SHARE = 0.05
"""Share of bottles with a wide cap that stand on it."""


def build(draw: Draw) -> SynthObject:
    """Bottle, jar, jug or can with one closure.

    Variants: a cap that screws, lifts off or tips, a flip top, a nozzle that pulls up, a stopper, a swing top, a pump, a spray
    button, a trigger sprayer, and a jug with a bow whose mouth is open or has a fixed cap. Collars may screw.
    """
    height, radius = draw.ratio(0.5, 2.2), draw.ratio(0.16, 0.5)
    neck = radius * draw.pick([draw.between(0.2, 0.6), draw.between(0.6, 0.99)], [3, 2])
    neck_height = height * draw.ratio(0.02, 0.4 if neck < 0.6 * radius else 0.12)
    root = Node("bottle")
    unit = root.add(draw.pick(["normal_bottle", "jug"], [5, 1]))
    still = [unit.add("body", *_body(draw, radius, neck, height))]
    still.append(unit.add("neck", *_neck(draw, neck, height, neck_height, draw.pick([8, 16, 24, 32]))))
    if unit.name == "jug" or draw.chance(0.1):
        still.append(unit.add("handle", _grip(draw, radius, height)))
    base = Link("body", still, kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY], [4, 1, 1]))
    top, most = height + neck_height, 0.55 * height
    place = draw, unit, base, neck, top
    kind = draw.pick(
        ["cap", "flip", "nozzle", "stopper", "swing", "pump", "aerosol", "trigger", "bow"], [9, 3, 2, 2, 1, 3, 1.5, 1.5, 0.7]
    )
    if kind == "bow":
        links = [_bow(draw, unit, base, radius, neck, top)]
    elif kind in ("swing", "pump", "trigger"):
        links = {"swing": add_swing_top, "pump": add_pump, "trigger": add_trigger}[kind](*place)
    else:
        add = {"cap": add_cap, "flip": add_flip_top, "nozzle": add_nozzle_top, "stopper": add_stopper, "aerosol": add_aerosol}
        links = add[kind](*place, most)
    shape = SynthObject("Bottle", root, [base, *links])
    if kind in ("cap", "flip") and neck > 0.5 * radius and draw.chance(STANDS_ON_CAP_SHARE):
        shape.move(rotation_about(X, 180.0))
    return shape


def _body(draw: Draw, radius: float, neck: float, height: float) -> list[Mesh]:
    """The body with a round, oval or square section, closed or with a wall, sometimes with rings, a label or a waist."""
    segments = draw.pick([8, 16, 24, 32, 48])
    shoulder, waist = draw.between(0.45, 0.97), draw.pick([1.0, draw.between(0.7, 1.1)])
    foot = draw.pick([1.0, draw.between(0.75, 1.0)])
    profile = np.array(
        [[foot, 0], [1, 0.04], [waist, 0.5 * shoulder], [1, shoulder], [0.5 * (1 + neck / radius), 0.5 * (1 + shoulder)]]
    )
    outer = np.concatenate([profile * (radius, height), [[neck, height]]])
    if draw.chance(0.25):
        wall = draw.between(0.03, 0.12) * radius
        inner = outer[::-1] - (wall, 0.0)
        outer = np.concatenate([outer, np.maximum(inner, (0.3 * neck, wall)), [[0.0, wall]]])
    mesh = lathe(np.concatenate([[[0.0, 0.0]], outer]), segments)
    if draw.chance(0.35):
        power, flat = draw.pick([2.0, draw.between(2.5, 8.0)]), draw.pick([1.0, draw.ratio(0.4, 1.0)])
        mesh = _with_section(mesh, power, flat, shoulder * height, height)
    pieces = [mesh]
    if waist == 1.0 and draw.chance(0.3):
        rings = draw.integer(1, 5)
        pieces += [torus(radius, 0.012, "y", (0, height * (0.1 + 0.08 * i), 0), segments, 6) for i in range(rings)]
    elif draw.chance(0.15):
        low, high = sorted(draw.between(0.1, shoulder) * height for _ in range(2))
        pieces.append(tube(1.01 * radius, 0.99 * radius, high - low + 0.02, "y", (0, 0.5 * (low + high), 0), segments))
    return pieces


def _with_section(mesh: Mesh, power: float, flat: float, shoulder: float, height: float) -> Mesh:
    """The body with a superelliptic section below its shoulder that becomes round at the neck: 2 is round, 8 nearly square."""
    x, y, z = mesh.vertices.T
    angle = np.arctan2(z, x)
    square = (np.abs(np.cos(angle)) ** power + np.abs(np.sin(angle)) ** power) ** (-1.0 / power)
    round_share = np.clip((y - shoulder) / max(height - shoulder, 0.01), 0.0, 1.0)
    wide = round_share + (1 - round_share) * square
    return Mesh(np.stack([x * wide, y, z * wide * (round_share + (1 - round_share) * flat)], axis=1), mesh.faces)


def _bow(draw: Draw, unit: Node, base: Link, radius: float, neck: float, top: float) -> Link:
    """Add a swinging bow over the mouth, which is open or has a cap that does not move."""
    if draw.chance(0.6):
        tall = neck * draw.ratio(0.3, 1.0)
        fixed = [move(piece, (0, top - 0.5 * tall, 0)) for piece in cap_pieces(draw, 1.1 * neck, tall)]
        base.nodes.append(unit.add("closure", *fixed))
    bow = swinging_bow(draw, base, radius, top, top + radius * draw.between(0.4, 1.0))
    ears = [box((0.06, 0.12, 0.1), (s * (0.9 * radius), bow.motion.origin[1], 0)) for s in (-1, 1)] if bow.motion else []
    base.nodes[0].pieces += ears
    unit.children += bow.nodes
    return bow


def _neck(draw: Draw, neck: float, height: float, length: float, segments: int) -> list[Mesh]:
    """The neck, sometimes with a ring."""
    pieces = [tube(neck, 0.85 * neck, length, "y", (0, height + 0.5 * length, 0), segments)]
    if draw.chance(0.5):
        pieces.append(torus(1.05 * neck, 0.08 * neck, "y", (0, height + draw.between(0.1, 0.6) * length, 0), segments, 6))
    return pieces


def _grip(draw: Draw, radius: float, height: float) -> Mesh:
    """A handle at the side."""
    out = radius * draw.between(0.4, 0.8)
    ends = [(0.4 * radius, 0.25), (radius + out, 0.3), (radius + out, 0.8), (0.2 * radius, 0.85)]
    path = rounded_path(np.array([(x, y * height, 0.0) for x, y in ends]), 0.3 * out)
    return turn(sweep(path, draw.between(0.03, 0.06), 10), Y, draw.pick([0.0, 180.0, 90.0]))
