"""Suitcases with lids, clasps, carrying handles, telescopic handles and wheels."""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.details.carrying_handles import add_carrying_handle
from kinmo.synth.details.clasps import add_clasp
from kinmo.synth.details.posture import turn_about_up
from kinmo.synth.details.wheels import add_caster, wheel_pieces
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    arc_path,
    box,
    box_between,
    cylinder,
    facing,
    move,
    rotation_about,
    rounded_box,
    sweep,
)
from kinmo.synth.synth_object import Link, Node, SynthObject, hinge, slider, spinner

LYING_SHARE = 0.35
"""Share of cases that lie on their back."""
TURNED_SHARE = 0.15
"""Share of suitcases that are turned about the vertical by any quarter."""


def build(draw: Draw) -> SynthObject:
    """Suitcase.

    Variants: a case hinged at its lower edge with clasps, a bag whose handles swing, and a trolley with a handle that slides up
    and wheels that roll or swivel.
    """
    root = Node(draw.pick(["Suitcase", "luggage"], [3, 1]))
    kind = draw.pick(["case", "bag", "trolley"], [5, 2, 3])
    links = {"case": _case, "bag": _bag, "trolley": _trolley}[kind](draw, root)
    shape = SynthObject("Suitcase", root, links)
    if kind == "case" and draw.chance(LYING_SHARE):
        # The lid comes to lie on top, with its hinge at the rear.
        shape.move(rotation_about(Y, 180.0) @ rotation_about(X, -90.0))
    if draw.chance(TURNED_SHARE):
        turn_about_up(draw, shape)
    return shape


def _half(draw: Draw, width: float, height: float, back: float, front: float, *, hollow: bool) -> list[Mesh]:
    """Half a shell between two planes z: a rounded slab, or four walls and an outer floor."""
    if not hollow:
        return [rounded_box((width, height, front - back), draw.between(0.02, 0.2), "z", (0, 0, 0.5 * (back + front)))]
    wall, x, y = 0.02, width / 2, height / 2
    outside = (back, back + wall) if back < 0 else (front - wall, front)
    return [
        box_between((-x, -y, back), (-x + wall, y, front)),
        box_between((x - wall, -y, back), (x, y, front)),
        box_between((-x, -y, back), (x, -y + wall, front)),
        box_between((-x, y - wall, back), (x, y, front)),
        box_between((-x, -y, outside[0]), (x, y, outside[1])),
    ]


def _case(draw: Draw, root: Node) -> list[Link]:
    """Two halves hinged at the lower edge, with a carrying handle and clasps at the upper edge."""
    width, height, depth = draw.ratio(0.8, 2.0), draw.ratio(0.7, 1.4), draw.ratio(0.15, 0.8)
    split = depth * draw.between(-0.15, 0.35)
    rest = draw.between(60, 110) if draw.chance(0.45) else 0.0
    hollow = rest > 0 or draw.chance(0.5)
    base = Link("base_body", [root.add("base_body", *_half(draw, width, height, -depth / 2, split, hollow=hollow))])
    low = -height / 2
    axis = (0, low + draw.pick([0.0, 0.02]), split + draw.pick([0.0, -0.01]))
    lid_node = root.add("lid", *_half(draw, width, height, split, depth / 2, hollow=hollow))
    lid = Link("lid", [lid_node], base, hinge(axis, (1, 0, 0), 0, draw.pick([90.0, 120.0, 180.0]), rest=rest))
    links = [base, lid]
    grip = facing(Y, Z, (0, height / 2, split - draw.pick([0.0, 0.04, draw.between(0.0, 0.5) * depth])))
    handle = add_carrying_handle(draw, root, base, grip, 0.5 * width * draw.between(0.12, 0.4), movable=draw.chance(0.9))
    links += handle
    sides = draw.pick([(), (-1, 1), (0,)], [2, 7, 1])
    size = draw.between(0.04, 0.26)
    for same, side in zip(draw.identical(len(sides)), sides, strict=True):
        # On the upper edge the lid is in front of the seam.
        place = facing(Y, Z, (side * draw.between(0.3, 0.38) * width, height / 2, split))
        links += add_clasp(same, root, base, lid, place, size)
    return links


