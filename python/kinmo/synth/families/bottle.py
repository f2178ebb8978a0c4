"""Bottles and jars with screw caps, lift-off caps, flip tops, pumps or trigger sprayers."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.lid_hinges import lid_hinge
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, box, cylinder, extrude, lathe, move, rounded_path, sweep, torus, tube, turn
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, screw, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Bottle, jar or jug with one closure.

    Variants: a cap that screws, a cap that lifts off, a flip top hinged at the rear, a pump, and a trigger sprayer. The head of
    a pump slides down. A trigger turns or slides, and a nozzle turns. Collars of pumps and sprayers may screw.
    """
    height = draw.between(0.6, 2.0)
    radius = draw.between(0.2, 0.42)
    neck = radius * draw.pick([draw.between(0.25, 0.6), draw.between(0.7, 0.97)], [3, 2])
    neck_height = height * draw.between(0.05, 0.4 if neck < 0.6 * radius else 0.12)
    segments = draw.pick([8, 16, 24, 32])
    root = Node("bottle")
    unit = root.add(draw.pick(["normal_bottle", "jug"], [5, 1]))
    still = [unit.add("body", *_body(draw, radius, neck, height, segments))]
    still.append(unit.add("neck", *_neck(draw, neck, height, neck_height, segments)))
    if unit.name == "jug" or draw.chance(0.1):
        still.append(unit.add("handle", _grip(draw, radius, height)))
    base = Link("body", still, kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY], [4, 1, 1]))
    top = height + neck_height
    kind = draw.pick(["screw", "lift", "flip", "pump", "trigger"], [6, 2, 2, 2, 1])
    if kind == "pump":
        return SynthObject("Bottle", root, [base, *_pump(draw, unit, base, neck, top)])
    if kind == "trigger":
        return SynthObject("Bottle", root, [base, *_trigger(draw, unit, base, neck, top)])
    cap_height = neck * draw.between(0.4, 1.6)
    pieces = _cap(draw, neck * draw.between(1.02, 1.25), cap_height, segments)
    sunk = draw.pick([cap_height * draw.between(0.5, 0.95), 0.0], [4, 1])
    low = top - sunk
    rise = draw.between(0.4, 1.3) * cap_height
    motion: Motion
    strap: list[Mesh] = []
    if kind == "screw":
        origin = (0.0, draw.pick([0.0, low]), 0.0)
        turns = draw.pick([180.0, 360.0, None], [4, 1, 1])
        upwards = draw.chance(0.7)
        motion = screw(origin, Y, 0.0, rise, turns=turns) if upwards else screw(origin, -Y, -rise, 0.0, turns=turns)
    elif kind == "lift":
        motion = slider(Y, 0.0, rise)
    else:
        at = (0.0, low + draw.pick([0.0, 0.1 * cap_height]), -neck * draw.between(1.0, 1.2))
        rest = -draw.between(20.0, 120.0) if draw.chance(0.4) else 0.0
        motion = hinge(at, X, -130.0, 0.0, rest=rest)
        strap = lid_hinge(draw, at, neck, 0.1 * neck)
    lid = unit.add("lid", *(move(piece, (0, low, 0)) for piece in pieces), *strap)
    return SynthObject("Bottle", root, [base, Link(draw.pick(["lid", "closure"]), [lid], base, motion)])


def _body(draw: Draw, radius: float, neck: float, height: float, segments: int) -> list[Mesh]:
    """The body, round or oval, sometimes with rings."""
    shoulder = draw.between(0.55, 0.95)
    waist = draw.between(0.8, 1.05)
    curve = np.array(
        [[0.9, 0], [1, 0.04], [waist, 0.5 * shoulder], [1, shoulder], [0.5 * (1 + neck / radius), 0.5 * (1 + shoulder)]]
    )
    profile = np.concatenate([[[0.0, 0.0]], curve * (radius, height), [[neck, height]]])
    if draw.chance(0.2):
        # A flask with an oval section that becomes round at the neck.
        mesh = lathe(profile, segments)
        flat = draw.between(0.5, 0.8)
        share = np.clip((mesh.vertices[:, 1] / height - shoulder) / max(1 - shoulder, 0.01), 0.0, 1.0)
        vertices = mesh.vertices.copy()
        vertices[:, 2] *= flat + (1 - flat) * share
        return [Mesh(vertices, mesh.faces)]
    pieces = [lathe(profile, segments)]
    if draw.chance(0.25):
        rings = draw.integer(2, 5)
        pieces += [torus(radius, 0.012, "y", (0, height * (0.1 + 0.08 * i), 0), segments, 6) for i in range(rings)]
    return pieces


def _neck(draw: Draw, neck: float, height: float, length: float, segments: int) -> list[Mesh]:
    """The neck, sometimes with a ring."""
    pieces = [tube(neck, 0.85 * neck, length, "y", (0, height + 0.5 * length, 0), segments)]
    if draw.chance(0.5):
        pieces.append(torus(1.05 * neck, 0.08 * neck, "y", (0, height + draw.between(0.1, 0.6) * length, 0), segments, 6))
    return pieces


