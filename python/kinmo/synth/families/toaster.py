"""Toasters with levers, dials, buttons, racks and crumb trays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import button, dial
from kinmo.synth.details.handles import knob_handle, pull
from kinmo.synth.details.resting_details import add_body_details
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    box,
    box_between,
    cylinder,
    extrude,
    facing,
    move,
    rounded_box,
    rounded_outline,
    transform,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Node, Point, SynthObject, hinge, slider, spinner

FIXED_CONTROL_SHARE = 0.15
"""Share of dials and rows of buttons that do not move."""


@dataclass(frozen=True)
class _Plan:
    """Size of the body, standing on y = 0: x is across the slots, z along them."""

    width: float
    height: float
    length: float
    slots: int
    rows: int

    @property
    def front(self) -> float:
        """Position of the end face along z."""
        return 0.5 * self.length


def build(draw: Draw) -> SynthObject:
    """Toaster whose levers slide down along the ends.

    Dials turn; buttons, browning sliders, racks and the crumb tray slide. A cover over the slots folds up, and a warming rack
    on top tips or lifts off.
    """
    slots, rows = draw.pick([(1, 1), (2, 1), (2, 2), (4, 1)], [1, 6, 1, 1])
    length = draw.ratio(0.8, 1.9) * (1.3 if rows == 2 else 1.0)
    plan = _Plan(draw.ratio(0.3, 0.7) * slots**0.65, draw.ratio(0.5, 1.3), length, slots, rows)
    body = Node("base_body", pieces=_body(draw, plan))
    base = Link("base_body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY], [4, 1, 1]))
    links = [base, *_end_controls(draw, plan, base, body)]
    if draw.chance(0.3):
        links.append(_crumb_tray(draw, plan, base))
    if draw.chance(0.3):
        links += _racks(draw, plan, base)
    elif draw.chance(0.15):
        links.append(_top_part(draw, plan, base))
    if draw.chance(0.4):
        half = (0.5 * plan.width, plan.front)
        base.nodes += add_body_details(draw, Node("details"), (-half[0], 0.0, -half[1]), (half[0], plan.height, half[1]))
    if draw.chance(0.15):
        base.nodes += _side_grips(draw, plan)
    return SynthObject.flat("Toaster", links)


def _body(draw: Draw, plan: _Plan) -> list[Mesh]:
    """A block with bars between the slots on top, or a solid body with shallow slots."""
    if draw.chance(0.25):
        return _solid_body(draw, plan)
    deep = plan.height * draw.between(0.4, 0.9)
    floor = plan.height - deep
    wall = draw.between(0.06, 0.15) * plan.width
    end = 0.5 * (plan.length - draw.between(0.7, 0.85) * plan.length)
    radius = draw.pick([draw.between(0.02, 0.15), draw.between(0.15, 0.32)]) * plan.width
    pieces = [box((plan.width, floor, plan.length - 2 * end), (0, 0.5 * floor, 0))]
    for side in (-1.0, 1.0):
        middle = (0, 0.5 * plan.height, side * (plan.front - 0.5 * end))
        pieces.append(rounded_box((plan.width, plan.height, end), radius, "z", middle))
    opening = (plan.width - 2 * wall) / plan.slots * draw.between(0.5, 0.75)
    bar = (plan.width - 2 * wall - plan.slots * opening) / max(plan.slots - 1, 1)
    x = -0.5 * plan.width
    for index in range(plan.slots + 1):
        wide = wall if index in (0, plan.slots) else bar
        pieces.append(box_between((x, floor, -plan.front + end), (x + wide, plan.height, plan.front - end)))
        x += wide + opening
    if plan.rows == 2:
        pieces.append(box((plan.width, deep, end), (0, floor + 0.5 * deep, 0)))
    if draw.chance(0.3):
        # The sides bulge out.
        bulge = draw.between(0.03, 0.08)
        outline = rounded_outline(0.9 * plan.length, 0.85 * plan.height, 0.2 * plan.height)
        sides = [extrude(outline[:, ::-1], bulge, "x", (s * (plan.width + bulge) / 2, plan.height / 2, 0)) for s in (-1, 1)]
        pieces += sides
    if draw.chance(0.5):
        places = [(x * 0.38 * plan.width, z * 0.4 * plan.length) for x in (-1, 1) for z in (-1, 1)]
        pieces += [cylinder(0.05, 0.05, "y", (x, -0.025, z), 12) for x, z in places]
    if draw.chance(0.15):
        slice_size = (0.6 * opening, 0.5 * plan.height, 0.5 * plan.length)
        pieces.append(box(slice_size, (-0.5 * plan.width + wall + 0.5 * opening, plan.height, 0)))
    return pieces


def _solid_body(draw: Draw, plan: _Plan) -> list[Mesh]:
    """A body without an inside: a block, a loaf with a round top, or one with leaning sides. Plates mark the slots."""
    low, half = draw.pick([0.0, 0.05 * plan.height]), 0.5 * plan.width
    form = draw.pick(["block", "loaf", "leaning"])
    if form == "block":
        tall = plan.height - low
        body = rounded_box((plan.width, tall, plan.length), draw.between(0.05, 0.3) * plan.width, "y", (0, low + tall / 2, 0))
    else:
        top = half * (draw.between(0.6, 0.9) if form == "leaning" else 1.0)
        bend = draw.between(0.1, 0.5) * half if form == "loaf" else 0.02
        turned = np.linspace(0.0, np.pi / 2, 5)
        arc = np.stack([top - bend + bend * np.cos(turned), plan.height - bend + bend * np.sin(turned)], axis=1)
        outline = np.concatenate([[(-half, low), (half, low)], arc, arc[::-1] * (-1, 1)])
        body = extrude(outline, plan.length, "z")
    pitch, long = 0.8 * plan.width / plan.slots, plan.length * draw.between(0.6, 0.85)
    places = (np.arange(plan.slots) - 0.5 * (plan.slots - 1)) * pitch
    wide, proud = pitch * draw.between(0.3, 0.6), draw.pick([0.004, 0.03])
    if draw.chance(0.5):
        return [body, *(box((wide, proud, long), (x, plan.height, 0)) for x in places)]
    rims = [box((0.15 * wide, 2 * proud, long), (x + s * 0.5 * wide, plan.height, 0)) for x in places for s in (-1, 1)]
    return [body, *rims]


def _crumb_tray(draw: Draw, plan: _Plan, base: Link) -> Link:
    """A tray below or just above the bottom that slides out at an end or a side, with or without a grip."""
    out, wide, long = draw.pick([(Z, plan.width, plan.length), (X, plan.length, plan.width)], [4, 1])
    side, y, thin = draw.sign(), draw.pick([-0.01, draw.between(0.02, 0.12) * plan.height]), draw.ratio(0.008, 0.05)
    place = facing(side * out, Y, (0, y, 0))
    wide *= draw.between(0.4, 0.9)
    pieces = [box((wide, thin, 0.9 * long), (0, 0, 0.05 * long))]
    grip = draw.pick(["none", "lip", "plate", "knob"])
    if grip == "lip":
        pieces.append(box((0.4 * wide, 1.5 * thin, 0.05), (0, 0.5 * thin, 0.5 * long)))
    elif grip == "plate":
        pieces.append(box((wide, draw.ratio(0.03, 0.1), 0.02), (0, 0.5 * thin, 0.5 * long + 0.01)))
    elif grip == "knob":
        pieces += [move(piece, (0, 0, 0.5 * long)) for piece in knob_handle(draw, 0.03, 0.05)]
    reach = long * draw.between(0.4, 0.85)
    motion = slider(Z, 0.0, reach, rest=reach * draw.pick([0.0, draw.between(0.1, 0.6)], [3, 1]))
    node = Node(draw.pick(["tray", "other"], [4, 1]), pieces=[transform(piece, place) for piece in pieces])
    return Link("tray", [node], base, motion.moved_by(place))


def _side_grips(draw: Draw, plan: _Plan) -> list[Node]:
    """Handles at both sides that are fixed to the body."""
    grip = pull(draw, draw.between(0.2, 0.6) * plan.length, (0, draw.between(0.5, 0.8) * plan.height, 0), vertical=False)
    places = [facing(side * X, Y, (side * 0.5 * plan.width, 0, 0)) for side in (-1.0, 1.0)]
    return [Node("handle", pieces=[transform(piece, place) for piece in grip]) for place in places]


def _top_part(draw: Draw, plan: _Plan, base: Link) -> Link:
    """A cover over the slots that folds up about an edge, or a wire rack on two bows that tips or lifts off."""
    top, half, long = plan.height, 0.45 * plan.width, draw.between(0.6, 0.95) * plan.length
    if draw.chance(0.5):
        thick = draw.between(0.02, 0.06)
        cover = Node(draw.pick(["lid", "cover"]), pieces=[box((2 * half, thick, long), (0, top + 0.5 * thick, 0))])
        opens = draw.between(80.0, 120.0)
        side = draw.sign()
        motion = hinge((side * half, top + 0.5 * thick, 0), -side * Z, 0.0, opens, rest=draw.pick([0.0, opens], [2, 1]))
        return Link("lid", [cover], base, motion)
    rise, wire = draw.between(0.08, 0.3), draw.between(0.006, 0.015)
    rods = [cylinder(wire, 2 * half, "x", (0, top + rise, z), 8) for z in np.linspace(-0.5, 0.5, draw.integer(3, 8)) * long]
    rods += [cylinder(wire, long, "z", (s * half, top + rise, 0), 8) for s in (-1, 1)]
    rods += [
        cylinder(wire, rise + 0.1, "y", (s * half, top + 0.5 * rise - 0.05, z * long), 8) for s in (-1, 1) for z in (-0.5, 0.5)
    ]
    rack = Node(draw.pick(["rack", "other"]), pieces=rods)
    up = slider(Y, 0.0, rise + 0.1)
    tips = hinge((half, top + 0.02, 0), -Z, 0.0, draw.between(30.0, 90.0))
    return Link("rack", [rack], base, draw.pick([up, tips]))


def _racks(draw: Draw, plan: _Plan, base: Link) -> list[Link]:
    """Wire racks in the slots that slide up."""
    motion = slider(Y, 0.0, plan.height * draw.between(0.1, 0.8))
    pieces = _cage(draw, plan)
    links = []
    for index in range(plan.slots):
        x = (index - 0.5 * (plan.slots - 1)) * 0.8 * plan.width / plan.slots
        slot = Node("other")
        slot.add("slot", *(move(piece, (x, 0, 0)) for piece in pieces))
        links.append(Link("slot", [slot], base, motion))
    return links


def _cage(draw: Draw, plan: _Plan) -> list[Mesh]:
    """Meshes of a rack: two grids of vertical wires, or bows between the sides. Its top is level with the body's top."""
    half, wire = plan.width * draw.between(0.06, 0.17), draw.between(0.003, 0.008)
    tall, long = plan.height * draw.between(0.5, 0.7), plan.length * draw.between(0.45, 0.6)
    top, low, sides = plan.height - wire, plan.height - tall, (-half, half)
    places = np.linspace(-0.5, 0.5, draw.integer(6, 12)) * long
    corners = draw.pick([4, 6, 8], [1, 2, 2])

    def rod(length: float, axis: str, at: Point) -> Mesh:
        return cylinder(wire, length, axis, at, corners)

    rods = [rod(tall, "y", (x, low + 0.5 * tall, z)) for x in sides for z in places]
    rods += [rod(long, "z", (x, top, 0)) for x in sides]
    if draw.chance(0.5):
        return rods + [rod(2 * half, "x", (0, low + wire, z)) for z in places]
    rods += [rod(long, "z", (x, low + wire, 0)) for x in sides]
    return rods + [rod(2 * half, "x", (0, y, z)) for y in (top, low + wire) for z in (places[0], places[-1])]


