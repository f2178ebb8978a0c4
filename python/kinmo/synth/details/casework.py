"""Drawers, doors and legs of furniture, named and nested as in PartNet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, box, box_between, cylinder, join, lathe, move, open_box, turn
from kinmo.synth.synth_object import Link, Node, hinge, slider

MOST_BESIDE_A_FRONT = 120.0
"""Largest opening in degrees of a front that would turn into the one beside it."""


def add_drawer(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts) -> Link:
    """Add a drawer that slides to +z. Its box is a group of boards, one block, or a block together with the front."""
    node = above.add("drawer")
    box_node = node.add("drawer_box")
    face, back = fronts.face(opening), fronts.back_plane(opening)
    box_node.add("drawer_front", *fronts.panel(draw, opening))
    depth = _add_drawer_box(draw, box_node, opening, back)
    if fronts.has_handles:
        count = 2 if face.width > 0.8 and draw.chance(0.3) else 1
        length = min(fronts.handle_length, 0.8 * face.width / count)
        y = face.y + draw.pick([0.0, 0.3, draw.between(-0.35, 0.42), 0.47], [4, 1, 1, 0.6]) * face.height
        aside = draw.pick([0.0, draw.between(-0.35, 0.35)], [6, 1]) * face.width if count == 1 else 0.0
        for place in range(count):
            x = face.x + face.width * ((place + 0.5) / count - 0.5) + aside
            node.add("handle", *fronts.grip(draw, length, (x, y, fronts.surface(opening)), opening, vertical=False))
    fronts.fit(draw, node, opening)
    if draw.chance(0.1):
        _add_runners(draw, above, carcass, opening, back - depth, back)
    travel = depth * draw.between(0.35, 1.0)
    rest = travel * draw.between(0.2, 0.95) if draw.chance(0.15) else 0.0
    return Link("drawer", [node], carcass, slider((0, 0, 1), 0, travel, rest=rest))


def _add_drawer_box(draw: Draw, node: Node, opening: Opening, back: float) -> float:
    """Add the boards behind a drawer's front; returns their depth."""
    board = min(draw.ratio(0.006, 0.05), 0.1 * opening.width)
    clear = draw.pick([0.0, draw.between(0.002, 0.03)])
    depth = opening.depth * draw.between(0.5, 0.98)
    half = opening.width / 2 - clear
    low, high = opening.low + clear, opening.low + opening.height * draw.between(0.5, 0.95)
    far = back - depth
    form = draw.pick(["boards", "loose", "block", "slab", "tub", "front only"], [13, 3, 2, 1.5, 3, 1.5])
    if form == "block":
        block = box_between((opening.x - half, low, far), (opening.x + half, high, back))
        node.children[0].pieces.append(block)
        return depth
    if form == "slab":
        # The front is the end of the block.
        front = np.max([piece.vertices[:, 2].max() for piece in node.children[0].pieces])
        top = opening.high - clear
        node.children[0].pieces[:] = [box_between((opening.x - half, low, far), (opening.x + half, top, front))]
        return depth
    if form == "tub":
        # An open box stands on its back: its front (+z) is turned up.
        size = (2 * half, depth, high - low)
        tub = turn(
            open_box((-half, -depth / 2, -size[2] / 2), (half, depth / 2, size[2] / 2), min(board, 0.3 * size[2])), X, -90.0
        )
        node.add("drawer_box", move(tub, (opening.x, 0.5 * (low + high), back - depth / 2)))
    if form not in ("boards", "loose"):
        return depth
    rim = low + draw.pick([1.0, draw.between(0.5, 1.0)], [3, 1]) * (high - low)
    inner, thin = half - board, draw.pick([board, 0.5 * board, 0.0], [6, 3, 1])
    lies_below = draw.chance(0.3)  # the walls stand on the bottom
    floor, foot = (low, low + thin) if lies_below else (low + draw.pick([0.0, 0.3 * board]), low)
    for side in (-1, 1):
        x = opening.x + side * (half - board / 2)
        node.add("drawer_side", box_between((x - board / 2, foot, far), (x + board / 2, rim, back)))
    node.add("drawer_back", box_between((opening.x - inner, foot, far), (opening.x + inner, high, far + board)))
    across = half if lies_below else inner
    bottom = box_between((opening.x - across, floor, far), (opening.x + across, floor + thin, back))
    node.add("drawer_bottom", bottom)
    if draw.chance(0.08):
        # Walls that divide the space in the drawer.
        for place in np.linspace(-inner, inner, draw.integer(1, 3) + 2)[1:-1]:
            x = opening.x + place
            node.add("drawer_side", box_between((x - board / 4, floor, far), (x + board / 4, 0.5 * (low + rim), back)))
    if form == "loose":
        node.children[0].pieces += [piece for child in node.children[1:] for piece in child.pieces]
        del node.children[1:]
    if draw.chance(0.3):
        order = sorted(range(len(node.children)), key=lambda _: draw.integer(0, 1 << 20))
        node.children[:] = [node.children[i] for i in order]
    return depth


def _add_runners(draw: Draw, above: Node, carcass: Link, opening: Opening, rear: float, front: float) -> None:
    """Add two bars of the carcass that a drawer runs on, at its sides or below it."""
    thin = min(0.04 * opening.width, 0.1 * opening.height)
    y = opening.low + draw.pick([0.5 * thin, 0.4 * opening.height])
    for side in (-1, 1):
        at = (opening.x + side * (0.5 * opening.width - 0.5 * thin), y, 0.5 * (rear + front))
        carcass.nodes.append(above.add(draw.pick(["rail", "bar", "other_leaf"]), box((thin, thin, front - rear), at)))


