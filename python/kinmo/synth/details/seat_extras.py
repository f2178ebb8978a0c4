"""Moving parts of chairs besides the seat: arms that rise, slide or turn up, footrests, writing boards."""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, cylinder, rounded_box
from kinmo.synth.synth_object import Link, Motion, Node, hinge, slider


def add_moving_arms(draw: Draw, root: Node, seat: Link, y: float, radius: float) -> list[Link]:
    """Add two armrests that slide up their posts, or turn up about a horizontal line at the back."""
    links = []
    top, x = y + draw.between(0.3, 0.45), radius * draw.between(0.98, 1.1)
    size = (draw.between(0.06, 0.12), draw.between(0.03, 0.06), radius * draw.between(0.8, 1.3))
    rises = draw.chance(0.6)
    opens, reach = draw.between(60.0, 110.0), draw.between(0.08, 0.2)
    for side in (-1.0, 1.0):
        arm: list[Mesh] = [rounded_box(size, 0.3 * size[0], "y", (side * x, top, 0))]
        if rises:
            arm.append(box((0.05, 0.5 * (top - y), 0.08), (side * x, top - 0.25 * (top - y), 0)))
            seat.nodes.append(
                root.add("arm_vertical_bar", box((0.08, 0.6 * (top - y), 0.11), (side * x, y + 0.3 * (top - y), 0)))
            )
            motion: Motion = slider(Y, 0.0, reach, rest=draw.pick([0.0, 0.5 * reach]))
        else:
            pin = (side * x, top, -0.5 * size[2])
            seat.nodes.append(root.add("arm_connector", box((0.07, top - y + 0.04, 0.06), (side * x, 0.5 * (top + y), pin[2]))))
            motion = hinge(pin, -X, 0.0, opens, rest=draw.pick([0.0, opens, 0.5 * opens], [4, 1, 1]))
        links.append(Link("arm", [root.add("chair_arm", *arm)], seat, motion))
    return links


def add_foot_rest(draw: Draw, root: Node, seat: Link, y: float, radius: float) -> Link:
    """Add a footrest that folds up about the seat's front edge, or slides out from below the seat."""
    tall, thick, wide = draw.between(0.25, 0.5), draw.between(0.04, 0.1), radius * draw.between(1.2, 1.9)
    name = draw.pick(["footrest", "foot_rest", "seat_extension"])
    if draw.chance(0.65):
        node = root.add(name, box((wide, tall, thick), (0, y - 0.5 * tall, radius)))
        opens = draw.between(60.0, 95.0)
        rest = draw.pick([0.0, opens, 0.5 * opens], [3, 2, 1])
        return Link("footrest", [node], seat, hinge((0, y, radius + draw.pick([0.0, 0.5]) * thick), -X, 0.0, opens, rest=rest))
    node = root.add(name, box((wide, thick, 0.9 * radius), (0, y - 0.5 * thick - 0.02, 0.5 * radius)))
    reach = radius * draw.between(0.4, 0.85)
    return Link("footrest", [node], seat, slider(Z, 0.0, reach, rest=reach * draw.pick([0.0, draw.between(0.2, 1.0)])))


def add_writing_board(draw: Draw, root: Node, seat: Link, y: float, radius: float) -> Link:
    """Add a writing board on a post beside the seat that swings about the post, or folds up sideways."""
    side, top = draw.sign(), y + draw.between(0.35, 0.5)
    x = side * 1.05 * radius
    seat.nodes.append(root.add("arm_vertical_bar", cylinder(0.03, top - y, "y", (x, 0.5 * (top + y), 0.2 * radius), 12)))
    board = rounded_box((1.2 * radius, 0.04, 0.9 * radius), 0.1, "y", (x - side * 0.6 * radius, top + 0.02, 0.3 * radius))
    node = root.add(draw.pick(["tabletop", "board"]), board)
    if draw.chance(0.5):
        motion = hinge((x, top, 0.2 * radius), Y, *draw.pick([(-90.0, 0.0), (0.0, 90.0), (-90.0, 90.0)]))
    else:
        opens = draw.pick([90.0, 110.0])
        motion = hinge((x, top, 0), -side * Z, 0.0, opens, rest=draw.pick([0.0, opens], [3, 1]))
    return Link("board", [node], seat, motion)
