"""Wheels that roll about x, and casters: forks that swivel about a vertical stem and hold a wheel."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    Point,
    X,
    Y,
    box,
    cylinder,
    dome,
    ellipsoid,
    lathe,
    move,
    rotation_about,
    rounded_path,
    sweep,
    torus,
    tube,
    turn,
)
from kinmo.synth.synth_object import Link, Node, spinner


def wheel_pieces(draw: Draw, radius: float, thick: float) -> list[Mesh]:
    """Meshes of a wheel about the x axis at the origin: a disc, tyre, rim, ball or barrel, with or without spokes and hub."""
    kind = draw.pick(["disc", "tyre", "spokes", "rim", "dished", "barrel", "twin"], [5, 3, 3, 3, 2, 1, 2])
    segments = draw.pick([12, 16, 24, 32])
    if kind == "disc":
        pieces = [cylinder(radius, thick, "x", segments=segments)]
    elif kind == "tyre":
        rod = min(0.5 * thick, 0.4 * radius)
        pieces = [torus(radius - rod, rod, "x", segments=segments), cylinder(radius - rod, 0.6 * thick, "x", segments=segments)]
    elif kind == "spokes":
        count, rod = draw.integer(3, 9), min(0.5 * thick, draw.between(0.06, 0.2) * radius)
        hub = cylinder(draw.between(0.12, 0.3) * radius, thick * draw.between(0.8, 1.3), "x", segments=14)
        spoke = box((0.4 * thick, radius - rod, draw.between(0.06, 0.2) * radius), (0, 0.5 * (radius - rod), 0))
        pieces = [
            torus(radius - rod, rod, "x", segments=segments),
            hub,
            *(turn(spoke, X, 360.0 * i / count) for i in range(count)),
        ]
    elif kind == "rim":
        share = draw.between(0.5, 0.85)
        pieces = [tube(radius, share * radius, thick, "x", segments=segments)]
        pieces.append(cylinder(share * radius, draw.between(0.3, 0.9) * thick, "x", segments=segments))
    elif kind == "dished":
        half = 0.5 * thick
        profile = np.array([[0, -half], [0.3, -half], [0.4, -0.4 * half], [0.7, -0.4 * half], [0.85, -half], [1, -half]])
        profile = np.concatenate([profile, profile[::-1] * (1, -1)]) * (radius, 1.0)
        pieces = [turn(lathe(profile, segments), (0, 0, 1), -90.0)]
    elif kind == "barrel":
        pieces = [ellipsoid((0.6 * max(thick, 0.5 * radius), radius, radius), segments=segments, rings=10)]
    else:
        pieces = [cylinder(radius, 0.4 * thick, "x", (s * 0.4 * thick, 0, 0), segments) for s in (-1, 1)]
        pieces.append(cylinder(0.3 * radius, thick, "x", segments=12))
    if draw.chance(0.25):
        pieces.append(cylinder(draw.between(0.15, 0.4) * radius, thick * draw.between(1.05, 1.3), "x", segments=14))
    return pieces


def add_caster(
    draw: Draw,
    above: Node,
    carrier: Link,
    stem: Point,
    drop: float,
    radius: float,
    thick: float,
    *,
    heading: float = 0.0,
    swivels: bool = True,
    rolls: bool = True,
) -> list[Link]:
    """Add a caster or a fixed fork with a wheel.

    Args:
        above: Node that it is added below.
        carrier: Link that it carries. What does not move belongs to it.
        stem: Top [3] of the stem.
        drop: Height of the stem's top above the floor, at least two radii.
        radius: Radius of the wheel.
        thick: Thickness of the wheel.
        heading: Angle of the fork about the stem, in degrees.
        swivels: Give the fork a joint.
        rolls: Give the wheel a joint.

    Returns:
        Links of the fork and the wheel that have a joint.
    """
    place = rotation_about(Y, heading, stem)
    trail = radius * draw.between(0.2, 0.9) if swivels else 0.0
    hub = np.asarray(stem, float) + (0.0, radius - drop, -trail)
    group = above.add("caster")
    fork = group.add("caster_stem", *(move(piece, stem) for piece in _fork(draw, drop, radius, thick, trail)))
    wheel = group.add("wheel", *(move(piece, hub) for piece in wheel_pieces(draw, radius, thick)))
    holder, made = carrier, []
    if swivels:
        holder = Link("caster", [fork], carrier, spinner(stem, Y))
        made.append(holder)
    else:
        carrier.nodes.append(fork)
    if rolls:
        made.append(Link("wheel", [wheel], holder, spinner(hub, X)))
    else:
        holder.nodes.append(wheel)
    for node in (fork, wheel):
        if not any(node in link.nodes for link in made):
            Link("still", [node]).move(place)
    for link in made:
        link.move(place)
    return made


def _fork(draw: Draw, drop: float, radius: float, thick: float, trail: float) -> list[Mesh]:
    """Meshes that hold a wheel below the origin: cheeks, one arm, a bent arm or a hood, on a stem or a plate."""
    axle = radius - drop
    crown = min(axle + 1.08 * radius, -0.02 * radius)
    kind = draw.pick(["cheeks", "arm", "bent", "hood"], [4, 2, 1, 2])
    pieces = [cylinder(draw.between(0.1, 0.3) * radius, -crown, "y", (0, 0.5 * crown, 0), 12)] if crown < -0.05 * radius else []
    if draw.chance(0.4):
        size = radius * draw.between(0.6, 1.3)
        pieces.append(box((size, 0.08 * radius, size), (0, -0.04 * radius, 0)))
    cheek, wide = draw.between(0.08, 0.2) * thick, radius * draw.between(0.3, 0.7)
    if kind == "hood":
        hood = dome((0.7 * thick + 0.05 * radius, 1.06 * radius, 1.06 * radius), (0, axle, -trail), segments=14)
        return [*pieces, hood]
    sides = (-1.0, 1.0) if kind == "cheeks" else (draw.sign(),)
    offset = 0.5 * thick * 1.15 + 0.5 * cheek
    if kind == "bent":
        rod = 0.12 * radius
        corners = [(0, crown, 0), (sides[0] * (offset + rod), crown, -0.5 * trail), (sides[0] * (offset + rod), axle, -trail)]
        return [*pieces, sweep(rounded_path(np.array(corners), 0.4 * radius), rod, 8)]
    for side in sides:
        long = crown - axle + 0.3 * radius
        plate = box((cheek, long, wide), (side * offset, 0.5 * (crown + axle - 0.3 * radius), -0.5 * trail))
        pieces.append(plate)
    pieces.append(box((2 * offset, 0.1 * radius, wide), (0, crown, -0.5 * trail)))
    pieces.append(cylinder(0.12 * radius, 2 * offset, "x", (0, axle, -trail), 8))
    return pieces