def _end_controls(draw: Draw, plan: _Plan, base: Link, body: Node) -> list[Link]:
    """Levers, and a dial, a browning slider and buttons, on the end faces."""
    levers = [(0.0, 1.0)]
    if plan.rows == 2 or (plan.slots == 4 and draw.chance(0.5)) or draw.chance(0.08):
        levers = [(0.0, 1.0), (0.0, -1.0)] if draw.chance(0.5) else [(-0.22, 1.0), (0.22, 1.0)]
    elif draw.chance(0.25):
        levers = [(draw.between(-0.42, 0.42), 1.0)]
    links = [_lever(draw, plan, base, body, x * plan.width, facing, len(levers)) for x, facing in levers]
    taken = levers[0][0] * plan.width
    # Other controls are below the lever or beside it.
    beside = -np.sign(taken or draw.sign()) * draw.between(0.2, 0.42) * plan.width
    radius = draw.between(0.035, 0.08)
    at = draw.pick([(taken, 0.2), (beside, draw.between(0.15, 0.4))])
    place = (at[0], max(at[1] * plan.height, 1.2 * radius), plan.front)
    if draw.chance(0.6):
        links += _dial(draw, base, place, radius)
        if draw.chance(0.15):
            above = (place[0], place[1] + draw.between(2.3, 4.0) * radius, place[2])
            links += _dial(draw, base, above, radius)
    elif draw.chance(0.45):
        links.append(_level_slider(draw, plan, base, body))
    if draw.chance(0.35):
        links += _buttons(draw, plan, base, -place[0] if abs(place[0]) > 0.1 else beside)
    return links


