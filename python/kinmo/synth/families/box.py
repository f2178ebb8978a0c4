"""Boxes with lids and flaps: chests, cartons and cases. Most are shown open, as most real ones are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.carrying_handles import add_carrying_handle
from kinmo.synth.details.clasps import add_clasp
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, extrude, inside_out, join, move, turn
from kinmo.synth.primitives.transforms import facing, rotation_about, transform
from kinmo.synth.synth_object import Link, Node, SynthObject, hinge, slider

BOARDS_SHARE = 0.3
"""Share of bodies that are a part for each board."""


@dataclass(frozen=True)
class _Size:
    """Size of the body: half extents along x and z, height `top`, and wall thickness. It stands on y = 0."""

    x: float
    z: float
    top: float
    wall: float


def build(draw: Draw) -> SynthObject:
    """Box with a lid, flaps or a tray, and sometimes clasps and carrying handles.

    Variants: one lid hinged at the rear, two or four carton flaps, two half lids, a loose lid that lifts off or slides, and a
    tray. Clasps and handles have joints of their own.
    """
    x, z, top = draw.ratio(0.25, 1.0), draw.ratio(0.2, 0.8), draw.ratio(0.1, 1.0)
    size = _Size(x, z, top, draw.pick([0.0, draw.ratio(0.006, 0.08)], [1, 5]))
    nested = draw.chance(0.2)
    root = Node(draw.pick(["Box", "box"], [5, 1]) if not nested else "storage_furniture")
    above = root.add("chest") if nested else root
    kind = draw.pick(["lid", "flaps", "split", "loose", "drawer"], [14, 4, 1.5, 1.5, 0.7])
    floor, *walls = _tub(size)[::-1]
    apart = kind != "drawer" and draw.chance(BOARDS_SHARE)
    body = above.add("chest_box" if nested else "base_body", floor, *([] if apart else walls))
    base = Link("base_body", [body])
    if apart:
        base.nodes += [above.add(draw.pick(["panel", "side", "board"]), wall) for wall in walls]
    links = [base]
    if kind == "lid":
        links += _lid(draw, above, base, size, nested)
    else:
        links += {"flaps": _flaps, "split": _split_lid, "loose": _loose_lid, "drawer": _tray}[kind](draw, above, base, size)
    _decorate(draw, above, base, size)
    if draw.chance(0.3):
        links += _side_handles(draw, above, base, size)
    return SynthObject("Box", root, links)


def _tub(size: _Size) -> list[Mesh]:
    """Four walls and a floor, open above. Walls of thickness 0 are sheets."""
    x, z, top, wall = size.x, size.z, size.top, size.wall
    return [
        box_between((-x, 0, -z), (-x + wall, top, z)),
        box_between((x - wall, 0, -z), (x, top, z)),
        box_between((-x + wall, 0, -z), (x - wall, top, -z + wall)),
        box_between((-x + wall, 0, z - wall), (x - wall, top, z)),
        box_between((-x + wall, 0, -z + wall), (x - wall, wall, z - wall)),
    ]


def _lid(draw: Draw, above: Node, base: Link, size: _Size, nested: bool) -> list[Link]:
    """One lid hinged at the rear rim: flat, a hollow half, or vaulted, sometimes with clasps at the front."""
    over = draw.pick([0.0, draw.between(0.0, 0.05)])
    x, z = size.x + over, size.z + over
    kind = draw.pick(["flat", "hollow", "vaulted"], [4, 3, 2])
    thick = draw.ratio(0.01, 0.16)
    if kind == "flat":
        height, pieces = thick, [box_between((-x, size.top, -z), (x, size.top + thick, z))]
    elif kind == "hollow":
        height = draw.between(0.08, 0.5) * size.top + 0.03
        wall = max(size.wall, 0.008)
        shell = _tub(_Size(x, z, height, wall))
        pieces = [transform(piece, rotation_about((0, 0, 1), 180, (0, height / 2, 0))) for piece in shell]
        pieces = [move(piece, (0, size.top, 0)) for piece in pieces]
    else:
        height = draw.between(0.3, 0.9) * z
        pieces = [_vault(x, z, height, size.top, solid=draw.chance(0.4))]
    edge_height = size.top + draw.pick([0.0, 0.5 * thick, -0.02])
    edge = np.array([0, edge_height, -z + draw.pick([0.0, over, -draw.between(0.0, 0.03)])])
    opens = draw.pick([90.0, 110.0, 130.0, 180.0], [2, 2, 3, 3])
    rest = draw.between(25, min(opens, 125)) if draw.chance(0.8) else 0.0
    motion = hinge(edge, (-1, 0, 0), 0, opens, rest=rest)
    group = above.add("chest_lid") if nested else above
    node = group.add("lid_surface" if nested else draw.pick(["rotation_lid", "lid"], [4, 1]), *pieces)
    lid = Link("rotation_lid", [node], base, motion, leaf_name="rotation_lid")
    links = [lid]
    if draw.chance(0.3):
        hinges = [cylinder(0.02, 0.12, "x", edge + [s * 0.6 * x, 0, 0], 10) for s in (-1, 1)]
        owner = draw.pick([base, lid])
        owner.nodes.append(group.add("hinge", *hinges))
    if draw.chance(0.55):
        links += _locks(draw, above, base, lid, size, z)
    return links


def _vault(x: float, z: float, height: float, low: float, *, solid: bool) -> Mesh:
    """A barrel-shaped lid: half an elliptic cylinder along x, solid or a shell."""
    angles = np.linspace(0, np.pi, 13)
    outer = np.stack([height * np.sin(angles), z * np.cos(angles)], axis=1)
    if solid:
        return extrude(outer, 2 * x, "x", (0, low, 0))
    inner = 0.9 * outer
    shells = [extrude(outer, 2 * x, "x", capped=False), inside_out(extrude(inner, 2 * x, "x", capped=False))]
    return move(join(*shells), (0, low, 0))


def _locks(draw: Draw, above: Node, base: Link, lid: Link, size: _Size, z: float) -> list[Link]:
    """One to three clasps across the seam at the front."""
    links = []
    tall = min(draw.between(0.03, 0.26), 0.6 * size.top)
    places = draw.pick([[0.0], [-0.6, 0.6], [-0.4, 0.4], [-0.7, 0.0, 0.7]], [5, 3, 1, 1])
    for same, place in zip(draw.identical(len(places)), places, strict=True):
        links += add_clasp(same, above, base, lid, facing(Z, Y, (place * size.x, size.top, z)), tall)
    return links


def _flaps(draw: Draw, above: Node, base: Link, size: _Size) -> list[Link]:
    """Two or four flaps on the rim of a carton, each open by its own angle."""
    thick = max(0.004, 0.3 * size.wall)
    links = []
    sides = draw.pick([("left", "right"), ("front", "back"), ("left", "right", "front", "back")], [1, 1, 3])
    open_all = draw.chance(0.85)
    for level, side in enumerate(sides):
        y = size.top + thick * (0.5 + (level // 2))
        if side in ("left", "right"):
            out, reach = (-1.0 if side == "left" else 1.0), min(size.x, size.z)
            slab = box((reach, thick, 2 * size.z), (out * (size.x - reach / 2), y, 0))
            edge, along = np.array([out * size.x, y - thick / 2, 0]), np.array([0, 0, -out])
        else:
            out, reach = (-1.0 if side == "back" else 1.0), size.z
            slab = box((2 * size.x, thick, reach), (0, y, out * (size.z - reach / 2)))
            edge, along = np.array([0, y - thick / 2, out * size.z]), np.array([out, 0, 0])
        opens = draw.pick([180.0, 230.0, 270.0])
        rest = draw.between(60, 0.9 * opens) if open_all or draw.chance(0.2) else 0.0
        node = above.add(draw.pick(["rotation_lid", "flap"], [3, 1]), slab)
        links.append(Link("rotation_lid", [node], base, hinge(edge, along, 0, opens, rest=rest)))
    return links


def _split_lid(draw: Draw, above: Node, base: Link, size: _Size) -> list[Link]:
    """Two half lids that open to opposite sides, hinged at the outer edges or at the middle."""
    thick, links = draw.between(0.02, 0.1), []
    outer = draw.chance(0.6)
    opens = draw.pick([90.0, 110.0, 180.0]) if outer else draw.pick([80.0, 90.0])
    rest = draw.between(20, 0.9 * opens) if draw.chance(0.6) else 0.0
    for side in (-1.0, 1.0):
        slab = box((size.x - 0.01, thick, 2 * size.z), (side * (size.x / 2 + 0.005), size.top + thick / 2, 0))
        edge = (side * (size.x if outer else 0.01), size.top + draw.pick([0.0, thick]), 0)
        motion = hinge(edge, (0, 0, -side if outer else side), 0, opens, rest=rest if side > 0 or draw.chance(0.6) else 0.0)
        links.append(Link("rotation_lid", [above.add("rotation_lid", slab)], base, motion))
    return links


def _loose_lid(draw: Draw, above: Node, base: Link, size: _Size) -> list[Link]:
    """A lid that lifts off, or a board that slides out along x or z."""
    thick = draw.between(0.015, 0.1)
    if draw.chance(0.55):
        over = draw.between(0.0, 0.04)
        skirt = draw.between(0.0, 0.4) * size.top
        pieces = [box_between((-size.x - over, size.top, -size.z - over), (size.x + over, size.top + thick, size.z + over))]
        if skirt > 0.05 and over > 0.01:
            for s in (-1, 1):
                pieces.append(box((over, skirt, 2 * size.z), (s * (size.x + over / 2), size.top - skirt / 2, 0)))
        if draw.chance(0.4):
            pieces.append(cylinder(0.05, 0.08, "y", (0, size.top + thick + 0.04, 0), 16))
        reach = draw.between(0.2, 1.0)
        motion = slider((0, 1, 0), 0, reach, rest=reach * draw.pick([0.0, draw.between(0.1, 0.9)], [2, 1]))
    else:
        pieces = [box_between((-size.x, size.top - thick, -size.z), (size.x, size.top, size.z))]
        if draw.chance(0.5):
            pieces.append(box((0.2 * size.x, 0.02, 0.04), (0, size.top + 0.01, 0.8 * size.z)))
        direction, length = draw.pick([(Z, 2 * size.z), (X, 2 * size.x)], [2, 1])
        reach = length * draw.between(0.6, 1.0)
        motion = slider(direction, 0, reach, rest=reach * draw.pick([0.0, draw.between(0.1, 0.8)]))
    return [Link("lid", [above.add(draw.pick(["translation_lid", "lid"]), *pieces)], base, motion, leaf_name="lid")]


def _tray(draw: Draw, above: Node, base: Link, size: _Size) -> list[Link]:
    """A case, open at one side, and a tray that slides out of it."""
    wall = max(size.wall, 0.01)
    base.nodes[0].pieces[:] = [
        box_between((-size.x, size.top, -size.z), (size.x, size.top + wall, size.z)),
        box_between((-size.x, 0, -size.z), (size.x, wall, size.z)),
        *(box((wall, size.top - wall, 2 * size.z), (s * (size.x - wall / 2), (size.top + wall) / 2, 0)) for s in (-1, 1)),
    ]
    inner = _tub(_Size(size.x - 1.2 * wall, size.z, size.top - 2.4 * wall, 0.7 * wall))
    pieces = [move(piece, (0, 1.2 * wall, 0)) for piece in inner]
    if draw.chance(0.5):
        pieces.append(cylinder(0.04, 0.06, "z", (0, 0.5 * size.top, size.z + 0.03), 14))
    reach = 2 * size.z * draw.between(0.6, 1.0)
    motion = slider(Z, 0, reach, rest=reach * draw.pick([0.0, draw.between(0.1, 0.8)]))
    return [Link("drawer", [above.add(draw.pick(["drawer", "tray"]), *pieces)], base, motion)]


def _decorate(draw: Draw, above: Node, base: Link, size: _Size) -> None:
    """Add feet, corner fittings, bands around the body, or an object inside."""
    body = base.nodes[0]
    kind = draw.pick(["none", "feet", "corners", "bands", "contents"], [4, 2, 2, 2, 1])
    corners = [(sx * size.x, sz * size.z) for sx in (-1, 1) for sz in (-1, 1)]
    if kind == "feet":
        body.pieces += [box((0.08, 0.06, 0.08), (0.9 * cx, -0.03, 0.9 * cz)) for cx, cz in corners]
    elif kind == "corners":
        body.pieces += [box((0.1, 0.1, 0.1), (cx * 0.97, h, cz * 0.97)) for cx, cz in corners for h in (0.04, size.top - 0.06)]
    elif kind == "bands":
        for height in (0.2, 0.7):
            body.pieces.append(box((2.02 * size.x, 0.05, 2.02 * size.z), (0, height * size.top, 0)))
    elif kind == "contents":
        lump = turn(box((0.8 * size.x, 0.5 * size.top, 0.7 * size.z)), (0, 1, 0), draw.between(-30, 30))
        base.nodes.append(above.add("other", move(lump, (0, 0.3 * size.top, 0))))


def _side_handles(draw: Draw, above: Node, base: Link, size: _Size) -> list[Link]:
    """Two carrying handles, at the ends or at the front, hanging down or standing out."""
    links = []
    half = draw.between(0.1, 0.3) * size.z
    height, movable, hangs = draw.between(0.55, 0.95) * size.top, draw.chance(0.7), draw.chance(0.8)
    walls = draw.pick(["ends", "front"], [5, 1])
    for same, side in zip(draw.identical(2), (-1.0, 1.0), strict=True):
        wall = (side * X, (side * size.x, height, 0)) if walls == "ends" else (Z, (side * 0.5 * size.x, height, size.z))
        place = facing(wall[0], Y, wall[1])
        links += add_carrying_handle(same, above, base, place, half, hangs=hangs, movable=movable)
    return links
