"""Carts and trolleys on wheels and casters, with fixed, folding or sliding handles."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.wheels import add_caster, wheel_pieces
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, X, box, box_between, cylinder, join, move, rounded_path, sweep
from kinmo.synth.synth_object import Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Cart with wheels that roll and casters that swivel.

    Variants: a platform, shelves, a basket (sometimes with a tailgate that folds down), and a wheelbarrow. The handle is fixed,
    folds, slides up, or is a drawbar that tips.
    """
    width, length = draw.ratio(0.4, 1.1), draw.ratio(0.5, 1.7)
    radius = draw.ratio(0.05, 0.22) * min(length, 1.0)
    floor = 2 * radius + draw.ratio(0.1, 0.6) * radius
    root = Node(draw.pick(["cart", "Cart"], [3, 1]))
    body = root.add("body")
    base = Link("body", [body])
    links = [base]
    kind = draw.pick(["platform", "shelves", "basket", "barrow"], [3, 3, 3, 2])
    if kind == "barrow":
        _barrow(draw, body, width, length, floor)
        body.add("axle", cylinder(0.1 * radius, 0.4 * width, "x", (0, radius, 0.55 * length), 10))
        for x in draw.pick([(0.0,), (-0.2 * width, 0.2 * width)], [4, 1]):
            links.append(_wheel(draw, root, base, (x, radius, 0.55 * length), radius, radius * draw.between(0.2, 0.5)))
    else:
        _deck(draw, body, kind, width, length, floor)
        links += _wheels(draw, root, base, width, length, radius, floor)
        links += _handle(draw, root, base, width, length, floor)
        if kind == "basket" and draw.chance(0.4):
            links.append(_tailgate(draw, root, base, width, length, floor))
    return SynthObject("Cart", root, links)


def _deck(draw: Draw, body: Node, kind: str, width: float, length: float, floor: float) -> None:
    """Add the load area: a plate, two or three shelves between posts, or a basket."""
    x, z, rod = width / 2, length / 2, 0.018
    body.add("platform", box((width, draw.between(0.02, 0.06), length), (0, floor, 0)))
    if kind == "shelves":
        height = draw.between(0.6, 1.1)
        for sx in (-1, 1):
            for sz in (-1, 1):
                body.add("leg", cylinder(rod, height, "y", (sx * (x - rod), floor + height / 2, sz * (z - rod)), 10))
        for level in draw.pick([(1.0,), (0.5, 1.0)]):
            body.add("shelf", box((width, 0.025, length), (0, floor + level * height, 0)))
    elif kind == "basket":
        height = draw.between(0.3, 0.6)
        if draw.chance(0.5):
            walls = [box_between((s * x - rod, floor, -z), (s * x + rod, floor + height, z)) for s in (-1, 1)]
            ends = [box_between((-x, floor, s * z - rod), (x, floor + height, s * z + rod)) for s in (-1, 1)]
            body.add("basket", *walls, *ends)
            return
        bars: list[Mesh] = []
        for level in np.linspace(0.2, 1.0, draw.integer(2, 5)) * height + floor:
            bars += [box((rod, rod, length), (s * x, level, 0)) for s in (-1, 1)]
            bars += [box((width, rod, rod), (0, level, s * z)) for s in (-1, 1)]
        body.add(
            "basket",
            join(*bars),
            join(*(box((rod, height, rod), (sx * x, floor + height / 2, sz * z)) for sx in (-1, 1) for sz in (-1, 1))),
        )


def _wheel(draw: Draw, root: Node, carrier: Link, at: Point, radius: float, thick: float) -> Link:
    """Add a wheel that rolls about x."""
    node = root.add("wheel", *(move(piece, at) for piece in wheel_pieces(draw, radius, thick)))
    return Link("wheel", [node], carrier, spinner(at, X))


