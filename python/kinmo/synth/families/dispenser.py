"""Soap and drink dispensers with pump heads, taps, lids and push plates."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.turning_handles import turning_handle
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, along, box, box_between, cylinder, lathe, move, rounded_box, rounded_path, sweep, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, screw, slider


def build(draw: Draw) -> SynthObject:
    """Dispenser.

    Variants: a pump bottle, a wall box, and a drink tank. The head of a pump slides or screws down, and its collar may screw.
    The plate of a wall box slides or tips, and its cover folds up. The tap of a tank turns, and its lid lifts off or screws.
    """
    root = Node("dispenser")
    body = root.add("body")
    base = Link("body", [body], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    kind = draw.pick([_pump, _wall_box, _tank], [5, 3, 2])
    return SynthObject("Dispenser", root, [base, *kind(draw, root, body, base)])


def _pump(draw: Draw, root: Node, body: Node, base: Link) -> list[Link]:
    """A container with a pump head that slides or screws down, and a collar that may screw."""
    radius, height = draw.between(0.25, 0.45), draw.between(0.6, 1.3)
    neck = radius * draw.between(0.3, 0.6)
    if draw.chance(0.35):
        body.pieces.append(rounded_box((2 * radius, height, 1.6 * radius), 0.4 * radius, "y", (0, 0.5 * height, 0)))
    else:
        waist, shoulder = draw.between(0.85, 1.1), draw.between(0.75, 0.95)
        profile = [
            [0, 0],
            [radius, 0],
            [waist * radius, 0.5 * height],
            [radius, shoulder * height],
            [neck, height],
            [0, height],
        ]
        body.pieces.append(lathe(np.array(profile), draw.pick([16, 24, 32])))
    collar_height, travel = draw.between(0.06, 0.15), draw.between(0.08, 0.2)
    collar = cylinder(1.1 * neck, collar_height, "y", (0, height + 0.5 * collar_height, 0), 20)
    top = height + collar_height + travel
    reach = draw.between(0.25, 0.5)
    nozzle = sweep(rounded_path(np.array([(0, top, 0), (0, top + 0.03, 0.7 * reach), (0, top - 0.06, reach)]), 0.15), 0.03, 10)
    head = [cylinder(0.03, 2 * travel, "y", (0, top - 0.9 * travel, 0), 12), nozzle]
    cap = draw.pick([cylinder(0.8 * neck, 0.08, "y", (0, top, 0), 20), box((1.2 * neck, 0.08, 1.6 * neck), (0, top, 0))])
    head.append(cap)
    head = [turn(piece, Y, draw.pick([0.0, 90.0, draw.between(0.0, 360.0)], [4, 1, 1])) for piece in [*head]]
    links: list[Link] = []
    holder = base
    if draw.chance(0.4):
        holder = Link("lid", [root.add("lid", collar)], base, screw((0, height, 0), Y, 0.0, collar_height, turns=None))
        links.append(holder)
    else:
        body.pieces.append(collar)
    press = draw.between(0.5, 1.0) * travel
    motion = draw.pick(
        [slider(Y, -press, 0.0), slider((0, -1, 0), 0.0, press), screw((0, 0, 0), Y, -press, 0.0, turns=None)], [3, 1, 1]
    )
    links.append(Link(draw.pick(["head", "press"]), [root.add(draw.pick(["head", "pump"]), *head)], holder, motion))
    return links


def _wall_box(draw: Draw, root: Node, body: Node, base: Link) -> list[Link]:
    """A box on the wall with a push plate and a cover that folds up."""
    width, height, depth = draw.between(0.4, 0.7), draw.between(0.7, 1.1), draw.between(0.3, 0.5)
    body.pieces.append(rounded_box((width, height, depth), draw.between(0.01, 0.1), "y"))
    body.pieces.append(cylinder(0.05, 0.08, "y", (0, -0.5 * height - 0.04, 0.3 * depth), 14))
    front, links = 0.5 * depth, []
    plate_height = height * draw.between(0.2, 0.45)
    y = -0.5 * height + 0.6 * plate_height
    thick = draw.between(0.03, 0.08)
    plate = rounded_box((0.8 * width, plate_height, thick), 0.05, "z", (0, y, front + 0.5 * thick))
    if draw.chance(0.5):
        motion = slider((0, 0, 1), -draw.between(0.3, 0.9) * thick, 0.0)
    else:
        motion = hinge((0, y + 0.5 * plate_height, front + draw.pick([0.0, 0.5 * thick])), X, 0.0, draw.between(5.0, 15.0))
    links.append(Link("button", [root.add("button", plate)], base, motion))
    if draw.chance(0.6):
        lid = rounded_box((width, 0.04, depth), 0.02, "y", (0, 0.5 * height + 0.02, 0))
        opening = draw.between(70.0, 110.0)
        rest = -draw.between(20.0, opening) if draw.chance(0.25) else 0.0
        axis = hinge((0, 0.5 * height + draw.pick([0.0, 0.02]), -front), X, -opening, 0.0, rest=rest)
        links.append(Link("lid", [root.add("lid", lid)], base, axis))
    return links


def _tank(draw: Draw, root: Node, body: Node, base: Link) -> list[Link]:
    """A drink tank on legs with a tap low at the front and a lid that lifts off or screws."""
    radius, height, legs = draw.between(0.3, 0.45), draw.between(0.6, 0.9), draw.between(0.2, 0.5)
    body.pieces.append(cylinder(radius, height, "y", (0, legs + 0.5 * height, 0), 28))
    places = [(s * 0.6 * radius, t * 0.6 * radius) for s in (-1, 1) for t in (-1, 1)]
    body.pieces += [box_between((x - 0.03, 0, z - 0.03), (x + 0.03, legs, z + 0.03)) for x, z in places]
    y, reach = legs + 0.1 * height, draw.between(0.12, 0.25)
    body.pieces.append(cylinder(0.04, reach + 0.05, "z", (0, y, radius + 0.5 * reach), 12))
    body.pieces.append(cylinder(0.04, 0.15, "y", (0, y - 0.05, radius + reach), 12))
    grip = turning_handle(draw, draw.between(0.08, 0.16), draw.between(0.04, 0.08))
    at: tuple[float, float, float] = (0, y + 0.025, radius + reach)
    if draw.chance(0.5):
        motion = hinge(at, Y, -90.0, 90.0)
        pieces = [move(piece, at) for piece in grip]
    else:
        at = (0, y, radius + reach + 0.03)
        motion = hinge(at, (0, 0, 1), -90.0, 0.0)
        pieces = [move(along(piece, "z"), at) for piece in grip]
    lid = [cylinder(1.03 * radius, 0.05, "y", (0, legs + height + 0.025, 0), 28)]
    lid.append(cylinder(0.2 * radius, 0.08, "y", (0, legs + height + 0.09, 0), 16))
    rise = screw((0, 0, 0), Y, 0.0, 0.1, turns=360.0) if draw.chance(0.4) else slider(Y, 0.0, draw.between(0.05, 0.3))
    lid_link = Link("lid", [root.add("lid", *lid)], base, rise)
    return [Link("lever", [root.add("lever", *pieces)], base, motion), lid_link]
