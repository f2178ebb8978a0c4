"""Moving table tops: halves that fold over, boards that lift, turn or tilt, leaves that slide out; hutches and roll tops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.synth.details.casework import add_door, add_drawer
from kinmo.synth.details.casework_doors import add_roll_top
from kinmo.synth.details.casework_extras import add_lift_top
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, cylinder
from kinmo.synth.synth_object import Link, Node, hinge, slider, spinner


def add_moving_top(
    draw: Draw, above: Node, base: Link, links: list[Link], size: tuple[float, float, float], board: float
) -> None:
    """Add a moving top to a table frame. Parts that do not move go to `base`.

    Args:
        above: Node that the top is added below.
        base: Link of the frame.
        links: List that the links of the moving parts are appended to.
        size: Half extent along x, height, and half extent along z of the frame.
        board: Usual thickness of boards.
    """
    x, y, z = size
    over, thick = draw.between(0.0, 0.1), draw.between(0.6, 2.0) * board
    x, z = x + over, z + over
    top = above.add("tabletop")
    kind = draw.pick(["lift", "halves", "turn", "tilt", "extend", "raise"], [4, 2, 2, 2, 3, 2])
    if kind == "lift":
        links.append(add_lift_top(draw, top, base, (-x, y, -z), (x, y + thick, z), "board"))
    elif kind == "halves":
        _halves(draw, top, base, links, (x, y, z), thick)
    elif kind == "turn":
        at = (0, y + thick / 2, 0)
        slab = cylinder(max(x, z), thick, "y", at, 36) if draw.chance(0.6) else box((2 * x, thick, 2 * z), at)
        motion = spinner((0, y, 0), Y) if draw.chance(0.7) else hinge((0, y, 0), Y, *draw.pick([(0.0, 90.0), (-180.0, 180.0)]))
        links.append(Link("board", [top.add("board", slab)], base, motion, leaf_name="rotation_board"))
    elif kind == "tilt":
        lean = draw.between(30.0, 80.0)
        plate = top.add("board", box((2 * x, thick, 2 * z), (0, y + thick / 2, 0)))
        middle = (0, y + draw.pick([0.0, 0.5 * thick]), draw.pick([0.0, draw.between(-0.3, 0.3) * z]))
        motion = hinge(middle, X, *draw.pick([(0.0, lean), (-lean, lean), (0.0, 90.0)]), rest=draw.pick([0.0, 0.4 * lean]))
        links.append(Link("board", [plate], base, motion, leaf_name="rotation_board"))
    elif kind == "raise":
        plate = top.add("board", box((2 * x, thick, 2 * z), (0, y + thick / 2, 0)))
        reach = draw.between(0.15, 0.5) * y
        posts = [box_between((s * 0.7 * x - 0.03, y - reach, -0.03), (s * 0.7 * x + 0.03, y, 0.03)) for s in (-1, 1)]
        pillar = top.add("vertical_support", *posts)
        motion = slider(Y, 0.0, reach, rest=reach * draw.pick([0.0, draw.between(0.2, 0.8)]))
        links.append(Link("board", [plate, pillar], base, motion, leaf_name="translation_board"))
    else:
        _extension(draw, top, base, links, (x, y, z), thick)


def add_desk_top(
    draw: Draw, above: Node, base: Link, links: list[Link], size: tuple[float, float, float], board: float
) -> None:
    """Add a hutch with doors or drawers on a table top, or a roll top over its rear.

    Args:
        above: Node that the parts are added below.
        base: Link of the table.
        links: List that the links of the moving parts are appended to.
        size: Half extent along x, height of the table's surface, and half extent along z.
        board: Usual thickness of boards.
    """
    x, y, z = size
    if draw.chance(0.35):
        links.append(add_roll_top(draw, above, base, 0.9 * x, y, -z, z * draw.between(0.7, 1.4)))
        return
    high, deep, columns = draw.ratio(0.15, 0.9), z * draw.between(0.4, 0.9), draw.integer(1, 4)
    group, front = above.add("shelf"), -z + deep
    edges = np.linspace(-x, x - board, columns + 1)
    walls = [group.add("vertical_side_panel", box_between((left, y, -z), (left + board, y + high, front))) for left in edges]
    walls.append(group.add("back_panel", box_between((-x, y, -z), (x, y + high, -z + 0.5 * board))))
    walls.append(group.add("top_panel", box_between((-x, y + high, -z), (x, y + high + board, front))))
    base.nodes += walls
    fronts = Fronts.random(draw, 0.6 * board)
    for left, right in zip(edges[:-1] + board, edges[1:], strict=True):
        border = (0.5 * board, 0.5 * board, 0.0, board)
        opening = Opening(0.5 * (left + right), y + 0.5 * high, right - left, high, deep - board, front, border)
        kind = draw.pick(["door", "flap", "drawers", "open"], [3, 1, 2, 2])
        if kind == "drawers":
            # Small drawers, one above the other, below an open space or not.
            count = draw.pick([1, 2, 3], [2, 2, 1])
            tall = high * draw.pick([1.0, draw.between(0.4, 0.8)]) / count
            for row in range(count):
                border = (0.5 * board, 0.5 * board, 0.03 * tall, 0.03 * tall)
                part = replace(opening, y=y + (row + 0.5) * tall, height=0.94 * tall, border=border)
                links.append(add_drawer(draw, group, base, part, fronts))
        elif kind != "open":
            sides = ["left", "right"] if kind == "door" else ["top", "bottom"]
            links.append(add_door(draw, group, base, opening, fronts, draw.pick(sides)))


def _halves(draw: Draw, top: Node, base: Link, links: list[Link], size: tuple[float, float, float], thick: float) -> None:
    """Add a fixed half, and a half that folds over onto it or hangs down."""
    x, y, z = size
    base.nodes.append(top.add("board", box_between((-x, y, -z), (0, y + thick, z))))
    leaf = top.add("board", box_between((0, y, -z), (x, y + thick, z)))
    opens = draw.pick([90.0, 180.0])
    rest = draw.pick([0.0, opens, draw.between(20.0, 80.0)], [3, 1, 1])
    if draw.chance(0.4):
        # The leaf hangs down instead of folding over.
        motion = hinge((0, y + draw.pick([0.0, thick]), 0), -Z, 0.0, 90.0, rest=min(rest, 90.0))
    else:
        motion = hinge((0, y + thick, 0), Z, 0.0, opens, rest=rest)
    links.append(Link("board", [leaf], base, motion, leaf_name="rotation_board"))


def _extension(draw: Draw, top: Node, base: Link, links: list[Link], size: tuple[float, float, float], thick: float) -> None:
    """Add a fixed board with one or two leaves that slide out at its ends, or two halves that slide apart."""
    x, y, z = size
    apart = draw.chance(0.4)
    if not apart:
        base.nodes.append(top.add("board", box_between((-x, y + thick, -z), (x, y + 2 * thick, z))))
    reach = x * draw.between(0.3, 0.9)
    for side in (-1.0, 1.0) if apart or draw.chance(0.6) else (draw.sign(),):
        inner = 0.0 if apart else side * (x - reach)
        low, high = sorted((inner, side * x))
        leaf = top.add("board", box_between((low, y, -0.98 * z), (high, y + thick, 0.98 * z)))
        rest = reach * draw.pick([0.0, draw.between(0.2, 1.0)])
        motion = slider(np.array([side, 0.0, 0.0]), 0.0, reach, rest=rest)
        links.append(Link("board", [leaf], base, motion, leaf_name="translation_board"))
