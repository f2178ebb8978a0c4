"""Windows with sashes that slide or turn."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.appliances import frame_bars, rectangular_frame
from kinmo.synth.details.door_leaves import sash
from kinmo.synth.details.door_locks import add_door_lock
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, cylinder, join, move
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, slider

BARS_SHARE = 0.3
"""Share of windows whose frame is a part for each bar."""
BOARD_SHARE = 0.15
"""Share of sashes that are a plain board."""


def build(draw: Draw) -> SynthObject:
    """Window.

    Variants: sashes that slide sideways or up, casements hinged at a side, awnings hinged at the upper or lower edge, and
    sashes that turn about their middle. Locks turn.
    """
    width, height = draw.between(0.9, 1.6), draw.between(0.9, 1.6)
    rim, depth = draw.between(0.04, 0.1), draw.between(0.06, 0.16)
    root = Node(draw.pick(["Window", "window"], [4, 1]))
    half = np.array([width / 2, height / 2, depth / 2])
    body = root.add("base_body", rectangular_frame(-half, half, rim))
    if draw.chance(0.3):
        body.pieces.append(box((1.1 * width, 0.04, 2 * depth), (0, -height / 2 - 0.02, depth / 2)))
    base = Link("base_body", [body], kind=JointType.STATIC)
    if draw.chance(BARS_SHARE):
        first, *others = frame_bars(-half, half, rim)
        body.pieces[0] = first
        base.nodes += [root.add("frame", bar) for bar in others]
    opening = (width - 2 * rim, height - 2 * rim)
    kind = draw.pick(["slide", "hung", "casement", "awning", "pivot"], [4, 3, 4, 3, 1])
    if kind in ("slide", "hung"):
        links = _sliding(draw, root, base, opening, depth, upright=kind == "hung")
    else:
        links = _turning(draw, root, base, opening, depth, kind)
    return SynthObject("Window", root, [base, *links])


def _add_sash(draw: Draw, root: Node, name: str, size: tuple[float, float], at: np.ndarray, thickness: float) -> Node:
    """Add a sash as one leaf, or as a frame and a pane. Some are a plain board."""
    if draw.chance(BOARD_SHARE):
        return root.add(name, box((*size, thickness), at))
    bars, glass = sash(draw, *size, thickness)
    bars, glass = [move(piece, at) for piece in bars], [move(piece, at) for piece in glass]
    if draw.chance(0.6):
        return root.add(name, *bars, *glass)
    node = root.add(name)
    node.add("frame", *bars)
    node.add("glass", *glass)
    half = 0.5 * np.array(size)
    add_fittings(draw, node, at[:2] - half, at[:2] + half, at[2] + 0.5 * thickness)
    return node


def _sliding(draw: Draw, root: Node, base: Link, size: tuple[float, float], depth: float, *, upright: bool) -> list[Link]:
    """Two or three sashes on tracks; at least one slides past another."""
    along = 1 if upright else 0
    count = 2 if upright else draw.pick([2, 3], [4, 1])
    overlap = draw.between(0.0, 0.04)
    length = size[along] / count + overlap / 2
    thickness = depth * draw.between(0.3, 0.45)
    links: list[Link] = []
    for index in range(count):
        place = (index + 0.5) / count - 0.5
        at = np.zeros(3)
        at[along] = place * (size[along] - overlap)
        at[2] = (-0.25 if index % 2 else 0.25) * depth
        extent = (size[0], length) if upright else (length, size[1])
        moves = draw.chance(0.8) or (index == count - 1 and not links)
        node = _add_sash(draw, root, "translation" if moves else "fixed_sash", extent, at, thickness)
        if not moves:
            base.nodes.append(node)
            continue
        direction = np.zeros(3)
        direction[along] = -1.0 if place > 0 else 1.0
        travel = length * draw.between(0.75, 0.98)
        rest = travel * draw.between(0.1, 0.8) if draw.chance(0.25) else 0.0
        motion = slider(direction, draw.pick([0.0, -0.01]), travel, rest=rest)
        links.append(Link("translation_window", [node], base, motion, leaf_name="translation"))
    return links


def _turning(draw: Draw, root: Node, base: Link, size: tuple[float, float], depth: float, kind: str) -> list[Link]:
    """One or two sashes that turn about a side, the upper or lower edge, or their middle, beside fixed ones."""
    pair = kind == "casement" and draw.chance(0.4)
    columns = 2 if pair or draw.chance(0.4) else 1
    rows = 2 if not pair and draw.chance(0.25) else 1
    width, height = size[0] / columns, size[1] / rows
    thickness = depth * draw.between(0.3, 0.8)
    moving = {(0, 0), (1, 0)} if pair else {(draw.integer(0, columns - 1), draw.integer(0, rows - 1))}
    links = []
    for column in range(columns):
        for row in range(rows):
            at = np.array([width * (column + 0.5) - size[0] / 2, height * (row + 0.5) - size[1] / 2, 0.0])
            if (column, row) not in moving:
                bars, glass = sash(draw, width, height, 0.8 * thickness)
                base.nodes[0].pieces += [move(piece, at) for piece in bars + glass]
                continue
            at[2] = draw.pick([0.0, depth / 2])
            gap = draw.pick([0.0, 0.005])
            node = _add_sash(draw, root, "rotation", (width - 2 * gap, height - 2 * gap), at, thickness)
            out = (1.0 if column else -1.0) if pair else draw.sign()
            motion, handle_side = _axis(draw, kind, at, width, height, thickness, out)
            leaf = Link("rotation_window", [node], base, motion, leaf_name="rotation")
            links.append(leaf)
            if draw.chance(0.15):
                front = at + handle_side * [0.46 * width, 0.46 * height, 0] + [0, 0, 0.5 * thickness]
                links.append(add_door_lock(draw, root, leaf, draw.pick(["lever", "tee"]), front, draw.between(0.06, 0.15)))
            else:
                _latch(draw, node, at, handle_side, (width, height), thickness)
    return links


def _axis(
    draw: Draw, kind: str, at: np.ndarray, width: float, height: float, thickness: float, out: float
) -> tuple[Motion, np.ndarray]:
    """The hinge of a sash, and the direction [3] from its middle to its handle."""
    rest = draw.between(10, 80) if draw.chance(0.5) else 0.0
    lift = np.array([0, 0, thickness * draw.pick([0.0, 0.5, -0.3])])
    if kind == "casement":
        axis = at + lift + [out * (width / 2 - draw.between(0.0, 0.03)), 0, 0]
        return hinge(
            axis, (0, out * draw.pick([1.0, -1.0], [4, 1]), 0), 0, draw.pick([90.0, 150.0, 175.0]), rest=rest
        ), np.array([-out, 0, 0])
    if kind == "awning":
        upper = 1.0 if draw.chance(0.7) else -1.0
        axis = at + lift + [0, upper * (height / 2 - draw.between(0.0, 0.03)), 0]
        return hinge(axis, (-upper, 0, 0), 0, draw.pick([45.0, 90.0]), rest=0.6 * rest), np.array([0, -upper, 0])
    direction = draw.pick([(1, 0, 0), (0, 1, 0)])
    return hinge(at, direction, -90, 90, rest=draw.sign() * rest), np.array([1, 0, 0])


def _latch(draw: Draw, node: Node, at: np.ndarray, side: np.ndarray, size: tuple[float, float], thickness: float) -> None:
    """Add a small handle opposite the hinge."""
    if draw.chance(0.5):
        return
    place = at + side * [0.46 * size[0], 0.46 * size[1], 0] + [0, 0, thickness / 2]
    pieces = [cylinder(0.012, 0.04, "z", place + [0, 0, 0.02], 10), box((0.02, 0.1, 0.015), place + [0, -0.04, 0.04])]
    if draw.chance(0.6):
        long = min(draw.between(0.06, 0.2), 0.5 * min(size))
        pieces = pull(draw, long, place, vertical=draw.chance(0.6), room=0.1 * min(size))
    if node.children:
        node.add("handle", *pieces)
    else:
        node.pieces.append(join(*pieces))
