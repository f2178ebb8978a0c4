"""Chests of drawers, cupboards and wardrobes with plain fronts that are alike."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from kinmo.synth.details.casework import add_door, add_door_pair, add_drawer, legs
from kinmo.synth.details.casework_carcass import Carcass, add_boards
from kinmo.synth.details.casework_doors import add_sliding_doors
from kinmo.synth.details.casework_extras import add_inner_shelves
from kinmo.synth.details.casework_filling import OPEN_SHARE, bordered
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box_between
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject

SLIDING_SHARE = 0.15
"""Share of wide openings with doors that slide."""


def build(draw: Draw) -> SynthObject:
    """Carcass with equal fronts: rows of drawers, a door, two doors, or doors with a row of drawers above or below.

    Drawers slide forward. Doors turn about their outer edge, or all about the same side, and some wide ones slide sideways.
    """
    tall = draw.chance(0.35)
    width = draw.ratio(0.3, 1.6)
    height = draw.ratio(1.2, 2.3) if tall else draw.ratio(0.4, 1.2)
    size = Carcass(width, height, draw.ratio(0.25, 0.8), draw.ratio(0.01, 0.04))
    root = Node("storage_furniture")
    frame = root.add("cabinet_frame")
    base = Link("cabinet_frame", [frame], kind=draw.pick([JointType.HEAVY, JointType.STATIC, JointType.FREE], [6, 1, 1]))
    add_boards(draw, frame, size)
    _add_foot(draw, root, base, size)
    fronts = replace(Fronts.random(draw, size.board), look=draw.pick(["plain", "framed", "raised"], [6, 1, 1]), trim=None)
    links = [base]
    columns = draw.pick([1, 2, 3], [5, 2, 1] if width > 0.6 else [1, 0, 0])
    plan = draw.pick(["drawers", "doors", "mixed"], [4, 4, 2]) if not tall else draw.pick(["doors", "mixed"], [4, 1])
    edges = np.linspace(-width / 2 + size.board / 2, width / 2 - size.board / 2, columns + 1)
    for column, (left, right) in enumerate(pairwise(edges.tolist())):
        if column:
            low = (left - size.board / 2, -height / 2 + size.board, -size.depth / 2 + size.board)
            frame.add("vertical_divider_panel", box_between(low, (left + size.board / 2, height / 2 - size.board, size.front)))
        opening = Opening(
            0.5 * (left + right),
            0.0,
            right - left - size.board,
            height - 2 * size.board,
            size.depth - 1.5 * size.board,
            size.front,
        )
        cells = _Column(draw, root, base, size.board, fronts, column == 0, column == columns - 1)
        links += cells.fill(opening, plan)
    return SynthObject("StorageFurniture", root, links)


def _add_foot(draw: Draw, root: Node, base: Link, size: Carcass) -> None:
    """Add legs, a plinth or a top that is wider than the carcass, or nothing."""
    x, y, z = size.width / 2, size.height / 2, size.depth / 2
    kind = draw.pick(["none", "legs", "plinth"], [5, 3, 2])
    if kind == "legs":
        thick = draw.ratio(0.02, 0.08)
        for leg in legs(draw, x - thick, z - thick, -y - draw.ratio(0.04, 0.3), -y, thick):
            base.nodes.append(root.add("foot", leg))
    elif kind == "plinth":
        inset = draw.pick([0.0, draw.between(0.01, 0.08)])
        base.nodes.append(root.add("plinth", box_between((inset - x, -y - 0.08, inset - z), (x - inset, -y, z - inset))))
    if draw.chance(0.3):
        over = draw.pick([0.0, draw.between(0.0, 0.04)])
        top = box_between((-x - over, y, -z), (x + over, y + size.board, z + over))
        base.nodes.append(root.add("countertop", top))


class _Column:
    """A column of fronts between two upright boards."""

    def __init__(self, draw: Draw, root: Node, base: Link, board: float, fronts: Fronts, is_left: bool, is_right: bool) -> None:
        self.draw, self.root, self.base, self.board, self.fronts = draw, root, base, board, fronts
        self.is_left, self.is_right = is_left, is_right
        self.between = 0.0 if draw.chance(2 * OPEN_SHARE) else board

    def fill(self, opening: Opening, plan: str) -> list[Link]:
        """Add the fronts of a plan: "drawers", "doors" or "mixed"."""
        draw = self.draw
        if plan == "doors":
            rows = draw.pick([["door"], ["door"] * 2], [4, 1])
        elif plan == "mixed":
            drawers = ["drawer"] * draw.pick([1, 2, 3], [4, 2, 1])
            rows = draw.pick([[*drawers, "door"], ["door", *drawers]], [3, 1])
        else:
            rows = ["drawer"] * draw.pick([1, 2, 3, 4, 5, 6], [1, 3, 5, 4, 2, 1])
        weights = np.array([draw.between(2.0, 4.0) if kind == "door" and plan == "mixed" else 1.0 for kind in rows])
        heights = (opening.height - (len(rows) - 1) * self.between) * weights / weights.sum()
        links: list[Link] = []
        top, side = opening.high, draw.pick(["left", "right"])
        for row, (kind, tall) in enumerate(zip(rows, heights.tolist(), strict=True)):
            part = replace(opening, y=top - tall / 2, height=tall)
            is_lowest = row == len(rows) - 1
            part = bordered(part, self.board, self.between, self.is_left, self.is_right, is_lowest, row == 0)
            if row and self.between:
                low = (part.x - part.width / 2, top, part.front - part.depth)
                shelf = box_between(low, (part.x + part.width / 2, top + self.between, part.front))
                self.base.nodes.append(self.root.add("shelf", shelf))
            links += self._front(kind, part, side)
            top -= tall + self.between
        return links

    def _front(self, kind: str, part: Opening, side: str) -> list[Link]:
        draw, root, base, fronts = self.draw, self.root, self.base, self.fronts
        if kind == "drawer":
            return [add_drawer(draw, root, base, part, fronts)]
        if draw.chance(0.4):
            add_inner_shelves(draw, root, base, part, self.board, max(fronts.thickness, 0.1 * part.depth))
        if part.width > 0.6 and draw.chance(SLIDING_SHARE):
            return add_sliding_doors(draw, root, base, part, self.board, upwards=False)
        if part.width > 0.5 * part.height or draw.chance(0.3):
            return add_door_pair(draw, root, base, part, fronts)
        return [add_door(draw, root, base, part, fronts, side)]
