"""Cabinets, chests of drawers, wardrobes and sideboards."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework import Fronts, Opening, add_door, add_door_pair, add_drawer, add_sliding_doors, legs
from kinmo.synth.details.casework_extras import (
    add_casters,
    add_false_front,
    add_leaning_drawer,
    add_lift_top,
    add_locked_door,
    add_pullout,
)
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box_between, cylinder
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject


@dataclass(frozen=True)
class _Carcass:
    """Outer size of a carcass and thickness of its boards; it is centred at the origin."""

    width: float
    height: float
    depth: float
    board: float

    @property
    def front(self) -> float:
        """Position of the front along z."""
        return self.depth / 2


def build(draw: Draw) -> SynthObject:
    """Carcass divided into openings with drawers, doors and shelves.

    Drawers and boards slide forward. Doors and flaps turn about an edge, or slide sideways. Casters swivel and roll, a lid
    folds up, and locks turn.
    """
    tall = draw.chance(0.35)
    width = draw.between(0.5, 1.0) if tall else draw.between(0.7, 1.8)
    height = draw.between(1.3, 2.0) if tall else draw.between(0.5, 1.1)
    size = _Carcass(width, height, draw.between(0.35, 0.9), draw.between(0.015, 0.05))
    root = Node("storage_furniture")
    cabinet = root.add("cabinet")
    frame = cabinet.add("cabinet_frame")
    base = Link("cabinet_frame", [frame], kind=draw.pick([JointType.HEAVY, JointType.STATIC, JointType.FREE], [6, 1, 1]))
    _add_frame(draw, frame, size)
    links = [base]
    x, y, z = size.width / 2, size.height / 2, size.depth / 2
    if draw.chance(0.07):
        lid = add_lift_top(draw, cabinet, base, (-x, y, -z), (x, y + size.board, z), draw.pick(["lid", "countertop"]))
        links.append(lid)
    elif draw.chance(0.4):
        base.nodes.append(cabinet.add("countertop", _top(draw, size)))
    if draw.chance(0.06):
        links += add_casters(draw, cabinet, base, 0.85 * x, 0.8 * z, -y)
    elif draw.chance(0.7):
        base.nodes.append(_add_base(draw, cabinet, size))
    links += _fill(draw, cabinet, frame, base, size)
    return SynthObject("StorageFurniture", root, links)


def _add_frame(draw: Draw, frame: Node, size: _Carcass) -> None:
    """Add side, bottom, top and back panels, and front bars of a face frame."""
    x, y, z, board = size.width / 2, size.height / 2, size.depth / 2, size.board
    for side in (-1, 1):
        inner, outer = sorted((side * (x - board), side * x))
        frame.add("vertical_side_panel", box_between((inner, -y, -z), (outer, y, z)))
    thin = draw.pick([board, 0.3 * board, 0.0], [3, 3, 1])
    frame.add("back_panel", box_between((-x + board, -y, -z), (x - board, y, -z + thin)))
    frame.add("bottom_panel", box_between((-x + board, -y, -z + thin), (x - board, -y + board, z)))
    frame.add("top_panel", box_between((-x + board, y - board, -z + thin), (x - board, y, z)))
    if draw.chance(0.3):
        for side in (-1, 1):
            inner, outer = sorted((side * (x - 1.8 * board), side * x))
            frame.add("frame_vertical_bar", box_between((inner, -y, z - board), (outer, y, z)))
            low, high = sorted((side * (y - 1.5 * board), side * y))
            frame.add("frame_horizontal_bar", box_between((-x + board, low, z - 0.9 * board), (x - board, high, z)))


def _top(draw: Draw, size: _Carcass) -> Mesh:
    """A countertop."""
    over, board = draw.between(0.0, 0.06), size.board * draw.between(0.8, 2.0)
    x, y, z = size.width / 2 + over, size.height / 2, size.depth / 2 + over
    return box_between((-x, y, -z + over), (x, y + board, z))


def _add_base(draw: Draw, cabinet: Node, size: _Carcass) -> Node:
    """Add feet, fixed wheels or a plinth below the carcass."""
    base = cabinet.add("cabinet_base")
    kind = draw.pick(["foot_base", "panel_base", "wheel_base"], [5, 4, 1])
    group = base.add("panel_base" if kind == "panel_base" else "foot_base")
    low, drop = -size.height / 2, draw.between(0.04, 0.25)
    x, z = size.width / 2, size.depth / 2
    if kind == "panel_base":
        board = size.board
        for side in (-1, 1):
            inner, outer = sorted((side * (x - board), side * x))
            group.add("base_side_panel", box_between((inner, low - drop, -z), (outer, low, z - 0.05)))
            near, far = sorted((side * (z - 0.05) - board, side * (z - 0.05)))
            group.add("base_side_panel", box_between((-x + board, low - drop, near), (x - board, low, far)))
    elif kind == "wheel_base":
        for sx in (-1, 1):
            for sz in (-1, 1):
                at = (sx * (x - 0.08), low - 0.04, sz * (z - 0.08))
                group.add("foot", cylinder(0.04, 0.03, "x", at, 16))
    else:
        thickness = draw.between(0.03, 0.08)
        for leg in legs(draw, x - thickness, z - thickness, low - drop, low, thickness):
            group.add("foot", leg)
    return base


def _fill(draw: Draw, cabinet: Node, frame: Node, base: Link, size: _Carcass) -> list[Link]:
    """Divide the front into columns, and every column into drawers, doors and open shelves."""
    links: list[Link] = []
    fronts = Fronts.random(draw, size.board)
    board, inner = size.board, size.width - 2 * size.board
    columns = draw.pick([1, 2, 3, 4], [4, 4, 2, 1]) if inner > 0.8 else draw.pick([1, 2], [4, 1])
    inner_depth = size.depth - 1.5 * board
    for column in range(columns):
        width = (inner - (columns - 1) * board) / columns
        x = -inner / 2 + width / 2 + column * (width + board)
        if column:
            left = x - width / 2 - board
            low = (left, -size.height / 2 + board, -size.depth / 2 + board)
            frame.add("vertical_divider_panel", box_between(low, (left + board, size.height / 2 - board, size.front)))
        rows = _rows(draw, size.height - 2 * board, board)
        top = size.height / 2 - board
        for share in rows:
            opening = Opening(x, top - share / 2, width, share, inner_depth, size.front)
            links += _furnish(draw, cabinet, base, opening, fronts, size)
            top -= share + board
            if share is not rows[-1]:
                shelf = box_between((x - width / 2, top, -size.depth / 2 + board), (x + width / 2, top + board, size.front))
                if draw.chance(0.5):
                    frame.add("shelf", shelf)
                else:
                    base.nodes.append(cabinet.add("shelf", shelf))
    if not links:
        opening = Opening(0, 0, inner, size.height - 2 * board, inner_depth, size.front)
        links.append(add_door(draw, cabinet, base, opening, fronts, draw.pick(["left", "right"])))
    return links


def _rows(draw: Draw, height: float, board: float) -> list[float]:
    """Heights of the openings of a column, from the top."""
    count = draw.pick([1, 2, 3, 4, 5], [3, 4, 3, 2, 1])
    shares = [draw.between(0.5, 1.5) for _ in range(count)] if draw.chance(0.5) else [1.0] * count
    room = height - (count - 1) * board
    return [room * share / sum(shares) for share in shares]


def _furnish(draw: Draw, cabinet: Node, base: Link, opening: Opening, fronts: Fronts, size: _Carcass) -> list[Link]:
    """Fill one opening with a drawer, doors, a board or nothing, depending on its proportions."""
    aspect = opening.height / opening.width
    rare = draw.between(0.0, 1.0)
    if rare < 0.03:
        add_false_front(draw, cabinet, base, opening, fronts)
        return []
    if rare < 0.05:
        return [add_pullout(draw, cabinet, base, opening)]
    if rare < 0.07 and aspect < 1.0:
        return [add_leaning_drawer(draw, cabinet, base, opening, fronts)]
    if rare < 0.11 and 0.6 < aspect < 3.0:
        return add_locked_door(draw, cabinet, base, opening, fronts, draw.pick(["left", "right"]))
    if aspect < 0.75 and draw.chance(0.7):
        return [add_drawer(draw, cabinet, base, opening, fronts)]
    if aspect > 2.8 and draw.chance(0.3):
        return []
    kind = draw.pick(
        ["door", "pair", "flap", "slide", "open"], [5, 3 if aspect < 1.6 else 0.5, 1.2 if aspect < 1 else 0.1, 0.6, 1.5]
    )
    if kind == "door" and aspect < 0.55:
        kind = "flap"
    if kind == "door":
        return [add_door(draw, cabinet, base, opening, fronts, draw.pick(["left", "right"]))]
    if kind == "pair":
        half = opening.width / 2 + 0.5 * max(fronts.gap, 0.0) * draw.pick([0.0, 1.0])
        width = half if fronts.gap >= 0 else opening.width / 2 + fronts.gap
        return add_door_pair(draw, cabinet, base, opening, fronts, width)
    if kind == "flap":
        return [add_door(draw, cabinet, base, opening, fronts, draw.pick(["top", "bottom"]))]
    if kind == "slide":
        return add_sliding_doors(draw, cabinet, base, opening, 0.8 * size.board)
    return []