def _bag(draw: Draw, root: Node) -> list[Link]:
    """A soft body with one or two high handles that swing about its upper edge."""
    width, height, depth = draw.between(1.1, 1.5), draw.between(0.6, 1.0), draw.between(0.3, 0.6)
    axis = draw.pick(["x", "y", "z"])
    pieces = [rounded_box((width, height, depth), draw.between(0.05, 0.25), axis)]
    if draw.chance(0.6):
        pieces += [box((0.06, 1.01 * height, 1.02 * depth), (s * 0.3 * width, 0, 0)) for s in (-1, 1)]
    base = Link("base_body", [root.add("base_body", *pieces)])
    links = [base]
    count = draw.pick([1, 2], [1, 2])
    for index in range(count):
        z = 0.0 if count == 1 else (index - 0.5) * depth * draw.between(0.3, 0.9)
        half, rise = width * draw.between(0.15, 0.48), draw.between(0.3, 0.8)
        foot = height / 2 - draw.between(0.0, 0.1)
        path = arc_path((0, foot, z), half, 0, 180, "z", 16, aspect=rise / half)
        node = root.add("handle", sweep(path, draw.between(0.012, 0.03), 8))
        out = 1.0 if z >= 0 else -1.0
        limits = (-90.0, 90.0) if count == 1 else (-3.0, 170.0)
        links.append(Link("handle", [node], base, hinge((0, foot, z), (out, 0, 0), *limits)))
    return links


def _trolley(draw: Draw, root: Node) -> list[Link]:
    """An upright case with two to four wheels, a handle that slides up, and grips."""
    width, height, depth = draw.ratio(0.5, 1.2), draw.ratio(0.8, 1.6), draw.ratio(0.25, 0.7)
    x, y, z = width / 2, height / 2, depth / 2
    case = rounded_box((width, height, depth), draw.between(0.02, 0.15), draw.pick(["y", "z"]))
    ribs = [box((0.03, 0.95 * height, 0.02), (s * 0.15 * width, 0, z)) for s in range(-2, 3)] if draw.chance(0.4) else []
    base = Link("base_body", [root.add("base_body", case, *ribs)])
    links = [base]
    links += _telescope(draw, root, base, width, y, -z)
    wheels = _wheels(draw, root, base, x, y, z)
    if draw.chance(0.4):
        base.nodes += [node for wheel in wheels for node in wheel.nodes]
    else:
        links += wheels
    if draw.chance(0.5):
        grip = facing(Y, Z, (0, y, z * draw.between(0.0, 0.5)))
        links += add_carrying_handle(draw, root, base, grip, width * draw.between(0.12, 0.25), movable=draw.chance(0.7))
    if draw.chance(0.3):
        # A grip at the side.
        grip = facing(X, Z, (x, draw.between(-0.1, 0.2) * height, 0))
        links += add_carrying_handle(draw, root, base, grip, height * draw.between(0.08, 0.15), movable=draw.chance(0.6))
    if draw.chance(0.25):
        links.append(_front_lid(draw, root, base, (width, height), z))
    return links


def _front_lid(draw: Draw, root: Node, base: Link, size: tuple[float, float], front: float) -> Link:
    """A thin pocket or a thick half on the front (z = `front`) of an upright case, hinged at any edge."""
    share, thick = draw.between(0.7, 1.0), draw.ratio(0.03, 0.3)
    wide, high = share * size[0], share * size[1] * draw.between(0.6, 1.0)
    level = draw.between(-0.5, 0.5) * (share * size[1] - high)
    node = root.add(
        draw.pick(["lid", "pocket", "door"], [6, 1, 1]),
        rounded_box((wide, high, thick), 0.1 * wide, "z", (0, level, front + 0.5 * thick)),
    )
    deep = front + draw.pick([0.0, 0.5, 1.0], [4, 1, 1]) * thick
    axis, at = draw.pick(
        [
            (-Y, (-0.5 * wide, 0, deep)),
            (Y, (0.5 * wide, 0, deep)),
            (X, (0, level - 0.5 * high, deep)),
            (-X, (0, level + 0.5 * high, deep)),
        ],
        [4, 4, 2, 1],
    )
    opens = draw.between(80.0, 175.0)
    rest = draw.pick([0.0, draw.between(0.1, 0.8) * opens], [2, 1])
    return Link("lid", [node], base, hinge(at, axis, 0.0, opens, rest=rest))


