"""Boxes with press buttons, throw levers or side levers, and hand presses with a ram."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import dial
from kinmo.synth.details.posture import turn_about_up
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    Z,
    box,
    box_between,
    cylinder,
    dome,
    ellipsoid,
    extrude,
    join,
    lathe,
    move,
    rotation_about,
    rounded_box,
    rounded_path,
    sweep,
    torus,
    tube,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Box or machine that is worked by hand.

    Variants: one large button, a panel with one to six buttons, levers that tip in slots, a lever at the side that turns or
    slides down, and a press whose ram goes down under a lever. Buttons slide into their box.
    """
    root = Node("switch")
    style = draw.pick([_large_button, _panel, _levers, _side_lever, _press], [3, 4, 3, 3, 3])
    links = style(draw, root)
    shape = SynthObject("Switch", root, links)
    if style in (_large_button, _panel, _levers) and draw.chance(0.35):
        # It hangs on a wall.
        shape.move(rotation_about(X, 90.0))
    elif draw.chance(0.3):
        turn_about_up(draw, shape)
    return shape


def _base(draw: Draw, root: Node, *pieces: Mesh) -> Link:
    """Static base of a few pieces."""
    kind = draw.pick([JointType.STATIC, JointType.FREE, JointType.HEAVY])
    return Link("base_body", [root.add(draw.pick(["base_body", "body", "housing"]), *pieces)], kind=kind)


def press_button(draw: Draw, radius: float, tall: float) -> list[Mesh]:
    """Meshes of a button that is pressed along -y, with its foot on y = 0: mushroom, dome, drum, square or stepped."""
    kind = draw.pick(["mushroom", "dome", "drum", "square", "stepped"], [4, 3, 4, 2, 2])
    segments = draw.pick([12, 20, 32])
    if kind == "mushroom":
        neck, brim = draw.between(0.35, 0.7) * radius, draw.between(0.3, 0.6) * tall
        profile = [[0, 0], [neck, 0], [neck, brim], [radius, brim], [radius, 0.8 * tall], [0.7 * radius, tall], [0, tall]]
        return [lathe(np.array(profile), segments)]
    if kind == "dome":
        foot = draw.between(0.1, 0.4) * tall
        cap = dome((radius, tall - foot, radius), (0, foot, 0), "y", segments)
        return [cylinder(radius, foot, "y", (0, foot / 2, 0), segments), cap]
    if kind == "square":
        side = radius * draw.between(1.4, 1.9)
        return [
            rounded_box(
                (side, tall, side * draw.between(0.6, 1.0)), draw.between(0.0, 0.3) * side + 1e-3, "y", (0, tall / 2, 0)
            )
        ]
    if kind == "stepped":
        lower = 0.5 * tall
        upper = cylinder(0.7 * radius, lower, "y", (0, 1.5 * lower, 0), segments)
        return [cylinder(radius, lower, "y", (0, lower / 2, 0), segments), upper]
    top = radius * draw.between(0.8, 1.0)
    return [cylinder(radius, tall, "y", (0, tall / 2, 0), segments, top_radius=top)]


def _collar(draw: Draw, radius: float, at: np.ndarray) -> list[Mesh]:
    """A ring, a raised edge or a plate around a button, or nothing."""
    kind = draw.pick(["none", "ring", "wall", "plate"], [3, 3, 2, 1])
    if kind == "ring":
        return [torus(1.15 * radius, 0.1 * radius, "y", at, 24)]
    if kind == "wall":
        return [tube(1.35 * radius, 1.1 * radius, draw.between(0.2, 0.8) * radius, "y", at + (0, 0.15 * radius, 0), 24)]
    if kind == "plate":
        return [tube(1.5 * radius, 1.05 * radius, 0.08 * radius, "y", at, 24)]
    return []


