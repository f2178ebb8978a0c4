"""Toilets with a seat, a lid, a tank and a flush button or lever."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.details.door_locks import lock_pieces
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, extrude, lathe, move, rounded_box, scale, sheet, turn
from kinmo.synth.primitives.swept_surfaces import grid_faces
from kinmo.synth.primitives.transforms import ORIGIN, facing
from kinmo.synth.synth_object import Link, Node, SynthObject, hinge, slider


def build(draw: Draw) -> SynthObject:
    """Toilet whose seat and lid turn up about a horizontal line behind them.

    Flush buttons slide in, a flush lever turns, and a tank cover lifts off.
    """
    root = Node(draw.pick(["Toilet", "toilet"], [3, 1]))
    width, length = draw.between(0.6, 0.85), draw.between(0.75, 1.1)
    rim = draw.between(0.6, 0.8)
    base_node = root.add("base_body", *_bowl(draw, width, length, rim))
    base = Link("base_body", [base_node])
    links = [base]
    rear = -length / 2
    tank_top = _tank(draw, root, base, links, width, rear, rim)
    level = rim
    thick = draw.between(0.025, 0.06)
    axis_z = rear + draw.between(0.0, 0.08)
    lid_open = draw.pick([0.0, draw.between(80, 98)], [3, 2])
    seat_open = lid_open * draw.between(0.9, 0.97) if lid_open and draw.chance(0.3) else 0.0
    if draw.chance(0.75):
        seat = root.add("seat", _ring(width, length, 0.62, thick, level))
        motion = hinge(
            (0, level + draw.between(0.0, 1.0) * thick, axis_z), (-1, 0, 0), 0, draw.pick([90.0, 97.0]), rest=seat_open
        )
        links.append(Link("seat", [seat], base, motion))
        level += thick
    if draw.chance(0.85) or len(links) == 1:
        lid = root.add("lid", extrude(_oval(width, length), thick, "y", (0, level + thick / 2, 0)))
        if draw.chance(0.4):
            lid.pieces.append(box((0.5 * width, 0.6 * thick, 0.08), (0, level + 0.3 * thick, rear + 0.02)))
        motion = hinge(
            (0, level + draw.between(0.0, 1.0) * thick, axis_z), (-1, 0, 0), 0, draw.pick([90.0, 100.0, 105.0]), rest=lid_open
        )
        links.append(Link("lid", [lid], base, motion))
    if draw.chance(0.3):
        base_node.pieces += [cylinder(0.025, 0.08, "x", (s * 0.2 * width, rim + 0.02, axis_z), 12) for s in (-1, 1)]
    if tank_top and draw.chance(0.2):
        base.nodes.append(root.add("other", box((0.12, 0.1, 0.08), (0.2 * width, tank_top + 0.05, rear - 0.12))))
    return SynthObject("Toilet", root, links)


def _oval(width: float, length: float, segments: int = 32) -> NDArray[np.float64]:
    """Outline [segments, 2] of a seat as (z, x): round at the front, blunter at the rear."""
    angles = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    z = 0.5 * length * np.sign(np.cos(angles)) * np.abs(np.cos(angles)) ** np.where(np.cos(angles) < 0, 0.6, 1.0)
    return np.stack([z, 0.5 * width * np.sin(angles)], axis=1)


def _ring(width: float, length: float, share: float, thick: float, low: float) -> Mesh:
    """A seat: the outline with a hole of `share` of its size."""
    outer = _oval(width, length)
    inner = share * outer + [0.04 * length, 0.0]
    rings = [(outer, low), (outer, low + thick), (inner, low + thick), (inner, low), (outer, low)]
    vertices = np.concatenate([np.stack([o[:, 1], np.full(len(o), y), o[:, 0]], axis=1) for o, y in rings])
    return Mesh(vertices, grid_faces(len(rings), len(outer), closed=True))


def _bowl(draw: Draw, width: float, length: float, rim: float) -> list[Mesh]:
    """The bowl on its foot, open above, and a block towards the wall."""
    foot = draw.between(0.45, 0.7)
    outer = [[0, 0], [foot, 0], [0.8 * foot, 0.3 * rim], [0.9, 0.75 * rim], [1.0, rim]]
    inner = [[0.75, rim], [0.55, 0.55 * rim], [0, 0.45 * rim]]
    unit = lathe(np.array(outer + inner), 28)
    bowl = scale(unit, (0.48 * width, 1.0, 0.5 * length))
    pieces = [bowl]
    if draw.chance(0.8):
        pieces.append(box_between((-0.3 * width, 0, -0.7 * length), (0.3 * width, 0.97 * rim, -0.25 * length)))
    return pieces


def _tank(draw: Draw, root: Node, base: Link, links: list[Link], width: float, rear: float, rim: float) -> float:
    """Add the tank behind the bowl with its cover and a flush button or lever; returns its height, or 0 without a tank."""
    if draw.chance(0.15):
        return 0.0
    deep, tall = draw.between(0.25, 0.4), draw.between(0.45, 0.7)
    wide = width * draw.between(0.95, 1.2)
    low, top = rim - draw.between(0.0, 0.1), rim + tall
    middle = rear - deep / 2 - draw.between(0.0, 0.06)
    size = (wide, top - low, deep)
    at = (0, 0.5 * (low + top), middle)
    tank = rounded_box(size, 0.05, "y", at) if draw.chance(0.5) else box(size, at)
    base.nodes[0].pieces.append(tank)
    cover = rounded_box((1.05 * wide, 0.05, 1.08 * deep), 0.05, "y", (0, top + 0.025, middle))
    if draw.chance(0.25):
        node = root.add("lid", cover)
        links.append(Link("lid", [node], base, slider((0, 1, 0), 0, draw.between(0.1, 0.4)), leaf_name="lid"))
    else:
        base.nodes[0].pieces.append(cover)
    kind = draw.pick(["top", "side", "lever", "none"], [4, 2, 5, 1])
    travel = draw.between(0.008, 0.02)
    if kind == "top":
        count = draw.pick([1, 2])
        for index in range(count):
            x = (index - 0.5 * (count - 1)) * 0.09
            node = root.add("button", cylinder(0.04, 2 * travel, "y", (x, top + 0.05 + travel, middle), 20))
            links.append(Link("button", [node], base, slider((0, -1, 0), 0, travel)))
    elif kind == "side":
        side = draw.sign()
        node = root.add("button", box((2 * travel, 0.08, 0.08), (side * (wide / 2 + travel), top - 0.12, middle)))
        links.append(Link("button", [node], base, slider((-side, 0, 0), 0, travel)))
    elif kind == "lever":
        links.append(_flush_lever(draw, root, base, (wide, deep), top - draw.between(0.06, 0.2), middle))
    if draw.chance(0.1):
        base.nodes[0].pieces.append(move(sheet((0.3, 0.2), axis="z"), (0, top - 0.2, middle + deep / 2 + 0.001)))
    return top


def _flush_lever(draw: Draw, root: Node, base: Link, size: tuple[float, float], y: float, middle: float) -> Link:
    """A lever on the front or a side of a tank of `size` (width, depth), turning about the wall's normal."""
    wide, deep = size
    side = draw.sign()
    if draw.chance(0.6):
        place = facing(Z, Y, (side * draw.between(0.3, 0.45) * wide, y, middle + deep / 2))
    else:
        place = facing(side * X, Y, (side * wide / 2, y, middle + draw.between(-0.3, 0.3) * deep))
    length = draw.between(0.08, 0.24)
    node = root.add(draw.pick(["lever", "button", "handle"], [3, 2, 1]))
    swing = draw.sign() * draw.between(20.0, 60.0)
    link = Link("lever", [node], base, hinge(ORIGIN, Z, min(0.0, swing), max(0.0, swing)))
    if draw.chance(0.7):
        node.pieces = lock_pieces(draw, "lever", length)
    else:
        # A plain bar that starts at its pin.
        rod = box(
            (length, length * draw.between(0.1, 0.25), length * draw.between(0.08, 0.2)), (0.5 * length, 0, 0.06 * length)
        )
        node.pieces = [turn(rod, Z, draw.pick([0.0, 180.0, draw.between(-30.0, 30.0)]))]
    link.move(place)
    return link
