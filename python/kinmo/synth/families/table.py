"""Tables and desks with drawers, doors, pull-out boards and moving tops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.casework import add_door, add_door_pair, add_drawer
from kinmo.synth.details.casework_doors import add_folding_door, add_parts_behind, add_sliding_doors
from kinmo.synth.details.casework_extras import add_casters, add_false_front, add_pullout
from kinmo.synth.details.casework_filling import bordered
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.details.posture import turn_about_up
from kinmo.synth.details.table_supports import add_apron, add_column, add_supports
from kinmo.synth.details.table_tops import add_desk_top, add_moving_top
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Y, box, box_between, cylinder, extrude, open_box, rotation_about, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge

TURNED_SHARE = 0.1
"""Share of tables that are turned about the vertical by any quarter."""


@dataclass(frozen=True)
class _Size:
    """Half extents of the base along x and z, its height `y` above the floor y = 0, and the thickness of boards."""

    x: float
    y: float
    z: float
    board: float


def build(draw: Draw) -> SynthObject:
    """Table or desk.

    Variants: a row of drawers under the top, a stand of drawers, a desk with pedestals, a hutch or a roll top, and a table
    whose top lifts, folds, turns, tilts, extends or rises. Drop leaves and doors turn. Drawers and trays slide forward,
    to the rear or to the ends. Some tables have no joint at all: legs, aprons, shelves, false fronts.
    """
    kind = draw.pick(["apron", "stand", "pedestal", "cabinet", "open", "still"], [5.5, 3, 4, 1, 1.2, 1.3])
    width = draw.ratio(0.9, 2.4) if kind == "pedestal" else draw.ratio(0.4, 2.0)
    size = _Size(width / 2, draw.ratio(0.35, 1.4), draw.ratio(0.2, 0.7), draw.ratio(0.015, 0.08))
    root = Node("table")
    inner = root.add(draw.pick(["regular_table", "desk"]))
    base = Link("board", [], kind=draw.pick([JointType.HEAVY, JointType.STATIC], [9, 1]), leaf_name="base_body")
    links = [base]
    if kind == "open":
        add_moving_top(draw, inner, base, links, (size.x, size.y, size.z), size.board)
    else:
        _add_top(draw, inner, base, links, size, may_drop=kind != "still")
    parent = inner.add("table_base") if draw.chance(0.5) else inner
    drawers = parent.add("drawer_base")
    furnish = {"apron": _apron, "stand": _stand, "pedestal": _pedestal, "cabinet": _stand, "open": _frame, "still": _still}
    furnish[kind](draw, drawers, links, size)
    owned = {node for link in links for top in link.nodes for node in top.walk()}
    base.nodes += [node for child in drawers.children for node in _free(child, owned)]
    if len(links) == 1 and kind != "still" and draw.chance(0.5):  # only false fronts and open spaces: the table rolls
        links += add_casters(draw, inner, base, 0.9 * size.x, 0.9 * size.z, 0.0, always_moves=True)
    if kind not in ("open", "still") and size.x > 0.4 and draw.chance(0.15):
        add_desk_top(draw, inner, base, links, (size.x, size.y + 2 * size.board, size.z), size.board)
    shape = SynthObject("Table", root, links)
    if draw.chance(TURNED_SHARE):
        turn_about_up(draw, shape)
    return shape


def _add_top(draw: Draw, inner: Node, base: Link, links: list[Link], size: _Size, *, may_drop: bool) -> None:
    """Add the board or planks, sometimes with a frame around it or a drop leaf at each end."""
    over, thickness = draw.pick([draw.between(0.0, 0.12), draw.between(0.12, 0.3)], [4, 1]), 2 * size.board
    thickness *= draw.ratio(0.3, 1.0)
    width, depth = 2 * (size.x + over), 2 * (size.z + draw.between(0.0, 0.08))
    top = inner.add("tabletop")
    at = (0, size.y + thickness / 2, 0)
    look = draw.pick(["box", "rounded", "oval", "planks"], [6, 2, 1, 0.7])
    boards: list[Mesh] = []
    if look == "box":
        boards = [box((width, thickness, depth), at)]
    elif look == "planks":
        count = draw.integer(3, 8)
        pitch, share = depth / count, draw.pick([1.0, draw.between(0.85, 0.98)])
        places = (np.arange(count) + 0.5) * pitch - 0.5 * depth
        boards = [box((width, thickness, share * pitch), (0, at[1], place)) for place in places]
    elif look == "rounded":
        boards = [rounded_box((width, thickness, depth), draw.between(0.02, 0.3), "y", at)]
    else:
        around = np.linspace(0, 2 * np.pi, 32, endpoint=False)
        outline = np.stack([0.55 * depth * np.cos(around), 0.55 * width * np.sin(around)], axis=1)
        boards = [extrude(outline, thickness, "y", at)]
    surface = top.add("tabletop_surface")
    base.nodes.append(surface.add("board", *boards))
    if draw.chance(0.2):
        frame = top.add("tabletop_frame")
        base.nodes.append(frame)
        for side in (-1, 1):
            frame.add("bar", box((width, thickness, 0.03), (0, at[1], side * (depth / 2 + 0.015))))
            frame.add("bar", box((0.03, thickness, depth), (side * (width / 2 + 0.015), at[1], 0)))
    elif may_drop and look == "box" and draw.chance(0.08):
        leaves, reach = top.add("tabletop_dropleaf"), draw.between(0.2, 0.4)
        for out in (-1.0, 1.0):
            x = out * width / 2
            leaf = leaves.add(
                "board", box((thickness, reach, depth), (x + out * thickness / 2, size.y + thickness - reach / 2, 0))
            )
            axis = (x + out * 0.3 * thickness, size.y + 0.8 * thickness, 0)
            links.append(Link("board", [leaf], base, hinge(axis, (0, 0, out), 0, 90), leaf_name="rotation_board"))


def _shell(
    draw: Draw, node: Node, low: tuple[float, float], high: tuple[float, float], size: _Size, *, has_back: bool = True
) -> None:
    """Add side and back panels around a block of drawers between two corners (x, y), sometimes with a bottom, or a shell."""
    if has_back and draw.chance(0.12):
        node.add("frame", open_box((low[0], low[1], -size.z), (high[0], high[1], size.z), 0.6 * size.board))
        return
    board, z = size.board, size.z - draw.pick([0.0, 0.02])
    for x in (low[0], high[0] - board):
        node.add("vertical_side_panel", box_between((x, low[1], -z), (x + board, high[1], z)))
    thin = draw.pick([board, 0.3 * board])
    if has_back:
        node.add("back_panel", box_between((low[0] + board, low[1], -z), (high[0] - board, high[1], -z + thin)))
    if draw.chance(0.6):
        node.add("bottom_panel", box_between((low[0] + board, low[1], -z + thin), (high[0] - board, low[1] + 0.6 * board, z)))


def _row(
    draw: Draw,
    node: Node,
    links: list[Link],
    low: tuple[float, float],
    high: tuple[float, float],
    size: _Size,
    columns: int,
    facings: tuple[float, ...] = (1.0,),
) -> None:
    """Add drawers side by side between two corners (x, y), with dividers. `facings` are 1 (front) or -1 (rear), in turn."""
    fronts = Fronts.random(draw, size.board)
    board = size.board
    width = (high[0] - low[0] - (columns - 1) * board) / columns
    for column in range(columns):
        left = low[0] + column * (width + board)
        opening = Opening(left + width / 2, (low[1] + high[1]) / 2, width, high[1] - low[1], 2 * size.z - 2 * board, size.z)
        opening = bordered(opening, board, board, column == 0, column == columns - 1, False, False)
        kind = draw.pick(["drawer", "false", "tray"], [90, 5, 6])
        if kind == "false":
            add_false_front(draw, node, links[0], opening, fronts)
        elif kind == "tray":
            links.append(add_pullout(draw, node, links[0], opening))
        else:
            links.append(add_drawer(draw, node, links[0], opening, fronts))
            if facings[column % len(facings)] < 0:
                links[-1].move(rotation_about(Y, 180.0, (opening.x, 0, 0)))
        if column:
            divider = box_between((left - board, low[1], -size.z + board), (left, high[1], size.z - board))
            node.add("vertical_divider_panel", divider)


def _connectors(draw: Draw, node: Node, size: _Size) -> None:
    """Add battens under the top."""
    for side in (-1, 1):
        if draw.chance(0.3):
            at = (side * (size.x - size.board / 2), size.y - size.board, 0)
            node.add("tabletop_connector", box((size.board, size.board, 1.6 * size.z), at))


def _frame(draw: Draw, node: Node, links: list[Link], size: _Size) -> None:
    """Legs and rails below a moving top, sometimes with a pull-out board or casters."""
    thickness = draw.between(1.2, 2.6) * size.board + 0.02
    add_supports(draw, node, size.x, size.z, size.y, thickness)
    rail = draw.between(0.03, 0.15) * size.y
    half = size.x - thickness
    for side in (-1, 1):
        node.add("bar", box((2 * half, rail, size.board), (0, size.y - rail / 2, side * (size.z - thickness / 2))))
    if draw.chance(0.25):
        opening = Opening(0, size.y - rail - 0.04, 2 * half, 0.08, 1.8 * size.z, size.z)
        links.append(add_pullout(draw, node, links[0], opening))
    if draw.chance(0.25):
        links += add_casters(draw, node, links[0], size.x - thickness / 2, size.z - thickness / 2, 0.0)


def _apron(draw: Draw, node: Node, links: list[Link], size: _Size) -> None:
    """Legs with one row of drawers between them under the top."""
    height = draw.ratio(0.05, 0.45) * min(1.0, size.y)
    low = size.y - height
    facings = draw.pick([(1.0,), (-1.0,), (1.0, -1.0)], [10, 1, 1])
    at_ends = draw.chance(0.12)
    thickness = draw.between(1.2, 2.6) * size.board + 0.02
    add_supports(draw, node, size.x, size.z, size.y, thickness)
    if at_ends:
        _end_drawers(draw, node, links, size, low)
        return
    inset = draw.pick([0.0, thickness])
    _shell(draw, node, (-size.x + inset, low), (size.x - inset, size.y), size, has_back=facings == (1.0,))
    _connectors(draw, node, size)
    edge = size.x - inset - size.board
    if draw.chance(0.2):
        front = box_between((-edge, low, size.z - size.board), (edge, low + 0.2 * height, size.z))
        node.add("vertical_front_panel", front)
        low += 0.2 * height
    if draw.chance(0.2):
        # Fixed boards beside the drawers.
        aside = draw.between(0.1, 0.3) * 2 * edge
        for side in (-1, 1):
            near, far = sorted((side * (edge - aside), side * edge))
            node.add("vertical_front_panel", box_between((near, low, size.z - size.board), (far, size.y, size.z)))
        edge -= aside
    if draw.chance(0.12):
        _two_sided(draw, node, links, (-edge, low), (edge, size.y), size)
        return
    _row(draw, node, links, (-edge, low), (edge, size.y), size, draw.pick([1, 2, 3, 4], [7, 3, 2, 1]), facings)


def _two_sided(
    draw: Draw, node: Node, links: list[Link], low: tuple[float, float], high: tuple[float, float], size: _Size
) -> None:
    """Add drawers to the front and to the rear of a table, back to back, between two corners (x, y)."""
    half = _Size(size.x, size.y, 0.5 * size.z, size.board)
    for angle in (0.0, 180.0):
        own: list[Link] = [links[0]]
        group = node.add("drawer_base")
        _row(draw, group, own, low, high, half, draw.pick([1, 2], [3, 1]))
        place = rotation_about(Y, angle)
        place[:3, 3] = place[:3, :3] @ (0, 0, 0.5 * size.z)
        moving = Link("drawers", [group])
        moving.move(place)
        for link in own[1:]:
            assert link.motion is not None
            link.motion = link.motion.moved_by(place)
        links += own[1:]


def _end_drawers(draw: Draw, node: Node, links: list[Link], size: _Size, low: float) -> None:
    """Add an apron with a drawer at one end or both ends, which slide sideways."""
    board = size.board
    for side in (-1, 1):
        near, far = sorted((side * (size.z - board), side * size.z))
        node.add("vertical_front_panel", box_between((-size.x, low, near), (size.x, size.y, far)))
    fronts = Fronts.random(draw, board)
    opening = Opening(0, 0.5 * (low + size.y), 2 * (size.z - board), size.y - low, size.x - board, size.x)
    for angle in draw.pick([(90.0,), (-90.0,), (90.0, -90.0)], [1, 1, 2]):
        drawer = add_drawer(draw, node, links[0], opening, fronts)
        drawer.move(rotation_about(Y, angle))
        links.append(drawer)
    if draw.chance(0.5):
        node.add("vertical_divider_panel", box((0.5 * board, size.y - low, 2 * (size.z - board)), (0, 0.5 * (low + size.y), 0)))


def _stand(draw: Draw, node: Node, links: list[Link], size: _Size) -> None:
    """A body with drawers one above the other, a shelf space, or doors below a drawer."""
    low = draw.pick([0.0, draw.between(0.05, 0.5) * size.y], [1, 2])
    _shell(draw, node, (-size.x, low), (size.x, size.y), size)
    if low > 0:
        add_supports(draw, node, size.x, size.z, low, draw.between(0.03, 0.1))
    edge, board = size.x - size.board, size.board
    count = draw.pick([1, 2, 3, 4], [4, 4, 2, 1])
    height = (size.y - low - board) / count
    for row in range(count):
        top = size.y - row * height
        if row and draw.chance(0.25):
            opening = Opening(0, (top + low) / 2, 2 * edge, top - low - board, 2 * (size.z - board), size.z)
            _doors(draw, node, links, opening, Fronts.random(draw, board))
            break
        _row(draw, node, links, (-edge, top - height + board), (edge, top), size, draw.pick([1, 2], [5, 1]))
        shelf = box_between((-edge, top - height, -size.z + board), (edge, top - height + 0.7 * board, size.z - 0.01))
        node.add("shelf", shelf)
        if draw.chance(0.4):
            break


def _pedestal(draw: Draw, node: Node, links: list[Link], size: _Size) -> None:
    """A desk with drawers or a door at one or both ends, and sometimes a drawer between them."""
    low = draw.pick([0.0, draw.between(0.02, 0.15)])
    width = draw.between(0.15, 0.36) * 2 * size.x
    sides: list[float] = draw.pick([[-1.0], [1.0], [-1.0, 1.0]], [2, 2, 3])
    for side in (-1.0, 1.0):
        outer, inner = side * size.x, side * (size.x - width)
        if side not in sides:
            left = min(outer, outer - side * size.board)
            panel = box_between((left, 0, -size.z), (left + size.board, size.y, size.z))
            node.add("vertical_side_panel", panel)
            continue
        left, right = min(outer, inner), max(outer, inner)
        _shell(draw, node, (left, low), (right, size.y), size)
        _column(draw, node, links, left + size.board, right - size.board, low, size)
        if low:
            for x in (left + size.board / 2, right - size.board / 2):
                for z in (-0.8, 0.8):
                    node.add("foot", cylinder(min(0.025, size.board), low, "y", (x, low / 2, z * size.z), 12))
    free_left = -size.x + (width if -1.0 in sides else size.board)
    free_right = size.x - (width if 1.0 in sides else size.board)
    between = draw.pick(["none", "drawer", "tray"], [4, 4, 2])
    under = draw.between(0.08, 0.2) * size.y
    if between == "drawer":
        _row(draw, node, links, (free_left, size.y - under), (free_right, size.y), size, 1)
    elif between == "tray":
        opening = Opening((free_left + free_right) / 2, size.y - 0.6 * under, free_right - free_left, under, 2 * size.z, size.z)
        links.append(add_pullout(draw, node, links[0], opening))
    if draw.chance(0.6):
        back = box_between((free_left, 0.4 * size.y, -size.z), (free_right, size.y, -size.z + size.board))
        node.add("back_panel", back)


def _still(draw: Draw, node: Node, links: list[Link], size: _Size) -> None:
    """Supports without drawers, with an apron, an open shelf space or false fronts; nothing moves."""
    thickness = draw.between(1.2, 2.6) * size.board + 0.02
    if draw.chance(0.2):
        add_column(draw, node, size.x, size.z, size.y, thickness)
        return
    add_supports(draw, node, size.x, size.z, size.y, thickness)
    low = size.y - draw.ratio(0.05, 0.35) * size.y
    form = draw.pick(["apron", "false", "space", "none"], [4, 2, 2, 2])
    edge = size.x - 0.5 * thickness
    if form == "none":
        return
    if form == "space":
        _shell(draw, node, (-edge, low), (edge, size.y), size)
        node.add("shelf", box_between((-edge, low, -size.z + size.board), (edge, low + 0.5 * size.board, size.z)))
        return
    add_apron(draw, node, edge, size.z - 0.2 * thickness, low, size.y, 0.6 * size.board)
    if form == "false":
        fronts, count = Fronts.random(draw, size.board), draw.integer(1, 4)
        width = 2 * edge / count
        for index in range(count):
            x = -edge + (index + 0.5) * width
            opening = Opening(x, 0.5 * (low + size.y), 0.9 * width, 0.9 * (size.y - low), size.z, size.z)
            add_false_front(draw, node, links[0], opening, fronts)


def _column(draw: Draw, node: Node, links: list[Link], left: float, right: float, low: float, size: _Size) -> None:
    """Fill a pedestal with two to five drawers, or a door with or without drawers above it."""
    fronts, board = Fronts.random(draw, size.board), size.board
    depth = 2 * (size.z - board)
    count = draw.integer(1, 5)
    shares = np.array([draw.ratio(0.4, 1.6) for _ in range(count)]) if draw.chance(0.5) else np.ones(count)
    heights = (size.y - low - board) * shares / shares.sum()
    x, width = (left + right) / 2, right - left
    door_below = draw.chance(0.3)
    for row, height in enumerate(heights):
        top = size.y - float(heights[:row].sum())
        if door_below and row >= draw.integer(0, 1):
            border = (board, board, board, 0.0)
            opening = Opening(x, (top + low + board) / 2, width, top - low - board, depth, size.z, border)
            side = draw.pick(["left", "right", "bottom", "top"], [8, 8, 1, 1])
            links.append(add_door(draw, node, links[0], opening, fronts, side))
            if draw.chance(0.15):
                links += add_parts_behind(draw, node, links[0], opening, fronts)
            return
        if draw.chance(0.06):
            continue  # an open space
        tall = float(height) - draw.pick([0.0, 0.3 * board])
        opening = Opening(x, top - float(height) / 2, width, tall, depth, size.z, border=(board, board, 0.0, 0.0))
        links.append(add_drawer(draw, node, links[0], opening, fronts))


def _doors(draw: Draw, node: Node, links: list[Link], opening: Opening, fronts: Fronts) -> None:
    """Add one door or flap, two doors that meet in the middle, or doors that slide or fold."""
    kind = draw.pick(["door", "flap", "pair", "slide", "fold"], [5, 1, 5, 1, 0.5])
    if kind == "slide":
        links += add_sliding_doors(draw, node, links[0], opening, min(fronts.thickness, 0.2 * opening.depth))
    elif kind == "fold":
        links += add_folding_door(draw, node, links[0], opening, fronts)
    elif kind != "pair":
        sides = ["left", "right"] if kind == "door" else ["top", "bottom"]
        links.append(add_door(draw, node, links[0], opening, fronts, draw.pick(sides)))
    else:
        links += add_door_pair(draw, node, links[0], opening, fronts)


def _free(node: Node, owned: set[Node]) -> list[Node]:
    """The largest subtrees at or below a node whose nodes have no owner."""
    if not any(inner in owned for inner in node.walk()):
        return [node]
    return [] if node in owned else [free for child in node.children for free in _free(child, owned)]
