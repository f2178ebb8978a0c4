"""Aeroplanes and helicopters with propellers, rotors, control surfaces, wheels and canopies."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.wheels import wheel_pieces
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, along, box, box_between, cylinder, dome, ellipsoid, extrude, lathe, move, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Aircraft with its nose towards +z.

    Variants: an aeroplane whose ailerons, flaps, elevators and rudder turn about their leading edges, and a helicopter with a
    main and a tail rotor. Propellers and wheels turn; canopies slide or fold; doors open sideways.
    """
    root = Node("aircraft")
    base = Link("body", [], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    long, radius = draw.between(2.0, 3.2), draw.ratio(0.14, 0.35)
    links = _aeroplane(draw, root, base, long, radius) if draw.chance(0.7) else _helicopter(draw, root, base, long, radius)
    return SynthObject("aircraft", root, [base, *links])


def _fuselage(draw: Draw, long: float, radius: float, tail: float) -> list[Mesh]:
    """A round or square body along z, which narrows to `tail` at the rear."""
    if draw.chance(0.2):
        outline = np.array([(-radius, 0.45), (-0.3 * tail, -0.5), (0.3 * tail, -0.5), (radius, 0.2), (0.7 * radius, 0.5)])
        outline[:, 1] *= long
        return [extrude(outline, 1.6 * radius, "x")]
    share = np.array([-0.5, -0.3, 0.0, 0.25, 0.4, 0.47, 0.5]) * long
    sizes = np.array([tail, 0.3 * (tail + radius), radius, radius, 0.85 * radius, 0.5 * radius, 0.2 * radius])
    profile = np.stack([sizes, share], axis=1)
    profile = np.concatenate([[[0.0, share[0]]], profile, [[0.0, share[-1]]]])
    return [along(lathe(profile, draw.pick([12, 20])), "z")]


def _blades(draw: Draw, reach: float, hub: float) -> list[Mesh]:
    """Two to five blades about z with a hub at the origin."""
    count, wide = draw.pick([2, 3, 4, 5], [4, 4, 2, 1]), draw.between(0.06, 0.16) * reach
    blade = turn(box((wide, reach, 0.2 * wide), (0, reach / 2, 0)), Y, draw.between(0.0, 35.0))
    if draw.chance(0.4):
        blade = turn(
            extrude(
                np.array([(-wide, 0.1 * reach), (wide, 0.1 * reach), (0.4 * wide, reach), (-0.4 * wide, reach)]) * 0.7,
                0.15 * wide,
                "z",
            ),
            Y,
            15.0,
        )
    return [cylinder(hub, 2 * hub, "z", segments=14), *(turn(blade, Z, 360.0 * index / count) for index in range(count))]


def _surface(
    draw: Draw, root: Node, base: Link, name: str, low: np.ndarray, high: np.ndarray, edge: np.ndarray, axis: np.ndarray
) -> Link:
    """Add a control surface between two corners [3] that turns about a line."""
    swing = draw.between(15.0, 40.0)
    most = draw.pick([(-swing, swing), (0.0, swing)], [4, 1])
    rest = draw.pick([0.0, draw.between(0.3, 1.0) * swing], [4, 1])
    node = root.add(name, box_between(low, high))
    return Link(name, [node], base, hinge(edge, axis * draw.sign(), *most, rest=rest))


def _wing(
    draw: Draw, root: Node, base: Link, name: str, at: np.ndarray, span: float, chord: float, surfaces: list[str]
) -> list[Link]:
    """Add a wing on both sides of the body, with control surfaces along its trailing edge.

    Args:
        draw: Source of all random values.
        root: Node that it is added below.
        base: Link of the body.
        name: Name of the wing.
        at: Middle [3] of the leading edge.
        span: Length of one side.
        chord: Depth along z.
        surfaces: Names of the control surfaces of one side, from the body outwards.

    Returns:
        Links of the control surfaces.
    """
    thick, links = draw.between(0.06, 0.14) * chord, []
    share, gap = draw.between(0.2, 0.35), 0.01 * chord
    rear = at[2] - chord
    hinge_z = rear + share * chord
    for side in (-1.0, 1.0):
        edges = np.array([0.05, 0.95]) * span if len(surfaces) == 1 else np.array([0.08, 0.5, 0.96]) * span
        x0, x1 = sorted((side * 0.0, side * span))
        pieces = [box_between((x0, at[1] - thick / 2, hinge_z + gap), (x1, at[1] + thick / 2, at[2]))]
        if not surfaces:
            pieces = [box_between((x0, at[1] - thick / 2, rear), (x1, at[1] + thick / 2, at[2]))]
        base.nodes.append(root.add(name, *pieces))
        for index, surface in enumerate(surfaces):
            a, b = sorted((side * edges[index], side * (edges[index + 1] - 0.01 * span)))
            low, high = np.array([a, at[1] - 0.35 * thick, rear]), np.array([b, at[1] + 0.35 * thick, hinge_z])
            links.append(_surface(draw, root, base, surface, low, high, np.array([0, at[1], hinge_z]), X))
    return links


def _aeroplane(draw: Draw, root: Node, base: Link, long: float, radius: float) -> list[Link]:
    """An aeroplane with low, middle or high wings and one to four propellers."""
    tail = draw.between(0.15, 0.4) * radius
    base.nodes.append(root.add(draw.pick(["body", "fuselage"]), *_fuselage(draw, long, radius, tail)))
    span, chord = draw.between(0.8, 1.8), draw.between(0.25, 0.5)
    level, wing_z = draw.pick([-0.8, 0.0, 1.02]) * radius, draw.between(0.1, 0.22) * long
    surfaces = draw.pick([["aileron"], ["flap", "aileron"], ["flap"]], [3, 4, 1])
    links = _wing(draw, root, base, "wing", np.array([0.0, level, wing_z]), span, chord, surfaces)
    if draw.chance(0.12):
        upper = np.array([0.0, level + 2.2 * radius, wing_z])
        links += _wing(draw, root, base, "wing", upper, span, chord, draw.pick([[], ["aileron"]]))
        for side in (-1, 1):
            post = cylinder(0.012, 2.2 * radius, "y", (side * 0.7 * span, level + 1.1 * radius, wing_z - 0.3 * chord), 8)
            base.nodes.append(root.add("strut", post))
    tail_chord = draw.between(0.5, 0.75) * chord
    end = -long / 2 + draw.between(0.0, 0.08) * long
    fin_high = radius * draw.between(1.2, 2.2) + 0.1
    tee = draw.chance(0.2)
    level_tail = fin_high if tee else draw.between(0.0, 0.3) * radius
    links += _wing(
        draw, root, base, "tail", np.array([0.0, level_tail, end + tail_chord]), 0.4 * span, tail_chord, ["elevator"]
    )
    thin, split = 0.05 * tail_chord, end + 0.35 * tail_chord
    fin = box_between((-thin, 0, split + 0.005), (thin, fin_high, end + tail_chord))
    base.nodes.append(root.add("fin", fin))
    low, high = np.array([-0.7 * thin, 0.45 * radius, end]), np.array([0.7 * thin, fin_high - 0.02, split])
    if tee:
        high[1] -= 0.1 * fin_high
    links.append(_surface(draw, root, base, "rudder", low, high, np.array([0.0, 0.0, split]), Y))
    links += _propellers(draw, root, base, long, radius, (span, level, wing_z))
    links += _gear(draw, root, base, radius, (0.3 * span, wing_z - 0.4 * chord), long)
    if level < radius:
        links += _canopy(draw, root, base, radius, wing_z)
    return links


def _propellers(draw: Draw, root: Node, base: Link, long: float, radius: float, wing: tuple[float, float, float]) -> list[Link]:
    """Propellers at the nose, or in front of nacelles on the wings; rarely none."""
    span, level, wing_z = wing
    places = draw.pick([[(0.0, 0.0, long / 2)], [], [(s * 0.35 * span, level, wing_z + 0.15) for s in (-1, 1)]], [6, 1, 2])
    if len(places) == 2 and draw.chance(0.3):
        places += [(s * 0.65 * span, level, wing_z + 0.15) for s in (-1, 1)]
    reach = draw.between(0.25, 0.5) if len(places) < 3 else 0.14 * span
    hub, links = draw.between(0.08, 0.15) * reach, []
    for own, place in zip(draw.identical(len(places)), places, strict=True):
        at = np.array(place) + (0, 0, 1.2 * hub)
        pieces = [move(piece, at) for piece in _blades(own, reach, hub)]
        if own.chance(0.6):
            pieces.append(move(dome((hub, 2 * hub, hub), axis="z", segments=14), at + (0, 0, hub)))
        if len(places) > 1:
            nacelle = ellipsoid((0.4 * reach, 0.35 * reach, 0.3), np.array(place) - (0, 0, 0.3), 14, 8)
            base.nodes.append(root.add(own.pick(["engine", "nacelle"]), nacelle))
        node = root.add("propeller", *pieces)
        links.append(Link("propeller", [node], base, spinner(at, Z)))
    return links


def _gear(draw: Draw, root: Node, base: Link, radius: float, main: tuple[float, float], long: float) -> list[Link]:
    """Two main wheels on legs and a nose or tail wheel; rarely none, or skids."""
    if draw.chance(0.12):
        return []
    size, drop = draw.ratio(0.05, 0.11), radius + draw.between(0.15, 0.35)
    x, z = main
    third = draw.pick([0.38, -0.42]) * long
    links = []
    for own, at in zip(draw.identical(3), [(-x, z), (x, z), (0.0, third)], strict=True):
        hub = np.array([at[0], -drop, at[1]])
        top = np.array([0.5 * at[0], -0.5 * radius if abs(third) else 0.0, at[1]])
        wheel = [move(piece, hub) for piece in wheel_pieces(own, size, 0.5 * size)]
        leg_top = top + (0, 0.3 * radius, 0)
        aside = np.array([0.5 * size * (np.sign(at[0]) or 1.0), 0, 0])
        path = np.array([leg_top, hub - aside])
        direction = path[1] - path[0]
        length = float(np.linalg.norm(direction))
        leg = cylinder(0.15 * size, length, "y", (0, -length / 2, 0), 8)
        leg = turn(leg, Z, float(np.degrees(np.arctan2(direction[0], -direction[1]))))
        base.nodes.append(root.add(draw.pick(["leg", "strut"]), move(leg, leg_top)))
        links.append(Link("wheel", [root.add("wheel", *wheel)], base, spinner(hub, X)))
    return links


def _canopy(draw: Draw, root: Node, base: Link, radius: float, z: float) -> list[Link]:
    """A canopy over the seats that slides back, folds sideways or forward, or is fixed; or none."""
    if draw.chance(0.35):
        return []
    half, long = 0.6 * radius, draw.between(0.2, 0.35)
    low = 0.75 * radius
    shell = dome((half, 0.7 * radius, long), (0, low, z), "y", 18)
    node = root.add(draw.pick(["canopy", "cover", "glass"]), shell)
    kind = draw.pick(["slide", "side", "rear", "fixed"], [3, 2, 2, 2])
    if kind == "fixed":
        base.nodes.append(node)
        return []
    opens = draw.between(50.0, 95.0)
    motion = {
        "slide": slider(-Z, 0.0, long * draw.between(0.8, 1.6)),
        "side": hinge((half, low, 0), -Z, 0.0, opens),
        "rear": hinge((0, low, z - long), -X, 0.0, 0.6 * opens),
    }[kind]
    return [Link("canopy", [node], base, motion)]


def _helicopter(draw: Draw, root: Node, base: Link, long: float, radius: float) -> list[Link]:
    """A cabin with a tail boom, a main rotor on a mast, a tail rotor at its side, doors, and skids or wheels."""
    radius *= 1.4
    cabin = ellipsoid((radius, 1.05 * radius, 0.28 * long), (0, 0, 0.1 * long), 20, 12)
    square = draw.chance(0.5)
    if square:
        cabin = box((1.7 * radius, 1.9 * radius, 0.5 * long), (0, 0, 0.1 * long))
    end = -0.62 * long
    boom = cylinder(0.12 * radius, 0.6 * long, "z", (0, 0.3 * radius, end + 0.3 * long), 12, top_radius=0.3 * radius)
    top = radius * 1.05 + draw.between(0.08, 0.25)
    mast = cylinder(0.1 * radius, top - 0.5 * radius, "y", (0, 0.5 * (top + 0.5 * radius), 0.1 * long), 12)
    fin = box_between((-0.02, 0.1 * radius, end - 0.05), (0.02, 1.1 * radius, end + 0.15))
    base.nodes += [root.add("body", cabin), root.add("tail", boom, fin), root.add("mast", mast)]
    at = np.array([0.0, top, 0.1 * long])
    rotor = [turn(piece, X, -90.0) for piece in _blades(draw, draw.between(0.7, 1.1) * 0.6 * long, 0.15 * radius)]
    links = [Link("rotor", [root.add(draw.pick(["rotor", "propeller"]), *(move(p, at) for p in rotor))], base, spinner(at, Y))]
    side = draw.sign()
    aside = np.array([side * 0.12, 0.7 * radius, end + 0.05])
    small = [turn(piece, Y, 90.0) for piece in _blades(draw, draw.between(0.18, 0.3), 0.03)]
    axle = cylinder(0.015, 0.12, "x", aside - (side * 0.06, 0, 0), 8)
    base.nodes.append(root.add("axle", axle))
    links.append(Link("rotor", [root.add("tail_rotor", *(move(p, aside) for p in small))], base, spinner(aside, X)))
    if square:
        for s in draw.pick([(-1.0, 1.0), (1.0,), ()]):
            tall, wide, thick = 1.3 * radius, 0.2 * long, 0.03
            x, z = s * (0.85 * radius + thick / 2), 0.15 * long
            node = root.add("door", box((thick, tall, wide), (x, -0.1 * radius, z)))
            shut = hinge((x, 0, z + wide / 2), -s * Y, 0.0, 90.0)
            aft = slider(-Z, 0.0, wide * draw.between(0.6, 1.0))
            links.append(Link("door", [node], base, shut if draw.chance(0.6) else aft))
    if draw.chance(0.6):
        low = -1.5 * radius
        for s in (-1, 1):
            skid = cylinder(0.025, 0.6 * long, "z", (s * 0.8 * radius, low, 0.1 * long), 10)
            posts = [
                box((0.03, 0.8 * radius, 0.03), (s * 0.8 * radius, low + 0.4 * radius, 0.1 * long + t * 0.12 * long))
                for t in (-1, 1)
            ]
            base.nodes.append(root.add("skid", skid, *posts))
        return links
    return links + _gear(draw, root, base, radius, (0.8 * radius, 0.0), 0.8 * long)
