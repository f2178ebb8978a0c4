"""Printers and copiers with covers, trays, paper supports, keys and displays."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from kinmo.core.shape import Mesh
from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.details.resting_details import add_body_details, let_rest
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, box_between, facing, rotation, rounded_box, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider

RESTING_KEYS_SHARE = 0.15
"""Share of control panels whose keys do not move, on printers with other joints."""


@dataclass(frozen=True)
class _Case:
    """Half width, half depth and height of the case, which stands on y = 0."""

    x: float
    z: float
    top: float


def build(draw: Draw) -> SynthObject:
    """Printer with a cover that folds up, trays that slide or fold out, and a paper support that tips or slides.

    Keys mostly slide in, and the control panel may tip.
    """
    case = _Case(draw.between(0.4, 0.75), draw.between(0.3, 0.6), draw.between(0.25, 0.9))
    root = Node("Printer")
    levels = [0.03]
    for _ in range(draw.integer(0, 3)):
        levels.append(levels[-1] + draw.between(0.15, 0.28) * case.top)
    body = root.add("base_body", *_shell(draw, case, levels[-1] if len(levels) > 1 else 0.0))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.HEAVY, JointType.STATIC], [3, 2, 1]))
    links = [base]
    if draw.chance(0.75):
        links += _cover(draw, root, base, case)
    if draw.chance(0.6):
        links.append(_support(draw, root, base, case))
    for low, high in pairwise(levels):
        links.append(draw.pick([_sliding_tray, _folding_tray])(draw, root, base, case, low, high - 0.02))
    if draw.chance(0.8) or len(links) == 1:
        rests = len(links) > 1 and draw.chance(RESTING_KEYS_SHARE)
        links += _panel(draw, root, base, case, keys_rest=rests)
    if draw.chance(0.4):
        base.nodes += add_body_details(draw, root, (-case.x, 0.0, -case.z), (case.x, case.top, case.z))
    return SynthObject("Printer", root, links)


def _shell(draw: Draw, case: _Case, split: float) -> list[Mesh]:
    """The case: a block above the height `split`, and walls around the trays below it."""
    size = (2 * case.x, case.top - split, 2 * case.z)
    middle = (0, 0.5 * (case.top + split), 0)
    rounded = rounded_box(size, draw.between(0.01, 0.15), draw.pick(["y", "x"]), middle)
    pieces = [rounded if draw.chance(0.6) else box(size, middle)]
    if split > 0.0:
        wall = 0.02
        pieces.append(box_between((-case.x, 0, -case.z), (case.x, wall, case.z)))
        pieces.append(box_between((-case.x, wall, -case.z), (case.x, split, -case.z + wall)))
        for side in (-1, 1):
            pieces.append(box((wall, split - wall, 2 * case.z), (side * (case.x - 0.5 * wall), 0.5 * (split + wall), 0)))
    return pieces


def _cover(draw: Draw, root: Node, base: Link, case: _Case) -> list[Link]:
    """A cover over all or part of the top, hinged at the rear or at a side, sometimes with a feeder."""
    thick, reach = draw.between(0.03, 0.15), draw.pick([1.0, draw.between(0.5, 0.95)])
    slab = box_between((-case.x, case.top, -case.z), (case.x, case.top + thick, -case.z + 2 * reach * case.z))
    opens = draw.between(60.0, 100.0)
    rest = draw.between(10.0, opens) if draw.chance(0.25) else 0.0
    if draw.chance(0.85):
        motion = hinge((0, case.top + draw.pick([0.0, 0.5 * thick]), -case.z), -X, 0.0, opens, rest=rest)
    else:
        motion = hinge((-case.x, case.top, 0), Z, 0.0, opens, rest=rest)
    lid = Link("lid", [root.add(draw.pick(["lid", "cover"]), slab)], base, motion)
    if draw.chance(0.25):
        feeder = box((case.x, 0.08, case.z), (-0.4 * case.x, case.top + thick + 0.04, -0.3 * case.z))
        lid.nodes[0].pieces.append(feeder)
    return [lid]


def _support(draw: Draw, root: Node, base: Link, case: _Case) -> Link:
    """A plate at the rear that holds paper. It tips back from vertical, or slides up."""
    tall, thick, wide = draw.between(0.2, 0.6), draw.between(0.01, 0.04), case.x * draw.between(0.5, 0.95)
    foot = (0.0, case.top - draw.between(0.0, 0.1), -case.z + draw.pick([0.0, 0.04]))
    plate = box((2 * wide, tall, thick), (0, foot[1] + 0.5 * tall, foot[2]))
    lean = -draw.between(5.0, 50.0)
    node = root.add(draw.pick(["tray", "paper_support", "lid"]))
    if draw.chance(0.75):
        node.pieces = [plate]
        rest = draw.pick([lean, 0.0, 0.5 * lean], [4, 1, 1])
        return Link("tray", [node], base, hinge(foot, X, lean, draw.pick([0.0, 60.0, 90.0]), rest=rest))
    node.pieces = [turn(plate, X, lean, foot)]
    return Link("tray", [node], base, slider(rotation(X, lean) @ Y, draw.pick([0.0, -0.5 * tall]), 0.5 * tall))


def _sliding_tray(draw: Draw, root: Node, base: Link, case: _Case, low: float, high: float) -> Link:
    """A cassette or an output tray that slides out to the front."""
    wide, deep, proud = case.x * draw.between(0.5, 0.95), case.z * draw.between(0.8, 1.7), draw.between(0.0, 0.25)
    thin = draw.chance(0.4)
    top = low + (0.03 if thin else high - low)
    pieces: list[Mesh] = [box_between((-wide, low, case.z - deep), (wide, min(low + 0.02, top), case.z + proud))]
    pieces.append(box_between((-wide, low, case.z + proud), (wide, top, case.z + proud + 0.03)))
    if draw.chance(0.4):
        pieces.append(box((0.4 * wide, 0.03, 0.03), (0, 0.5 * (low + top), case.z + proud + 0.045)))
    travel = deep * draw.between(0.3, 0.95)
    rest = travel * draw.pick([0.0, draw.between(0.1, 0.9)], [3, 1])
    return Link("tray", [root.add(draw.pick(["tray", "drawer"], [3, 1]), *pieces)], base, slider(Z, 0.0, travel, rest=rest))


def _folding_tray(draw: Draw, root: Node, base: Link, case: _Case, low: float, high: float) -> Link:
    """A flap in the front that folds down about its lower edge."""
    wide, thick = case.x * draw.between(0.5, 0.95), draw.between(0.015, 0.05)
    flap = box_between((-wide, low, case.z), (wide, high, case.z + thick))
    opens = draw.pick([60.0, 90.0, 100.0])
    rest = draw.pick([0.0, opens, draw.between(0.2, 0.9) * opens], [3, 2, 1])
    axis = (0, low + draw.pick([0.0, 0.5 * thick]), case.z + draw.pick([0.0, 0.5 * thick]))
    return Link("tray", [root.add(draw.pick(["tray", "door", "lid"]), flap)], base, hinge(axis, X, 0.0, opens, rest=rest))


def _panel(draw: Draw, root: Node, base: Link, case: _Case, *, keys_rest: bool) -> list[Link]:
    """A control panel with keys at the upper front edge, at any angle; the panel itself may tip."""
    wide, tall = case.x * draw.between(0.3, 1.2), draw.between(0.1, 0.25)
    panel = root.add("panel", box((wide, tall, 0.03), (0, 0, 0.015)))
    owner = base
    links: list[Link] = []
    if draw.chance(0.25):
        motion = hinge((0, 0.5 * tall, 0), -X, 0.0, draw.between(20.0, 70.0), rest=draw.pick([0.0, 20.0]))
        owner = Link("screen", [panel], base, motion, leaf_name="screen")
        links.append(owner)
        loose = [owner]
    else:
        loose = [Link("panel", [panel])]
        base.nodes.append(panel)
    size, center = (0.6 * wide, 0.7 * tall), (draw.between(-0.15, 0.15) * wide, 0.0, 0.03)
    keys = add_keypad(draw, root, owner, center, size, "button", lookalikes=False)
    lean = draw.pick([0.0, draw.between(20.0, 70.0), 90.0])
    normal = rotation(X, -lean) @ Z
    upright = lean < 60.0
    drop = (0.5 * tall, 0.0) if upright else (-0.005, 0.5 * tall)
    at = (draw.between(-0.3, 0.3) * case.x, case.top - drop[0], case.z - drop[1])
    place = facing(normal, rotation(X, -lean) @ Y, at)
    for link in [*loose, *keys]:
        link.move(place)
    if keys_rest:
        let_rest(keys, owner)
        return links
    return links + keys