def _wheels(draw: Draw, root: Node, base: Link, width: float, length: float, radius: float, floor: float) -> list[Link]:
    """Two to six wheels. None, those of one end or all of them are on casters; the others may share an axle or be larger."""
    links: list[Link] = []
    thick = radius * draw.ratio(0.2, 0.9)
    casters = draw.pick([(), (1.0,), (-1.0, 1.0)], [2, 4, 2])
    rows = draw.pick([(-1.0, 1.0), (-1.0, 0.0, 1.0), (-1.0,)], [8, 1, 1])
    outside = draw.pick([-1.0, 1.0], [3, 1])
    z, swivels = length / 2 - 1.2 * radius, draw.chance(0.85)
    large = radius * draw.ratio(1.0, 1.8) if outside > 0 and casters == (1.0,) else radius
    heading = draw.pick([0.0, 180.0, draw.between(0.0, 360.0)])
    if rows == (-1.0,):
        base.nodes.append(root.add("leg", *(box((0.03, floor, 0.03), (s * 0.4 * width, 0.5 * floor, z)) for s in (-1, 1))))
    for row in rows:
        sides = (-1.0, 1.0) if row not in casters or draw.chance(0.85) else (0.0,)
        for own, side in zip(draw.identical(len(sides)), sides, strict=True):
            x = side * (width / 2 + outside * thick * 0.6)
            if row in casters:
                inner = side * (width / 2 - thick)
                stem = (inner, floor, row * z)
                links += add_caster(own, root, base, stem, floor, radius, thick, heading=heading, swivels=swivels)
            else:
                links.append(_wheel(own, root, base, (x, large, row * z), large, thick))
        if row not in casters and draw.chance(0.7):
            axle = cylinder(0.12 * radius, width + 2 * thick, "x", (0, large, row * z), 10)
            brackets = [
                box((0.02, max(floor - large, 0.02), 0.05), (s * 0.4 * width, 0.5 * (floor + large), row * z)) for s in (-1, 1)
            ]
            base.nodes.append(root.add("axle", axle, *brackets))
    return links


def _handle(draw: Draw, root: Node, base: Link, width: float, length: float, floor: float) -> list[Link]:
    """A handle at the rear that is fixed, folds onto the deck or slides up; or a drawbar at the front."""
    kind = draw.pick(["fixed", "folding", "telescopic", "drawbar"], [4, 3, 1, 2])
    rise, half = draw.ratio(0.3, 1.1), 0.45 * width
    if kind == "drawbar":
        z, y = length / 2, floor - 0.03
        path = np.array([[0, y, z], [0, y, z + 0.7 * rise], [0, y, z + 0.8 * rise]])
        bar = sweep(path, 0.02, 8)
        grip = cylinder(0.02, 0.3, "x", (0, y, z + 0.8 * rise), 10)
        motion = hinge((0, y, z), (-1, 0, 0), draw.pick([-10.0, 0.0]), draw.pick([60.0, 90.0]), rest=draw.between(0, 55))
        return [Link("steering", [root.add("handle", bar, grip)], base, motion)]
    z = -length / 2 + draw.pick([0.02, -0.02])
    corners = [[-half, floor, z], [-half, floor + rise, z - 0.1], [half, floor + rise, z - 0.1], [half, floor, z]]
    bar = sweep(rounded_path(np.array(corners), 0.1), draw.between(0.014, 0.025), 10)
    node = root.add("handle", bar)
    if kind == "fixed":
        base.nodes.append(node)
        return []
    if kind == "telescopic":
        return [Link("handle", [node], base, slider((0, 1, -0.1 / rise), -0.3 * rise, 0.2 * rise))]
    rest = draw.between(0, 80) if draw.chance(0.2) else 0.0
    return [Link("handle", [node], base, hinge((0, floor + 0.03, z), (1, 0, 0), 0, 88, rest=rest))]


def _tailgate(draw: Draw, root: Node, base: Link, width: float, length: float, floor: float) -> Link:
    """A board at the front that folds down."""
    z = length / 2 + 0.04
    node = root.add("door", box_between((-width / 2, floor, z), (width / 2, floor + 0.35, z + 0.03)))
    return Link("door", [node], base, hinge((0, floor, z), (1, 0, 0), 0, draw.pick([90.0, 180.0])))


def _barrow(draw: Draw, body: Node, width: float, length: float, floor: float) -> None:
    """Add a tray on two long handles, with two legs at the rear."""
    tray_low, tray_high = floor + 0.1, floor + draw.between(0.35, 0.5)
    outline = [(-0.3 * width, -0.3 * length), (0.3 * width, 0.3 * length)]
    (x0, z0), (x1, z1) = outline
    flare = 1.5
    lower = np.array([[x0, tray_low, z0], [x1, tray_low, z0], [x1, tray_low, z1], [x0, tray_low, z1]])
    upper = lower * [flare, 1, flare] + [0, tray_high - tray_low, 0]
    sides = [[i, (i + 1) % 4, 4 + (i + 1) % 4] for i in range(4)] + [[i, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    faces = np.array([*sides, [0, 2, 1], [0, 3, 2]], np.uint32)[:, ::-1]
    body.add("container", Mesh(np.concatenate([lower, upper]), faces))
    for side in (-1, 1):
        low = [side * 0.06, 0.9 * floor * 0.5, 0.6 * length]
        path = np.array([low, [side * 0.25 * width, tray_low, 0.0], [side * 0.4 * width, tray_low + 0.2, -0.9 * length]])
        body.add("frame", sweep(rounded_path(path, 0.2), 0.02, 8))
        body.add("leg", box((0.03, tray_low, 0.04), (side * 0.25 * width, tray_low / 2, -0.25 * length)))