def _telescope(draw: Draw, root: Node, base: Link, width: float, top: float, rear: float) -> list[Link]:
    """A grip on one or two rods that slides out of the case, sometimes in two stages."""
    reach, half = draw.between(0.3, 1.0) * top, draw.between(0.2, 0.42) * width
    z, rod = rear + draw.pick([draw.between(0.03, 0.08), -0.02], [3, 1]), draw.between(0.012, 0.022)
    foot, crown = top - reach * draw.between(0.9, 1.1), top + draw.between(0.02, 0.06)
    offsets = draw.pick([(-1.0, 1.0), (0.0,)], [5, 1])
    rods: list[Mesh] = [box_between((s * half - rod, foot, z - rod), (s * half + rod, crown, z + rod)) for s in offsets]
    if draw.chance(0.6):
        grip = box((2 * half + 4 * rod, 3 * rod, 3 * rod), (0, crown, z))
    else:
        grip = cylinder(1.6 * rod, 2 * half + 4 * rod, "x", (0, crown, z), 12)
    links, carrier = [], base
    if draw.chance(0.25):
        sleeves = [box((3 * rod, crown - foot, 3 * rod), (s * half, 0.5 * (crown + foot) - rod, z)) for s in offsets]
        out = slider((0, 1, 0), 0, 0.8 * reach, rest=draw.pick([0.0, draw.between(0.2, 0.8) * reach]))
        carrier = Link("rod", [root.add(draw.pick(["rod", "handle"]), *sleeves)], base, out, leaf_name="translation_handle")
        links.append(carrier)
    node = root.add(draw.pick(["handle", "translation_handle"]), *rods, grip)
    rest = reach * draw.between(0.3, 1.0) if draw.chance(0.5) else 0.0
    motion = slider((0, 1, 0), 0, reach, rest=rest)
    return [*links, Link("handle", [node], carrier, motion, leaf_name="translation_handle")]


def _wheels(draw: Draw, root: Node, base: Link, x: float, y: float, z: float) -> list[Link]:
    """Two or four wheels that roll about x; four wheels may be casters that swivel about y."""
    links: list[Link] = []
    radius = draw.ratio(0.03, 0.1)
    thick, drop = radius * draw.ratio(0.35, 1.1), radius * draw.between(2.1, 2.6)
    rows = draw.pick([(-1,), (-1, 1)])
    casters = len(rows) == 2 and draw.chance(0.5)
    if len(rows) == 1 and draw.chance(0.5):
        feet = [box((0.04, 1.2 * radius, 0.04), (s * (x - 0.05), -y - 0.6 * radius, z - 0.05)) for s in (-1, 1)]
        base.nodes.append(root.add("foot", *feet))
    places = [(sx * (x - thick), sz * (z - radius)) for sz in rows for sx in (-1, 1)]
    for own, (right, ahead) in zip(draw.identical(len(places)), places, strict=True):
        if casters:
            heading = draw.between(0.0, 360.0)
            links += add_caster(own, root, base, (right, -y, ahead), drop, radius, thick, heading=heading)
        else:
            at = (right, -y - 0.6 * radius, ahead)
            node = root.add("wheel", *(move(piece, at) for piece in wheel_pieces(own, radius, thick)))
            links.append(Link("wheel", [node], base, spinner(at, (1, 0, 0))))
    return links
