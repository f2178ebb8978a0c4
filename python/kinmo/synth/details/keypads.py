"""Fields of buttons that go in, on a front (+z) or at the sides."""

from __future__ import annotations

from kinmo.synth.details.controls import button, grid_places
from kinmo.synth.draw import Draw
from kinmo.synth.model import Link, Node, slider
from kinmo.synth.primitives import box


def keypad(draw: Draw, base: Link, width: float, height: float, front: float, share: float) -> list[Link]:
    """Rows of buttons over the lower `share` of a front of `width` by `height` about the origin, at z = `front`."""
    columns, rows = draw.integer(2, 4), draw.integer(2, 7)
    field = (0.85 * width, share * height)
    size = (field[0] / columns * draw.between(0.55, 0.85), min(field[1] / rows, 0.2) * draw.between(0.5, 0.8))
    depth = draw.between(0.01, 0.04)
    middle = -0.5 * (1 - share) * 0.9 * height
    inwards = draw.chance(0.5)
    links = []
    for x, y in grid_places(columns, rows, *field):
        node = Node("button", pieces=[button(draw, *size, depth, (x, y + middle, front - 0.2 * depth))])
        motion = slider((0, 0, -1), 0.0, 0.6 * depth) if inwards else slider((0, 0, 1), -0.6 * depth, 0.0)
        links.append(Link("button", [node], base, motion))
    return links


def side_keys(draw: Draw, base: Link, width: float, height: float) -> list[Link]:
    """One or two keys on the upper half of one side."""
    links = []
    side = draw.sign()
    for _ in range(draw.integer(1, 2)):
        y = height * draw.between(-0.1, 0.4)
        node = Node("button", pieces=[box((0.03, 0.12, 0.03), (side * 0.5 * width, y, 0))])
        links.append(Link("button", [node], base, slider((-side, 0, 0), 0.0, 0.01)))
    return links
