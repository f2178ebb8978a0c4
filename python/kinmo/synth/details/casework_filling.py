"""Fillings of furniture: openings of a front are divided, and filled with drawers, doors and other parts, on any side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.synth.details.casework import add_door, add_door_pair, add_drawer
from kinmo.synth.details.casework_doors import (
    add_folding_door,
    add_hung_door,
    add_parts_behind,
    add_shutter,
    add_sliding_doors,
    add_tipping_bin,
)
from kinmo.synth.details.casework_extras import (
    add_false_front,
    add_larder,
    add_leaning_drawer,
    add_locked_door,
    add_pullout,
)
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Link, Node

TIPPING_SHARE = 0.15
"""Share of flaps that are the front of a bin."""
BEHIND_SHARE = 0.12
"""Share of doors and flaps with drawers or another door behind them."""
OPEN_SHARE = 0.35
"""Share of columns of fronts without boards between their rows."""


def on_side(carcass: Link, place: NDArray[np.float64], build: Callable[[Link], list[Link]]) -> list[Link]:
    """Build parts for a front that faces +z and bring them to another side of a carcass.

    Args:
        carcass: Link that carries the parts.
        place: Rigid transform [4, 4] from the frame of the front to the side.
        build: Function that adds parts to the link that it is given, and returns their links.

    Returns:
        The links of the parts.
    """
    side = Link("side", [])
    links = build(side)
    for link in (side, *links):
        link.move(place)
        link.parent = carcass if link.parent is side else link.parent
    carcass.nodes += side.nodes
    return links


def shares(draw: Draw, count: int, room: float, board: float) -> list[float]:
    """Sizes of openings beside or below each other, with boards between them: equal, or of very different proportions."""
    shares = [draw.ratio(0.35, 2.2) for _ in range(count)] if draw.chance(0.5) else [1.0] * count
    free = room - (count - 1) * board
    return [free * share / sum(shares) for share in shares]


def bordered(
    opening: Opening, board: float, between: float, is_left: bool, is_right: bool, is_lowest: bool, is_highest: bool
) -> Opening:
    """An opening of a grid with the border that its front may cover: boards at the outside, and half of those inside.

    Args:
        opening: The opening.
        board: Thickness of outer and upright boards.
        between: Thickness of the boards between the rows.
        is_left: Nothing is to the left of it.
        is_right: Nothing is to the right of it.
        is_lowest: Nothing is below it.
        is_highest: Nothing is above it.
    """
    left, right = (board if is_outside else 0.5 * board for is_outside in (is_left, is_right))
    below, above = (board if is_outside else 0.5 * between for is_outside in (is_lowest, is_highest))
    return replace(opening, border=(left, right, below, above))


def furnish(draw: Draw, above: Node, carcass: Link, opening: Opening, fronts: Fronts, board: float) -> list[Link]:
    """Fill an opening with a drawer, doors, a board or nothing, by its proportions. `board` is the thickness of boards."""
    aspect = opening.height / opening.width
    rare = draw.between(0.0, 1.0)
    if rare < 0.05:
        add_false_front(draw, above, carcass, opening, fronts)
        return []
    if rare < 0.075:
        return [add_pullout(draw, above, carcass, opening)]
    if rare < 0.095 and aspect < 1.0:
        return [add_leaning_drawer(draw, above, carcass, opening, fronts)]
    if rare < 0.115 and aspect > 1.6:
        return [add_larder(draw, above, carcass, opening, fronts)]
    if rare < 0.13 and 0.6 < aspect < 3.0:
        return add_locked_door(draw, above, carcass, opening, fronts, draw.pick(["left", "right"]))
    if aspect < 0.75 and draw.chance(0.7):
        return [add_drawer(draw, above, carcass, opening, fronts)]
    if aspect > 2.8 and draw.chance(0.3):
        return []
    kind = draw.pick(
        ["door", "pair", "flap", "slide", "shutter", "fold", "hung", "open"],
        [5, 4 if aspect < 1.6 else 1.0, 1.6 if aspect < 1.2 else 0.2, 1.1, 0.25, 0.4, 0.3, 1.5],
    )
    if kind == "door" and aspect < 0.55 and draw.chance(0.8):
        kind = "flap"
    if kind in ("door", "flap"):
        sides = ["left", "right"] if kind == "door" else ["top", "bottom"]
        if kind == "flap" and draw.chance(TIPPING_SHARE):
            return [add_tipping_bin(draw, above, carcass, opening, fronts)]
        links = [add_door(draw, above, carcass, opening, fronts, draw.pick(sides))]
        if draw.chance(BEHIND_SHARE):
            links += add_parts_behind(draw, above, carcass, opening, fronts)
        return links
    if kind == "pair":
        half = opening.width / 2 + 0.5 * max(fronts.gap, 0.0) * draw.pick([0.0, 1.0])
        return add_door_pair(draw, above, carcass, opening, fronts, half)
    if kind == "fold":
        return add_folding_door(draw, above, carcass, opening, fronts)
    if kind == "hung":
        return [add_hung_door(draw, above, carcass, opening, fronts)]
    if kind == "shutter":
        return [add_shutter(draw, above, carcass, opening, 0.8 * board)]
    if kind == "slide":
        return add_sliding_doors(draw, above, carcass, opening, 0.8 * board)
    return []