def _dial(draw: Draw, base: Link, place: tuple[float, float, float], radius: float) -> list[Link]:
    """A dial on an end face that turns, upright or leaning back. Some do not move."""
    lean = draw.between(-35.0, 0.0) if draw.chance(0.25) else 0.0
    knob = Node(draw.pick(["button", "knob"], [3, 1]))
    knob.pieces = [turn(piece, X, lean, place) for piece in dial(draw, radius, draw.between(0.02, 0.1), place)]
    if draw.chance(FIXED_CONTROL_SHARE):
        base.nodes.append(knob)
        return []
    axis = (0.0, -np.sin(np.radians(lean)), np.cos(np.radians(lean)))
    origin = (place[0], place[1], draw.pick([0.0, place[2]])) if lean == 0.0 else place
    motion = spinner(origin, axis) if draw.chance(0.75) else hinge(origin, axis, *draw.pick([(-135, 135), (0, 270)]))
    return [Link("knob", [knob], base, motion)]


def _lever(draw: Draw, plan: _Plan, base: Link, body: Node, x: float, facing: float, count: int) -> Link:
    """A lever at an end that slides down."""
    wide = draw.ratio(0.08, 0.6) * min(plan.width, 0.6) / (1.0 if count == 1 else 1.5)
    tall, reach = draw.ratio(0.015, 0.2), draw.ratio(0.03, 0.25)
    top = plan.height * draw.between(0.55, 0.9)
    travel = (top - 0.15 * plan.height) * draw.between(0.5, 0.9)
    grip = box((wide, tall, reach), (0, 0, 0.5 * reach + 0.02))
    taper = draw.between(0.4, 1.3) if draw.chance(0.3) else 1.0
    grip.vertices[grip.vertices[:, 2] > 0.5 * reach] *= (taper, taper, 1.0)
    if draw.chance(0.3):
        grip = rounded_box((wide, tall, reach), 0.4 * tall, "x", (0, 0, 0.5 * reach + 0.02))
    elif draw.chance(0.2):
        grip = cylinder(0.5 * tall, wide, "x", (0, 0, 0.5 * reach + 0.02), 14)
    elif draw.chance(0.2):
        size = min(0.5 * tall, 0.5 * wide)
        grip = cylinder(size, reach, "z", (0, 0, 0.5 * reach + 0.02), 16, top_radius=size * draw.between(1.0, 1.6))
    pieces = [grip]
    if draw.chance(0.5):
        inside = draw.between(0.03, 0.35)
        pieces.append(box((0.3 * wide, 0.5 * tall, inside), (0, 0, 0.03 - 0.5 * inside)))
    if draw.chance(0.2):
        # A carriage behind the wall.
        pieces.append(box((1.3 * wide, draw.between(0.05, 0.4) * plan.height, 0.02), (0, 0, -0.05)))
    if draw.chance(0.6):
        track = [box((0.02, 1.1 * travel, 0.004), (x + s * 0.02, top - 0.5 * travel, facing * plan.front)) for s in (-1, 1)]
        body.pieces += track
    spun = 0.0 if facing > 0 else 180.0
    node = Node("slider", pieces=[move(turn(piece, Y, spun), (x, top, facing * plan.front)) for piece in pieces])
    rest = -travel * draw.pick([0.0, 1.0, draw.between(0.0, 1.0)], [5, 1, 1])
    if draw.chance(0.3):
        return Link("slider", [node], base, slider((0, -1, 0), 0.0, travel, rest=-rest))
    return Link("slider", [node], base, slider(Y, -travel, draw.pick([0.0, 0.1 * travel]), rest=rest))


