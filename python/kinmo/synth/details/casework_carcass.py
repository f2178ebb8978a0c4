"""Carcasses of furniture, open to the front."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box_between
from kinmo.synth.synth_object import Node


@dataclass(frozen=True)
class Carcass:
    """Outer size of a carcass and thickness of its boards; it is centred at the origin."""

    width: float
    height: float
    depth: float
    board: float

    @property
    def front(self) -> float:
        """Position of the front along z."""
        return self.depth / 2


def add_boards(draw: Draw, frame: Node, size: Carcass) -> None:
    """Add the panels of a carcass. Boards meet at their edges, or run through each other; any but the sides may be missing.

    The back lies between the sides or behind them, and the sides stand between bottom and top or beside them.
    """
    x, y, z, board = size.width / 2, size.height / 2, size.depth / 2, size.board
    inside = x - draw.pick([board, 0.5 * board, 0.0], [4, 1, 1])
    thin = draw.pick([board, 0.3 * board, 0.0], [3, 3, 1])
    rear = -z + thin if (back_covers := draw.chance(0.3)) else -z
    stands = draw.chance(0.25)
    for side in (-1, 1):
        inner, outer = sorted((side * (x - board), side * x))
        tall = y - board if stands else y
        frame.add("vertical_side_panel", box_between((inner, -tall, rear), (outer, tall, z)))
    if draw.chance(0.85):
        wide = x if back_covers else inside
        frame.add("back_panel", box_between((-wide, -y, -z), (wide, y, -z + thin)))
    near = z - draw.pick([0.0, draw.between(0.0, 0.1) * size.depth], [3, 1])
    wide = x if stands else inside
    if stands or draw.chance(0.92):
        frame.add("bottom_panel", box_between((-wide, -y, -z + thin), (wide, -y + board, near)))
    if stands or draw.chance(0.9):
        frame.add("top_panel", box_between((-wide, y - board, -z + thin), (wide, y, near)))
