"""Cabinets, chests of drawers, wardrobes and sideboards."""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework import add_door, legs
from kinmo.synth.details.casework_carcass import Carcass, add_boards
from kinmo.synth.details.casework_extras import add_casters, add_lift_top, add_trim
from kinmo.synth.details.casework_filling import OPEN_SHARE, bordered, furnish, shares
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.details.posture import turn_about_up
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box_between, cylinder, open_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject

TURNED_SHARE = 0.06
"""Share of carcasses that are turned about the vertical by any quarter."""
TRIMMED_SHARE = 0.2
"""Share of carcasses with fixed trim: skirting, cornices, pilasters and so on."""
SHELL_SHARE = 0.15
"""Share of carcasses that are one hollow surface instead of boards."""


def build(draw: Draw) -> SynthObject:
    """Carcass divided into openings with drawers, doors and shelves.

    Drawers and boards slide forward. Doors and flaps turn about an edge, slide, hang on a rail or fold, with other parts behind
    some. Casters swivel and roll, a lid folds up, and locks turn.
    """
    tall = draw.chance(0.35)
    width = draw.ratio(0.3, 1.2) if tall else draw.ratio(0.5, 2.4)
    height = draw.ratio(1.0, 2.2) if tall else draw.ratio(0.3, 1.2)
    size = Carcass(width, height, draw.ratio(0.2, 1.0), draw.ratio(0.01, 0.06))
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
    if draw.chance(TRIMMED_SHARE):
        add_trim(draw, cabinet, base, (-x, -y, -z), (x, y, z))
    shape = SynthObject("StorageFurniture", root, links)
    if draw.chance(TURNED_SHARE):
        turn_about_up(draw, shape)
    return shape


def _add_frame(draw: Draw, frame: Node, size: Carcass) -> None:
    """Add side, bottom, top and back panels, and front bars of a face frame."""
    x, y, z, board = size.width / 2, size.height / 2, size.depth / 2, size.board
    if draw.chance(SHELL_SHARE):
        frame.add(draw.pick(["frame", "cabinet_frame"]), open_box((-x, -y, -z), (x, y, z), board))
    else:
        add_boards(draw, frame, size)
    if draw.chance(0.3):
        for side in (-1, 1):
            inner, outer = sorted((side * (x - 1.8 * board), side * x))
            frame.add("frame_vertical_bar", box_between((inner, -y, z - board), (outer, y, z)))
            low, high = sorted((side * (y - 1.5 * board), side * y))
            frame.add("frame_horizontal_bar", box_between((-x + board, low, z - 0.9 * board), (x - board, high, z)))


def _top(draw: Draw, size: Carcass) -> Mesh:
    """A countertop."""
    over, board = draw.pick([0.0, draw.between(0.0, 0.12)]), size.board * draw.between(0.8, 2.0)
    x, y, z = size.width / 2 + over, size.height / 2, size.depth / 2 + over
    return box_between((-x, y, -z + over), (x, y + board, z))


def _add_base(draw: Draw, cabinet: Node, size: Carcass) -> Node:
    """Add feet, fixed wheels or a plinth below the carcass."""
    base = cabinet.add("cabinet_base")
    kind = draw.pick(["foot_base", "panel_base", "wheel_base"], [5, 4, 1])
    group = base.add("panel_base" if kind == "panel_base" else "foot_base")
    low, drop = -size.height / 2, draw.ratio(0.03, 0.5)
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
        thickness = draw.ratio(0.02, 0.12)
        for leg in legs(draw, x - thickness, z - thickness, low - drop, low, thickness):
            group.add("foot", leg)
    return base


def _fill(draw: Draw, cabinet: Node, frame: Node, base: Link, size: Carcass) -> list[Link]:
    """Divide the front into columns, and every column into drawers, doors and open shelves."""
    links: list[Link] = []
    fronts = Fronts.random(draw, size.board)
    board, inner = size.board, size.width - 2 * size.board
    columns = draw.pick([1, 2, 3, 4], [4, 4, 2, 1]) if inner > 0.8 else draw.pick([1, 2], [4, 1])
    inner_depth = size.depth - 1.5 * board
    edge = -inner / 2
    for column, width in enumerate(shares(draw, columns, inner, board)):
        x, left = edge + width / 2, edge - board
        edge += width + board
        if left > -inner / 2:
            low = (left, -size.height / 2 + board, -size.depth / 2 + board)
            frame.add("vertical_divider_panel", box_between(low, (left + board, size.height / 2 - board, size.front)))
        between = 0.0 if draw.chance(OPEN_SHARE) else board
        rows = shares(draw, draw.pick([1, 2, 3, 4, 5, 8], [3, 4, 3, 2, 1, 0.4]), size.height - 2 * board, between)
        top = size.height / 2 - board
        for row, share in enumerate(rows):
            opening = Opening(x, top - share / 2, width, share, inner_depth, size.front)
            opening = bordered(opening, board, between, column == 0, column == columns - 1, row == len(rows) - 1, row == 0)
            links += furnish(draw, cabinet, base, opening, fronts, size.board)
            top -= share + between
            if between and row < len(rows) - 1:
                shelf = box_between((x - width / 2, top, -size.depth / 2 + board), (x + width / 2, top + board, size.front))
                if draw.chance(0.5):
                    frame.add("shelf", shelf)
                else:
                    base.nodes.append(cabinet.add("shelf", shelf))
    if not links:
        opening = Opening(0, 0, inner, size.height - 2 * board, inner_depth, size.front)
        links.append(add_door(draw, cabinet, base, opening, fronts, draw.pick(["left", "right"])))
    return links
