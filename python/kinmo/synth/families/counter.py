"""Counters with fronts on several sides: kitchen islands, sideboards, reception desks and workbenches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.core.vector import Vector
from kinmo.synth.details.casework import add_door, add_drawer, legs
from kinmo.synth.details.casework_extras import add_casters, add_trim
from kinmo.synth.details.casework_filling import OPEN_SHARE, bordered, furnish, on_side, shares
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder, facing
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject


def build(draw: Draw) -> SynthObject:
    """Counter with drawers and doors at two to four sides.

    Variants: an island with an overhanging top, a sideboard, a desk with a raised screen, and a bench with a vice or a rack.
    Drawers slide out of their own side, doors turn at it, and casters roll.
    """
    width, depth = draw.ratio(0.8, 2.6), draw.ratio(0.5, 1.2)
    height, board = draw.ratio(0.6, 1.1), draw.ratio(0.012, 0.04)
    root = Node("storage_furniture")
    base = Link("cabinet_frame", [], kind=draw.pick([JointType.STATIC, JointType.HEAVY, JointType.FREE]))
    fronts = Fronts.random(draw, board)
    # Parts of front and rear share the depth; those of the ends take a share of the width.
    sides = draw.pick([(Z, -Z), (Z, X), (Z, X, -X), (Z, -Z, X), (Z, -Z, X, -X), (X, -X)], [4, 3, 3, 1, 2, 2])
    end = {sign: draw.between(0.15, 0.35) * width if any(side @ X == sign for side in sides) else board for sign in (1.0, -1.0)}
    left, right = -width / 2 + end[-1.0], width / 2 - end[1.0]
    middle = draw.between(-0.2, 0.2) * depth if any(side @ Z < 0 for side in sides) else -depth / 2 + board
    links: list[Link] = []
    _add_body(draw, root, base, (width, height, depth), (left, right), middle, board)
    for side in sides:
        if abs(side @ Z) > 0.5:
            forward = side @ Z > 0
            room = right - left - 2 * board
            deep = (depth / 2 - middle if forward else depth / 2 + middle) - board
            at = Z * side[2] * depth / 2 + X * 0.5 * (left + right)
        else:
            room, deep = depth - 2 * board, end[float(side @ X)] - 2 * board
            at = side * width / 2
        face = Opening(0.0, height / 2, room, height - 2 * board, deep, 0.0)
        links += on_side(base, facing(side, Y, at), _Face(draw, root, face, fronts, board).build)
    low, high = np.array([-width / 2, 0.0, -depth / 2]), np.array([width / 2, height, depth / 2])
    if not any(side @ Z > 0 for side in sides) and draw.chance(0.8):
        closed = box_between((left, board, depth / 2 - board), (right, height - board, depth / 2))
        base.nodes.append(root.add("vertical_front_panel", closed))
    links += _add_stand(draw, root, base, low, high)
    _add_top(draw, root, base, low, high, board)
    return SynthObject("StorageFurniture", root, [base, *links])


class _Face:
    """One side with columns of fronts, in a frame with the outside towards +z."""

    def __init__(self, draw: Draw, root: Node, face: Opening, fronts: Fronts, board: float) -> None:
        self.draw, self.root, self.face, self.fronts, self.board = draw, root, face, fronts, board

    def build(self, base: Link) -> list[Link]:
        """Add rows and columns of fronts with boards between them."""
        draw, face, board = self.draw, self.face, self.board
        links: list[Link] = []
        columns = max(1, round(face.width / draw.between(0.45, 0.95)))
        edge = -face.width / 2
        for column, wide in enumerate(shares(draw, columns, face.width, board)):
            x = edge + wide / 2
            if column:
                self._board(base, (edge - board / 2, face.y), (board, face.height))
            top = face.high
            between = 0.0 if draw.chance(OPEN_SHARE) else board
            rows = shares(draw, draw.pick([1, 2, 3, 4], [5, 2, 1.5, 0.5]), face.height, between)
            for row, tall in enumerate(rows):
                cell = replace(face, x=x, y=top - tall / 2, width=wide, height=tall)
                cell = bordered(cell, board, between, column == 0, column == columns - 1, row == len(rows) - 1, row == 0)
                if row and between:
                    self._board(base, (x, top + board / 2), (wide, board))
                links += self._fill(base, cell)
                top -= tall + between
            edge += wide + board
        return links

    def _board(self, base: Link, at: tuple[float, float], size: tuple[float, float]) -> None:
        """Add a board of the carcass as deep as the side, centred at `at` on it."""
        deep = self.face.depth
        base.nodes.append(self.root.add("vertical_divider_panel", box((*size, deep), (*at, -deep / 2))))

    def _fill(self, base: Link, cell: Opening) -> list[Link]:
        """Close a cell with a drawer, a door, or any filling of furniture."""
        draw = self.draw
        kind = draw.pick(["drawer", "door", "any"], [5 if cell.height < cell.width else 1, 4, 3])
        if kind == "drawer":
            return [add_drawer(draw, self.root, base, cell, self.fronts)]
        if kind == "door":
            side = draw.pick(["left", "right", "bottom"], [3, 3, 1])
            return [add_door(draw, self.root, base, cell, self.fronts, side)]
        return furnish(draw, self.root, base, cell, self.fronts, self.board)


def _add_body(
    draw: Draw,
    root: Node,
    base: Link,
    size: tuple[float, float, float],
    inner: tuple[float, float],
    middle: float,
    board: float,
) -> None:
    """Add floor, ceiling, the walls between the cells of the sides, and corner posts."""
    (width, height, depth), (left, right) = size, inner
    x, z = width / 2, depth / 2
    frame = root.add("cabinet_frame")
    base.nodes.append(frame)
    frame.add("bottom_panel", box_between((-x, 0, -z), (x, board, z)))
    frame.add("top_panel", box_between((-x, height - board, -z), (x, height, z)))
    for low, high in ((left - board, left), (right, right + board)):
        frame.add("vertical_side_panel", box_between((low, board, -z), (high, height - board, z)))
    wall = draw.pick([board, 0.5 * board])
    frame.add("back_panel", box_between((left, board, middle - wall), (right, height - board, middle)))
    if draw.chance(0.3):
        for sx in (-1, 1):
            for sz in (-1, 1):
                at = (sx * (x - board / 2), height / 2, sz * (z - board / 2))
                frame.add("frame_vertical_bar", box((board, height, board), at))
    elif draw.chance(0.6):
        # Boards at front and rear of a row of drawers at an end.
        for sx in (-1, 1):
            for sz in (-1, 1):
                bar = np.array([sx * (x - board / 2), height / 2, sz * (z - board / 2)])
                frame.add("frame", box((board, height - 2 * board, board), bar))


def _add_stand(draw: Draw, root: Node, base: Link, low: Vector, high: Vector) -> list[Link]:
    """Add legs, casters, a plinth or trim below the body; returns the links of casters that move."""
    kind = draw.pick(["legs", "casters", "plinth", "trim", "none"], [2, 1, 3, 2, 2])
    x, z = high[0], high[2]
    if kind == "casters":
        return add_casters(draw, root, base, 0.88 * x, 0.82 * z, 0.0)
    if kind == "legs":
        thick = draw.ratio(0.03, 0.1)
        for leg in legs(draw, x - thick / 2, z - thick / 2, -draw.between(0.05, 0.35), 0.0, thick):
            base.nodes.append(root.add("foot", leg))
    elif kind == "plinth":
        inset = draw.between(0.01, 0.08)
        base.nodes.append(root.add("plinth", box_between((inset - x, -0.1, inset - z), (x - inset, 0.0, z - inset))))
    elif kind == "trim":
        add_trim(draw, root, base, low, high)
    return []


def _add_top(draw: Draw, root: Node, base: Link, low: Vector, high: Vector, board: float) -> None:
    """Add a worktop, and what stands on it: a screen in front, a rack at the rear, a bar with stools' overhang, a sink."""
    over = np.array([draw.pick([0.0, draw.between(0.0, 0.25)]), 0.0, draw.pick([0.0, draw.between(0.0, 0.3)])])
    thick = board * draw.between(0.8, 3.0)
    top = high[1] + thick
    plate = box_between((low[0] - over[0], high[1], low[2] - over[2]), (high[0] + over[0], top, high[2]))
    base.nodes.append(root.add("countertop", plate))
    kind = draw.pick(["plain", "screen", "rack", "sink", "bar"], [4, 2, 2, 1, 1])
    x, deep = high[0], high[2] - low[2]
    if kind == "screen":
        tall = draw.between(0.15, 0.5)
        base.nodes.append(root.add("panel", box_between((-x, top, low[2]), (x, top + tall, low[2] + board))))
        if draw.chance(0.6):
            shelf = box_between((-x, top + tall, low[2] - 0.05), (x, top + tall + board, low[2] + 0.3 * deep))
            base.nodes.append(root.add("shelf", shelf))
    elif kind == "rack":
        tall = draw.between(0.3, 0.9)
        bars = [box_between((s * x - board, top, low[2]), (s * x + board, top + tall, low[2] + 2 * board)) for s in (-0.9, 0.9)]
        bars += [box((1.8 * x, 4 * board, board), (0, top + share * tall, low[2] + board)) for share in (0.5, 0.95)]
        base.nodes.append(root.add("rack", *bars))
        for place in np.linspace(-0.7, 0.7, draw.integer(0, 5)) * x:
            hook = cylinder(0.4 * board, 4 * board, "z", (place, top + 0.5 * tall, low[2] + 3 * board), 8)
            base.nodes.append(root.add("other_leaf", hook))
    elif kind == "sink":
        base.nodes.append(root.add("sink", box((0.5 * x, 0.01, 0.5 * deep), (draw.between(-0.4, 0.4) * x, top + 0.005, 0))))
    elif kind == "bar":
        for s in (-1, 1):
            post = cylinder(0.03, 0.2, "y", (s * 0.8 * x, top + 0.1, low[2] + 0.1), 12)
            base.nodes.append(root.add("leg", post))
        base.nodes.append(root.add("shelf", box((2 * x, 0.03, 0.3), (0, top + 0.215, low[2] + 0.05))))