def add_door(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts, side: str) -> Link:
    """Add a door with a handle near the edge opposite to its hinge.

    Args:
        above: Node that the door is added below.
        carcass: Link that carries the door.
        opening: The opening that the door closes.
        fronts: Style of the door.
        side: Edge of the hinge: "left", "right", "top" or "bottom".

    Returns:
        Link of the door.
    """
    face, back = fronts.face(opening), fronts.back_plane(opening)
    width, height = face.width, face.height
    node = above.add("cabinet_door")
    node.add("cabinet_door_surface", *fronts.panel(draw, opening))
    out = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}[side]
    upright = out[0] != 0
    if fronts.has_handles:
        margin = draw.pick([draw.between(0.04, 0.14), draw.between(0.14, 0.5)], [6, 1]) * (width if upright else height)
        along = draw.pick([0.0, draw.between(-0.42, 0.42)], [2, 1])
        x = face.x - out[0] * (width / 2 - margin) + (0 if upright else along * width * 0.3)
        y = face.y - out[1] * (height / 2 - margin) + (along * height if upright else 0)
        length = min(fronts.handle_length * draw.between(0.8, 1.5), 0.7 * (height if upright else width))
        length = min(length, 2.0 * (0.5 - abs(along)) * height) if upright else length
        lies_along = draw.chance(0.9) or length > 0.5 * min(width, height)
        foot = (x, y, fronts.surface(opening))
        node.add("handle", *fronts.grip(draw, length, foot, opening, vertical=upright == lies_along))
    inward = draw.pick([0.0, draw.between(0.0, 0.02), draw.between(0.02, 0.05)], [4, 4, 1]) * (width if upright else height)
    lift = draw.pick([0.0, 0.5, 1.0, -0.2], [4, 3, 2, 1])
    axis = np.array([face.x, face.y, back + fronts.thickness * lift])
    axis[0 if upright else 1] += (out[0] * width if upright else out[1] * height) / 2 - (sum(out) * inward)
    if draw.chance(0.2):
        _add_hinges(draw, node, above, carcass, axis, upright, height if upright else width)
    fronts.fit(draw, node, opening, side)
    direction = (0, out[0], 0) if upright else (-out[1], 0, 0)
    opens = draw.pick([90.0, 120.0, 160.0, 180.0], [6, 2, 1, 1])
    if fronts.gap < 0 and lift < 1.0:
        opens = min(opens, MOST_BESIDE_A_FRONT)
    rest = draw.between(10, 0.9 * opens) if draw.chance(0.12) else 0.0
    return Link("cabinet_door", [node], carcass, hinge(axis, direction, 0, opens, rest=rest), leaf_name="door")


def add_door_pair(
    draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts, width: float | None = None
) -> list[Link]:
    """Add two doors that meet in the middle of an opening. Inset ones are `width` wide (default: half of the opening)."""
    links = []
    around = opening.border or (max(-fronts.gap, 0.0),) * 4
    for sign, side in ((-1, "left"), (1, "right")):
        border = (around[0] if sign < 0 else 0.0, around[1] if sign > 0 else 0.0, around[2], around[3])
        wide = opening.width / 2 if width is None or fronts.gap < 0 else width
        half = replace(opening, x=opening.x + sign * opening.width / 4, width=wide, border=border)
        links.append(add_door(draw, above, carcass, half, fronts, side))
    return links


def legs(draw: Draw, half_x: float, half_z: float, low: float, high: float, thickness: float) -> list[Mesh]:
    """Meshes of four legs between the heights `low` and `high`: square, round, tapered, splayed or turned."""
    kind = draw.pick(["square", "round", "tapered", "splayed", "turned"], [5, 2, 2, 1, 1])
    length, middle = high - low, 0.5 * (low + high)
    if kind == "square":
        leg = box((thickness, length, thickness))
    elif kind == "round":
        leg = cylinder(thickness / 2, length, segments=draw.pick([8, 16, 24]))
    elif kind == "turned":
        share = np.linspace(-0.5, 0.5, 9)
        radius = 0.5 * thickness * np.array([0.5] + [draw.between(0.5, 1.2) for _ in range(7)] + [1.0])
        profile = np.stack([radius, share * length], axis=1)
        leg = lathe(np.concatenate([[[0.0, -0.5 * length]], profile, [[0.0, 0.5 * length]]]), 14)
    else:
        leg = cylinder(0.3 * thickness, length, segments=draw.pick([4, 8, 16]), top_radius=0.55 * thickness)
    found = []
    for sx, sz in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
        tilted = turn(turn(leg, (0, 0, 1), 6.0 * sx), (1, 0, 0), -6.0 * sz) if kind == "splayed" else leg
        found.append(move(tilted, (sx * half_x, middle, sz * half_z)))
    return found


def _add_hinges(draw: Draw, node: Node, above: Node, carcass: Link, axis: np.ndarray, upright: bool, length: float) -> None:
    """Add two small hinge barrels on a door's axis, to the door's `node`, or below `above` to the carcass."""
    on_carcass = draw.chance(0.3)
    radius = 0.01
    for place in (-0.35, 0.35):
        at = axis + np.array([0, place * length, 0] if upright else [place * length, 0, 0])
        barrel = cylinder(radius, 0.08 * length, "y" if upright else "x", at, 10)
        plate = box((0.04, 0.08 * length, 0.004) if upright else (0.08 * length, 0.04, 0.004), at)
        pieces = draw.pick([[barrel], [join(barrel, plate)]])
        if on_carcass:
            carcass.nodes.append(above.add("hinge", *pieces))
        else:
            node.add("hinge", *pieces)