def _add_button(draw: Draw, root: Node, base: Link, at: np.ndarray, radius: float, tall: float) -> Link:
    """Add a button on a surface that faces up, partly sunk into it."""
    sunk = draw.pick([0.0, draw.between(0.1, 0.4)]) * tall
    node = root.add(
        draw.pick(["button", "push_button", "switch"]), *(move(p, at - (0, sunk, 0)) for p in press_button(draw, radius, tall))
    )
    collar = _collar(draw, radius, at)
    if collar:
        base.nodes.append(root.add(draw.pick(["ring", "frame", "other_leaf"]), *collar))
    travel = (tall - sunk) * draw.between(0.2, 0.9)
    return Link("button", [node], base, slider(-Y, 0.0, travel), leaf_name="button")


def _large_button(draw: Draw, root: Node) -> list[Link]:
    """A box, drum or stand with one large button on it."""
    wide, tall, deep = draw.between(0.5, 1.0), draw.ratio(0.1, 1.0), draw.between(0.5, 1.0)
    kind = draw.pick(["box", "rounded", "drum", "cone", "stand"], [4, 2, 2, 1, 1])
    top, room = np.array([0.0, tall, 0.0]), min(wide, deep)
    if kind == "box":
        pieces = [box((wide, tall, deep), (0, tall / 2, 0))]
    elif kind == "rounded":
        pieces = [rounded_box((wide, tall, deep), 0.2 * room, "y", (0, tall / 2, 0))]
    elif kind == "stand":
        pieces = [cylinder(0.4 * room, 0.05, "y", (0, 0.025, 0)), cylinder(0.08 * room, tall, "y", (0, tall / 2, 0))]
        pieces.append(cylinder(0.3 * room, 0.1, "y", (0, tall + 0.05, 0)))
        top[1] += 0.1
        room *= 0.6
    else:
        upper = 0.5 * room * (1.0 if kind == "drum" else draw.between(0.6, 0.9))
        pieces = [cylinder(0.5 * room, tall, "y", (0, tall / 2, 0), 28, top_radius=upper)]
        room = 2 * upper
    if draw.chance(0.3):
        pieces.append(box((1.2 * wide, 0.04, 1.2 * deep), (0, -0.02, 0)))
    base = _base(draw, root, *pieces)
    radius = draw.between(0.2, 0.42) * room
    links = [base, _add_button(draw, root, base, top, radius, radius * draw.ratio(0.25, 1.4))]
    if draw.chance(0.25):
        # A cover over the button folds up at the rear.
        half, rise = min(1.25 * radius, 0.49 * room), 1.5 * radius + 0.1
        wall = 0.05 * radius
        sides = [box((wall, rise, 2 * half), (s * half, top[1] + rise / 2, 0)) for s in (-1, 1)]
        cover = [
            *sides,
            box((2 * half, wall, 2 * half), (0, top[1] + rise, 0)),
            box((2 * half, rise, wall), (0, top[1] + rise / 2, half)),
        ]
        opens = draw.between(70.0, 130.0)
        motion = hinge((0, top[1] + draw.pick([0.0, rise]), -half), -X, 0.0, opens, rest=draw.between(0.4, 1.0) * opens)
        links.append(Link("cover", [root.add("cover", *cover)], base, motion))
    return links