def _level_slider(draw: Draw, plan: _Plan, base: Link, body: Node) -> Link:
    """A browning tab that slides in a horizontal slot across an end or along a side."""
    y, tall = draw.between(0.1, 0.5) * plan.height, draw.between(0.02, 0.08)
    wide, proud = draw.between(0.03, 0.2), draw.between(0.02, 0.06)
    across = draw.chance(0.8)
    half, wall = (0.5 * plan.width, plan.front) if across else (0.5 * plan.length, 0.5 * plan.width)
    side, reach = draw.sign(), half * draw.between(0.25, 0.6)
    place = facing(side * Z if across else side * X, Y, (0, y, side * wall) if across else (side * wall, y, 0))
    at = draw.between(-1.0, 1.0) * reach
    body.pieces.append(transform(box((2 * reach + wide, 0.3 * tall, 0.01)), place))
    tab = transform(box((wide, tall, proud), (at, 0, 0.5 * proud)), place)
    return Link("slider", [Node("slider", pieces=[tab])], base, slider(X, -reach - at, reach - at).moved_by(place))


def _buttons(draw: Draw, plan: _Plan, base: Link, x: float) -> list[Link]:
    """A column of buttons that slide in."""
    count = draw.integer(1, 4)
    size = min(draw.ratio(0.03, 0.1), 0.12 * plan.height)
    moves = not draw.chance(FIXED_CONTROL_SHARE)
    pitch = size * draw.between(1.2, 1.6)
    depth = draw.between(0.008, 0.03)
    low = plan.height * draw.between(0.15, 0.4)
    links = []
    for index in range(count):
        node = Node("button", pieces=[button(draw, size, 0.8 * size, depth, (x, low + index * pitch, plan.front))])
        if not moves:
            base.nodes.append(node)
            continue
        inwards = draw.chance(0.3)
        motion = slider((0, 0, -1), 0, 0.6 * depth) if inwards else slider((0, 0, 1), -0.6 * depth, 0)
        links.append(Link("button", [node], base, motion))
    return links