def _cap(draw: Draw, radius: float, height: float, segments: int) -> list[Mesh]:
    """Meshes of a cap with its foot at the origin: plain, tapered, ribbed, domed or with a nozzle."""
    kind = draw.pick(["plain", "tapered", "ribbed", "domed", "nozzle"], [4, 2, 2, 1, 1])
    if kind == "ribbed":
        angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        reach = radius * (1 + 0.05 * np.sign(np.sin(12 * angle)))
        return [extrude(np.stack([reach * np.cos(angle), reach * np.sin(angle)], 1), height, "y", (0, 0.5 * height, 0))]
    if kind == "domed":
        share = np.linspace(0, 0.5 * np.pi, 6)
        skin = np.stack([radius * np.cos(share), 0.4 * height + 0.6 * height * np.sin(share)], 1)
        return [lathe(np.concatenate([[[0.0, 0.0], [radius, 0.0]], skin]), segments)]
    top = radius * (draw.between(0.5, 0.95) if kind == "tapered" else 1.0)
    pieces = [cylinder(radius, height, "y", (0, 0.5 * height, 0), segments, top_radius=top)]
    if kind == "nozzle":
        pieces.append(cylinder(0.4 * radius, height, "y", (0, 1.5 * height, 0), 14, top_radius=0.15 * radius))
    return pieces


def _grip(draw: Draw, radius: float, height: float) -> Mesh:
    """A handle at the side."""
    out = radius * draw.between(0.4, 0.8)
    ends = [(0.9 * radius, 0.25), (radius + out, 0.3), (radius + out, 0.8), (0.8 * radius, 0.85)]
    path = rounded_path(np.array([(x, y * height, 0.0) for x, y in ends]), 0.3 * out)
    return turn(sweep(path, draw.between(0.03, 0.06), 10), Y, draw.pick([0.0, 180.0, 90.0]))


def _pump(draw: Draw, unit: Node, base: Link, neck: float, top: float) -> list[Link]:
    """A pump: a collar that may screw, and a head with a spout that slides down."""
    collar_height, travel = neck * draw.between(0.4, 0.9), neck * draw.between(0.5, 1.2)
    collar = cylinder(1.1 * neck, collar_height, "y", (0, top, 0), 20)
    stem_top = top + 0.5 * collar_height + travel
    stem = cylinder(0.25 * neck, 2 * travel, "y", (0, stem_top - 0.9 * travel, 0), 12)
    reach = neck * draw.between(1.5, 3.0)
    nozzle = sweep(rounded_path(np.array([(0, 0, 0), (0, 0.1, 0.7 * reach), (0, -0.02, reach)]), 0.2), 0.18 * neck, 10)
    head = [stem, cylinder(0.5 * neck, 0.3 * neck, "y", (0, stem_top, 0), 16), move(nozzle, (0, stem_top, 0))]
    if draw.chance(0.3):
        head.append(box((1.2 * neck, 0.1 * neck, 1.6 * neck), (0, stem_top + 0.2 * neck, 0)))
    closure = Link("closure", [unit.add("closure", collar)], base)
    if draw.chance(0.6):
        closure.motion = screw((0, top, 0), Y, 0.0, collar_height, turns=draw.pick([180.0, None]))
    pressed = slider(Y, -travel, 0.0) if draw.chance(0.7) else slider((0, -1, 0), 0.0, travel)
    return [closure, Link("lid", [unit.add(draw.pick(["head", "lid"]), *head)], closure, pressed)]


def _trigger(draw: Draw, unit: Node, base: Link, neck: float, top: float) -> list[Link]:
    """A sprayer: a trigger that turns about a horizontal line or slides, and sometimes a nozzle that turns."""
    size = max(neck, 0.1) * draw.between(0.8, 1.4)
    collar = cylinder(1.1 * neck, 0.6 * size, "y", (0, top, 0), 20)
    head = box((0.5 * size, 0.5 * size, 2.2 * size), (0, top + 1.5 * size, 0.3 * size))
    neck_post = box((0.5 * size, 1.2 * size, 0.6 * size), (0, top + 0.7 * size, -0.2 * size))
    closure = Link("closure", [unit.add("closure", collar)], base)
    if draw.chance(0.4):
        closure.motion = screw((0, top, 0), Y, 0.0, 0.6 * size, turns=draw.pick([180.0, None]))
    sprayer = Link("sprayer", [unit.add("head", head, neck_post)], closure)
    pin = (0.0, top + 1.25 * size, 0.8 * size)
    blade = box((0.3 * size, draw.between(0.8, 1.5) * size, 0.2 * size), (0, pin[1] - 0.5 * size, pin[2]))
    squeezed = hinge(pin, X, 0.0, draw.between(10.0, 35.0))
    if draw.chance(0.2):
        squeezed = slider((0, 0, -1), 0.0, 0.3 * size)
    trigger = unit.add("trigger", turn(blade, X, -draw.between(0.0, 30.0), pin))
    links = [closure, sprayer, Link("trigger", [trigger], sprayer, squeezed)]
    if draw.chance(0.6):
        at = (0.0, top + 1.5 * size, 1.5 * size)
        tip = cylinder(0.25 * size, 0.3 * size, "z", at, draw.pick([4, 6, 16]))
        links.append(Link("nozzle", [unit.add("nozzle", tip)], sprayer, spinner(at, (0, 0, 1))))
    return links