def _panel(draw: Draw, root: Node) -> list[Link]:
    """A box or console with buttons of different heights in a row, column or grid; some have a knob or stick, too."""
    count = draw.integer(1, 6)
    columns = draw.pick([count, 1, (count + 1) // 2], [4, 1, 2])
    rows = -(-count // columns)
    cell = draw.between(0.25, 0.4)
    wide, deep = cell * (columns + draw.between(0.1, 1.0)), cell * (rows + draw.between(0.1, 1.0))
    tall = draw.ratio(0.08, 0.6)
    base = _base(draw, root, box_between((-wide / 2, -tall, -deep / 2), (wide / 2, 0, deep / 2)))
    links, same = [base], draw.chance(0.5)
    sources = draw.identical(count) if same else [draw] * count
    for index, own in enumerate(sources):
        column, row = index % columns, index // columns
        at = np.array([cell * (column + 0.5 - columns / 2), 0.0, cell * (row + 0.5 - rows / 2)])
        radius = own.between(0.2, 0.42) * cell
        height = radius * (own.ratio(0.2, 1.0) if same else draw.ratio(0.2, 2.0))
        if count > 1 and index == 0 and draw.chance(0.2):
            knob = [turn(piece, X, -90.0) for piece in dial(draw, radius, 0.7 * radius, (0, 0, 0))]
            node = root.add("knob", *(move(piece, at) for piece in knob))
            links.append(Link("knob", [node], base, spinner(at, Y)))
        elif count > 1 and index == 0 and draw.chance(0.15):
            stick = cylinder(0.2 * radius, 3 * radius, "y", at + (0, 1.5 * radius, 0), 10)
            ball = ellipsoid(np.full(3, 0.55 * radius), at + (0, 3 * radius, 0), 14, 8)
            node = root.add("joystick", stick, ball)
            swing = draw.between(15.0, 35.0)
            links.append(Link("lever", [node], base, hinge(at, draw.pick([X, Z]), -swing, swing)))
        else:
            links.append(_add_button(own, root, base, at, radius, height))
    if draw.chance(0.35):
        base.nodes.append(root.add("label", box((0.5 * wide, 0.01, 0.1 * deep), (0, 0.005, -0.46 * deep))))
    # A console slopes towards the front.
    if draw.chance(0.35):
        tilt = draw.between(10.0, 40.0)
        for link in links:
            link.move(rotation_about(X, tilt))
        base.nodes.append(root.add("stand", box((wide, tall, 0.7 * deep), (0, -1.4 * tall, -0.15 * deep))))
    return links


def _grip(draw: Draw, length: float, rod: float) -> list[Mesh]:
    """Meshes of a lever along +y from the origin, with a ball, a sleeve, a cross bar or a paddle at its end."""
    kind = draw.pick(["ball", "sleeve", "tee", "paddle"], [4, 3, 2, 2])
    arm = cylinder(rod, length, "y", (0, length / 2, 0), draw.pick([8, 12, 16]), top_radius=rod * draw.between(0.6, 1.0))
    if draw.chance(0.3):
        arm = box((2 * rod, length, draw.between(0.8, 2.0) * rod), (0, length / 2, 0))
    if kind == "ball":
        return [arm, ellipsoid(np.full(3, rod * draw.between(1.8, 3.0)), (0, length, 0), 16, 10)]
    if kind == "sleeve":
        return [arm, cylinder(1.6 * rod, 0.4 * length, "y", (0, 0.85 * length, 0), 14)]
    if kind == "tee":
        return [arm, cylinder(1.2 * rod, 0.5 * length, draw.pick(["x", "z"]), (0, length, 0), 12)]
    return [arm, box((5 * rod, 0.35 * length, 1.5 * rod), (0, 0.9 * length, 0))]


def _levers(draw: Draw, root: Node) -> list[Link]:
    """One to four levers that tip forward and back in slots of a box or on brackets."""
    count, cell = draw.pick([1, 2, 3, 4], [5, 2, 2, 1]), draw.between(0.25, 0.5)
    wide, tall, deep = cell * count * draw.between(1.0, 1.6), draw.ratio(0.05, 0.5), draw.between(0.3, 0.9)
    base = _base(draw, root, box_between((-wide / 2, -tall, -deep / 2), (wide / 2, 0, deep / 2)))
    links = [base]
    for own, index in zip(draw.identical(count), range(count), strict=True):
        length, rod = own.between(0.3, 0.8), own.ratio(0.012, 0.05)
        lift = own.pick([0.0, own.between(0.03, 0.12)])
        at = np.array([cell * (index + 0.5 - count / 2), lift, 0.0])
        pieces = [move(piece, at) for piece in _grip(own, length, rod)]
        if own.chance(0.6):
            pieces.append(cylinder(2.2 * rod, 3 * rod, "x", at, 16))
        node = root.add(own.pick(["lever", "handle", "switch"]), *pieces)
        if lift:
            plates = [box((rod, lift + 2 * rod, 5 * rod), at + (s * 2.5 * rod, -lift / 2, 0)) for s in (-1, 1)]
            base.nodes.append(root.add("bracket", *plates))
        elif own.chance(0.6):
            slot = [box((rod, 0.02, 0.6 * deep), at + (s * 2.5 * rod, 0.01, 0)) for s in (-1, 1)]
            base.nodes.append(root.add(own.pick(["frame", "slot"]), *slot))
        swing = own.between(20.0, 60.0)
        rest = draw.pick([0.0, draw.sign() * swing, draw.between(-1.0, 1.0) * swing], [1, 3, 1])
        links.append(Link("lever", [node], base, hinge(at, X, -swing, swing, rest=rest)))
    return links


def _side_lever(draw: Draw, root: Node) -> list[Link]:
    """A body with a lever at its side that turns down about the side's normal, or slides down in a slot."""
    wide, tall, deep = draw.between(0.4, 0.9), draw.between(0.5, 1.2), draw.between(0.3, 0.8)
    form = draw.pick(["box", "rounded", "sloped"], [3, 2, 2])
    if form == "sloped":
        outline = np.array([(0, -deep / 2), (tall, -deep / 2), (tall, 0.0), (0.4 * tall, deep / 2), (0, deep / 2)])
        body = extrude(outline[::-1], wide, "x")
    else:
        body = (
            box((wide, tall, deep), (0, tall / 2, 0))
            if form == "box"
            else rounded_box((wide, tall, deep), 0.15 * deep, "x", (0, tall / 2, 0))
        )
    base = _base(draw, root, body)
    if draw.chance(0.5):
        base.nodes.append(
            root.add("screen", box((0.7 * wide, 0.25 * tall, 0.02), (0, 0.8 * tall, (0.01 if form == "sloped" else deep / 2))))
        )
    sign = draw.sign()
    links = [base]
    x, rod = sign * wide / 2, draw.ratio(0.015, 0.045)
    if draw.chance(0.5):
        at = np.array([x + sign * 2 * rod, draw.between(0.3, 0.6) * tall, draw.between(-0.2, 0.2) * deep])
        length = draw.between(0.3, 0.7) * tall
        pieces = [move(piece, at) for piece in _grip(draw, length, rod)]
        pieces.append(cylinder(2.5 * rod, 4 * rod, "x", at, 16))
        if draw.chance(0.4):
            base.nodes.append(root.add("plate", cylinder(4 * rod, 0.5 * rod, "x", (x, at[1], at[2]), 20)))
        swing = draw.between(45.0, 110.0)
        back = draw.pick([0.0, draw.between(0.0, 30.0)])
        motion = hinge(at, X, -back, swing, rest=draw.pick([0.0, draw.between(0.0, 1.0) * swing], [3, 1]))
        name = root.add(draw.pick(["lever", "handle", "crank"]), *pieces)
        links.append(Link("lever", [name], base, motion))
    else:
        travel = draw.between(0.3, 0.6) * tall
        at = np.array([x, draw.between(0.65, 0.9) * tall, draw.between(-0.2, 0.2) * deep])
        reach = draw.between(2.0, 6.0) * rod
        paddle = draw.pick(
            [
                box((reach, 2 * rod, 4 * rod), at + (sign * reach / 2, 0, 0)),
                join(
                    cylinder(0.6 * rod, reach, "x", at + (sign * reach / 2, 0, 0), 10),
                    ellipsoid((2 * rod, 1.2 * rod, 2 * rod), at + (sign * reach, 0, 0), 14, 8),
                ),
            ]
        )
        if draw.chance(0.7):
            for side in (-1, 1):
                rail = box((rod, travel + 0.1 * tall, 0.6 * rod), at + (0, -travel / 2, side * 2.6 * rod))
                base.nodes.append(root.add(draw.pick(["slot", "rail"]), rail))
        node = root.add(draw.pick(["lever", "slider", "button"]), paddle)
        links.append(Link("slider", [node], base, slider(-Y, 0.0, travel), leaf_name="lever"))
    if draw.chance(0.3):
        radius = draw.between(0.04, 0.1)
        button = [turn(piece, X, 90.0) for piece in press_button(draw, radius, radius)]
        at = np.array([0.0, 0.25 * tall, deep / 2])
        links.append(Link("button", [root.add("button", *(move(p, at) for p in button))], base, slider(-Z, 0.0, 0.6 * radius)))
    return links


def _press(draw: Draw, root: Node) -> list[Link]:
    """A press: a base, one or two columns, a head, a ram that goes down, and a lever that turns at the head."""
    wide, deep, tall = draw.between(0.4, 0.7), draw.between(0.5, 0.9), draw.between(0.7, 1.4)
    thick = draw.ratio(0.04, 0.12)
    foot = box_between((-wide / 2, 0, -deep / 2), (wide / 2, thick, deep / 2))
    twin = draw.chance(0.35)
    post = draw.ratio(0.03, 0.08)
    if twin:
        columns = [cylinder(post, tall, "y", (s * 0.4 * wide, tall / 2, 0), 14) for s in (-1, 1)]
        head = box((wide, 2 * thick, 3 * post), (0, tall, 0))
    else:
        columns = [box((2 * post, tall, 3 * post), (0, tall / 2, -0.35 * deep))]
        head = box((3 * post, 2 * thick, 0.6 * deep), (0, tall, -0.1 * deep))
    base = _base(draw, root, foot, *columns, head)
    links = [base]
    low, radius = draw.between(0.35, 0.6) * tall, draw.ratio(0.02, 0.06)
    ram = [cylinder(radius, tall + 0.3 - low, "y", (0, 0.5 * (tall + 0.3 + low), 0), 14)]
    if draw.chance(0.7):
        ram.append(cylinder(radius * draw.between(1.5, 4.0), thick, "y", (0, low, 0), 18))
    if draw.chance(0.5):
        cup = tube(0.15 * wide, 0.12 * wide, 0.12, "y", (0, thick + 0.06, 0), 20)
        base.nodes.append(root.add(draw.pick(["container", "cup", "tray"]), cup))
    travel = (low - thick - 0.15) * draw.between(0.5, 1.0)
    rest = draw.pick([0.0, draw.between(0.2, 1.0) * travel], [4, 1])
    ram_link = Link("press", [root.add(draw.pick(["press", "ram", "piston"]), *ram)], base, slider(-Y, 0.0, travel, rest=rest))
    links.append(ram_link)
    kind = draw.pick(["side", "front", "top", "none"], [3, 3, 1, 1])
    rod, length = draw.ratio(0.012, 0.03), draw.between(0.4, 0.9)
    if kind == "top":
        # The knob on the ram is part of it.
        ram_link.nodes[0].pieces.append(ellipsoid((4 * rod, 3 * rod, 4 * rod), (0, tall + 0.3, 0), 16, 8))
    elif kind == "side":
        half = (1.5 * post if not twin else wide / 2) + 2 * rod
        at = np.array([draw.sign() * half, tall, 0.0])
        pieces = [turn(piece, X, draw.between(0.0, 60.0)) for piece in _grip(draw, length, rod)]
        pieces.append(cylinder(3 * rod, 4 * rod, "x", (0, 0, 0), 16))
        node = root.add(draw.pick(["lever", "handle"]), *(move(piece, at) for piece in pieces))
        links.append(Link("lever", [node], base, hinge(at, X, 0.0, draw.between(60.0, 120.0))))
    elif kind == "front":
        at = np.array([0.0, tall + thick + rod, -0.35 * deep])
        path = rounded_path(
            np.array([(0, 0, 0), (0, 0.2 * length, 0.6 * length), (0, 0.2 * length, 1.3 * length)]), 0.2 * length
        )
        sides = (-2 * post, 2 * post) if draw.chance(0.5) else (radius + 1.5 * rod,)
        pieces = [move(sweep(path, rod, 8), at + (x, 0, 0)) for x in sides]
        end = at + path[-1]
        pieces.append(cylinder(1.5 * rod, 5 * post, "x", end, 12))
        node = root.add(draw.pick(["lever", "handle"]), *pieces)
        links.append(Link("lever", [node], base, hinge(at, X, 0.0, draw.between(20.0, 45.0), rest=0.0)))
    return links
