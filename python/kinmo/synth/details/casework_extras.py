"""Rarer parts of furniture: lids, pull-out boards, false fronts, leaning drawers, locked doors, casters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.synth.details.casework import Fronts, Opening, add_door, add_drawer
from kinmo.synth.details.door_locks import add_door_lock
from kinmo.synth.details.wheels import add_caster
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, X, Z, box, box_between, rotation_about
from kinmo.synth.synth_object import Link, Node, hinge, slider


def add_lift_top(draw: Draw, above: Node, carcass: Link, low: Point, high: Point, name: str) -> Link:
    """Add a board between two corners [3] that folds up about its rear edge, rarely its front edge or an end."""
    edge = draw.pick(["rear", "front", "end"], [8, 1, 1])
    thick = float(high[1]) - float(low[1])
    level = float(low[1]) + draw.pick([0.0, 0.5 * thick, thick])
    opens = draw.between(45.0, 110.0)
    rest = draw.between(0.2, 0.9) * opens if draw.chance(0.25) else 0.0
    node = above.add(name, box_between(low, high))
    if edge == "end":
        motion = hinge((float(low[0]), level, 0), Z, 0.0, opens, rest=rest)
    else:
        z, sense = (float(low[2]), -1.0) if edge == "rear" else (float(high[2]), 1.0)
        motion = hinge((0, level, z), sense * X, 0.0, opens, rest=rest)
    return Link("lid", [node], carcass, motion, leaf_name="rotation_lid")


def add_pullout(draw: Draw, above: Node, carcass: Link, opening: Opening) -> Link:
    """Add a board in an opening that slides out: a keyboard tray, a shelf, a cutting board."""
    thick = min(draw.between(0.015, 0.05), 0.5 * opening.height)
    deep, y = opening.depth * draw.between(0.6, 0.95), opening.low + draw.between(0.1, 0.8) * (opening.height - thick)
    front = opening.front + draw.pick([0.0, draw.between(-0.05, 0.02)])
    half = 0.5 * opening.width - draw.between(0.0, 0.02)
    pieces = [box_between((opening.x - half, y, front - deep), (opening.x + half, y + thick, front))]
    if draw.chance(0.4):
        pieces.append(box((2 * half, 2 * thick, 0.02), (opening.x, y + thick, front + 0.01)))
    if draw.chance(0.15):
        # A keyboard lies on the tray.
        pieces.append(box((1.2 * half, 0.02, 0.35 * deep), (opening.x, y + thick + 0.01, front - 0.4 * deep)))
    if draw.chance(0.3):
        # The brackets that the tray slides in hang below the top.
        reach = min(2 * thick, opening.high - y)
        for side in (-1, 1):
            x, thin = opening.x + side * (half - 0.5 * thick), 0.2 * thick
            hanger = box_between((x - thin, y + reach, front - deep), (x + thin, opening.high, front - 0.1 * deep))
            carcass.nodes.append(above.add(draw.pick(["rail", "bar"]), hanger))
    node = above.add(draw.pick(["tray", "shelf", "keyboard_tray", "board"]), *pieces)
    travel = deep * draw.between(0.4, 0.9)
    rest = travel * draw.between(0.2, 0.9) if draw.chance(0.2) else 0.0
    return Link("tray", [node], carcass, slider(Z, 0.0, travel, rest=rest), leaf_name="translation_tray")


def add_false_front(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> None:
    """Add a fixed panel that looks like a drawer or a door, sometimes with a handle."""
    panel = fronts.panel(draw, opening)
    node = above.add(draw.pick(["vertical_front_panel", "frame_horizontal_bar", "other_leaf"], [4, 1, 1]), *panel)
    carcass.nodes += [node, *fronts.fit(draw, above, opening)]
    if draw.chance(0.5):
        at = (opening.x, opening.y, fronts.back_plane(opening) + 1.5 * fronts.thickness)
        grip = fronts.grip(draw, 0.3 * fronts.size(opening)[0], at, opening, vertical=draw.chance(0.3))
        carcass.nodes.append(above.add("handle", *grip))


def add_leaning_drawer(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> Link:
    """Add a drawer or bin that slides out along a line leaning up or down."""
    link = add_drawer(draw, above, carcass, opening, fronts)
    pivot = (opening.x, opening.low, opening.front)
    most = min(np.degrees(np.arctan2(0.5 * opening.height, opening.depth)), 30.0)
    link.move(rotation_about(X, draw.sign() * draw.between(0.3, 1.0) * most, pivot))
    return link


def add_locked_door(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts, side: str) -> list[Link]:
    """Add a door with a knob, lever or key on it that turns about the door's normal."""
    plain = replace(fronts, has_handles=False)
    door = add_door(draw, above, carcass, opening, plain, side)
    out = 1.0 if side == "right" else -1.0
    at = (
        opening.x - out * draw.between(0.3, 0.42) * opening.width,
        opening.y + draw.between(-0.2, 0.2) * opening.height,
        plain.back_plane(opening) + plain.thickness,
    )
    kind = draw.pick(["dial", "lever", "tee", "cylinder"], [3, 3, 1, 2])
    group = door.nodes[0]
    door.nodes = list(group.children)
    return [door, add_door_lock(draw, group, door, kind, at, draw.between(0.04, 0.15))]


def add_casters(
    draw: Draw, above: Node, carcass: Link, x: float, z: float, low: float, *, always_moves: bool = False
) -> list[Link]:
    """Add four casters or wheels.

    Args:
        above: Node that they are added below.
        carcass: Link that they carry.
        x: Half distance along x.
        z: Half distance along z.
        low: Height of the carcass's underside.
        always_moves: Give the wheels joints.

    Returns:
        Links of casters that swivel about a vertical stem, and of wheels that roll. What does not move belongs to `carcass`.
    """
    radius = draw.ratio(0.02, 0.1)
    thick, drop = radius * draw.ratio(0.3, 1.2), radius * draw.between(2.15, 3.2)
    swivels, rolls, heading = draw.chance(0.6), always_moves or draw.chance(0.7), draw.between(0.0, 360.0)
    alike, links = draw.chance(0.6), []
    places = ((x, z), (-x, z), (x, -z), (-x, -z))
    for own, (right, ahead) in zip(draw.identical(len(places)), places, strict=True):
        angle = 0.0 if not swivels else heading if alike else draw.between(0.0, 360.0)
        stem = (right, low, ahead)
        links += add_caster(own, above, carcass, stem, drop, radius, thick, heading=angle, swivels=swivels, rolls=rolls)
    return links
