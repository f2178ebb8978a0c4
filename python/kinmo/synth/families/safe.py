"""Safes: a thick box with a hinged door, on the door a dial, a wheel or handle, or a keypad."""

from __future__ import annotations

from kinmo.shape import Mesh
from kinmo.synth.details.controls import button, dial, grid_places
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.model import JointName, Link, Node, SynthObject, hinge, slider, spinner
from kinmo.synth.primitives import box, box_between, cylinder, move, torus, turn


def build(draw: Draw) -> SynthObject:
    width, height, depth = draw.between(0.8, 1.3), draw.between(0.8, 1.7), draw.between(0.7, 1.2)
    wall = draw.between(0.04, 0.14)
    front, thickness = depth / 2, draw.between(0.03, 0.15)
    root = Node("Safe")
    body = root.add("base_body", *_casing(draw, width, height, depth, wall, thickness))
    base = Link("base_body", [body], kind=draw.pick([JointName.HEAVY, JointName.FREE, JointName.STATIC], [6, 2, 2]))

    side = draw.pick([-1.0, 1.0], [1, 4])
    door_width, door_height = width - 2 * wall, height - 2 * wall
    proud = draw.pick([0.0, draw.between(0.0, 0.05)])
    face = front + proud
    door_node = root.add("door", box((door_width, door_height, thickness), (0, 0, face - thickness / 2)))
    if draw.chance(0.3):
        bolts = [
            cylinder(0.02, 0.08, "x", (-side * (door_width / 2 + 0.02), y, face - thickness * 0.6)) for y in (-0.2, 0.0, 0.2)
        ]
        door_node.pieces += bolts
    inward = draw.between(0.0, 0.04)
    axis = (side * (door_width / 2 - inward), draw.pick([0.0, height / 2 - wall]), face - draw.pick([0.0, inward, thickness]))
    opening = draw.pick([90.0, 120.0, 160.0, 170.0, 180.0], [1, 1, 2, 4, 1])
    rest = draw.between(30, 100) if draw.chance(0.25) else 0.0
    door = Link("door", [door_node], base, hinge(axis, (0, side, 0), 0, opening, rest=rest))
    if draw.chance(0.5):
        hinges = [cylinder(0.02, 0.12 * height, "y", (axis[0], y * height, front), 12) for y in (-0.3, 0.3)]
        if draw.chance(0.6):
            body.pieces += hinges
        else:
            base.nodes.append(root.add("hinge", *hinges))

    links = [base, door]
    lock_x = -side * door_width * draw.between(0.1, 0.3)
    _locks(draw, root, links, lock_x, door_height, face)
    return SynthObject("Safe", root, links)


def _casing(draw: Draw, width: float, height: float, depth: float, wall: float, recess: float) -> list[Mesh]:
    """Five walls of a box open to the front, one piece each or as a solid block behind the door."""
    x, y, z = width / 2, height / 2, depth / 2
    sides = [box_between((-x, -y, -z), (-x + wall, y, z)), box_between((x - wall, -y, -z), (x, y, z))]
    ends = [
        box_between((-x + wall, -y, -z), (x - wall, -y + wall, z)),
        box_between((-x + wall, y - wall, -z), (x - wall, y, z)),
    ]
    if draw.chance(0.3):
        back = box_between((-x + wall, -y + wall, -z), (x - wall, y - wall, z - recess))
    else:
        back = box_between((-x + wall, -y + wall, -z), (x - wall, y - wall, -z + wall))
    pieces = [*sides, *ends, back]
    if draw.chance(0.4):
        pieces += [box((0.12, 0.06, 0.12), (sx * (x - 0.1), -y - 0.03, sz * (z - 0.1))) for sx in (-1, 1) for sz in (-1, 1)]
    return pieces


def _locks(draw: Draw, root: Node, links: list[Link], x: float, height: float, face: float) -> None:
    """What is on the door: a dial, a wheel or lever to turn, and sometimes a keypad."""
    door = links[1]
    kinds = draw.pick([["wheel"], ["dial"], ["wheel", "dial"], ["keypad"], ["keypad", "dial"], ["fixed"]], [3, 2, 4, 3, 2, 1])
    for row, kind in enumerate(kinds):
        y = (0.0 if len(kinds) == 1 else (0.5 - row) * 0.45 * height) + draw.between(-0.05, 0.05)
        if kind in ("dial", "wheel"):
            radius = draw.between(0.04, 0.1) if kind == "dial" else draw.between(0.1, 0.2)
            pieces = (
                dial(draw, radius, radius * draw.between(0.3, 0.8), (x, y, face))
                if kind == "dial"
                else _wheel(draw, radius, (x, y, face))
            )
            links.append(
                Link("knob", [root.add("switch", *pieces)], door, spinner((x, y, 0 if draw.chance(0.7) else face), (0, 0, 1)))
            )
        elif kind == "keypad":
            size = draw.between(0.05, 0.07)
            travel = draw.between(0.003, 0.012)
            for column, line in grid_places(3, draw.integer(3, 4), 4 * size, 5 * size):
                node = root.add("button", button(draw, size, 0.75 * size, 1.5 * travel, (x + column, y + line, face)))
                links.append(Link("button", [node], door, slider((0, 0, -1), 0, travel)))
        else:
            door.nodes.append(root.add("handle", *pull(draw, 0.2 * height, (x, y, face), vertical=draw.chance(0.7))))


def _wheel(draw: Draw, radius: float, at: tuple[float, float, float]) -> list[Mesh]:
    """A hub with spokes, sometimes a rim, or a single lever."""
    reach, rod = draw.between(0.04, 0.12), 0.12 * radius
    hub = cylinder(0.35 * radius, reach, "z", (0, 0, reach / 2), 20)
    count = draw.pick([1, 2, 3, 4, 5])
    spoke = cylinder(rod, radius, "x", (radius / 2, 0, 0.8 * reach), 8)
    pieces = [hub, *(turn(spoke, (0, 0, 1), 360.0 * i / count) for i in range(count))]
    if count >= 3 and draw.chance(0.4):
        pieces.append(torus(radius, rod, "z", (0, 0, 0.8 * reach), 24))
    return [move(piece, at) for piece in pieces]
