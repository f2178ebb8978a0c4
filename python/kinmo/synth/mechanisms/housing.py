"""Housings: upright boxes whose front is divided into openings, each with a door, flap, drawer, shelf or pane."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms.fronts import FRONTS, INTERIORS, door, flap
from kinmo.synth.mechanisms.linked import caster
from kinmo.synth.mechanisms.mount import mount
from kinmo.synth.mechanisms.sliding import keys, pusher, slot
from kinmo.synth.mechanisms.turning import knob
from kinmo.synth.primitives import X, Y, Z, box, cylinder, facing
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, spinner

MIN_OPENING_SIDE = 0.25
"""Smallest side of an opening that is divided further."""
SAME_HINGE_CHANCE = 0.7
"""Chance that a hinged closure has its hinge like the others of the housing: at a side, or below."""
INTERIOR_CHANCE = 0.5
"""Chance of another moving part behind a door or flap."""


@dataclass(frozen=True)
class _Opening:
    """A rectangle of the front: its centre (x, y), width and height."""

    x: float
    y: float
    wide: float
    high: float

    def divided(self, draw: Draw) -> tuple[_Opening, _Opening]:
        """The opening cut in two, across its longer side more often."""
        share = draw.pick([0.5, draw.between(0.25, 0.75)])
        if draw.chance(0.5 if self.wide < 1.3 * self.high else 0.8) == (self.wide > self.high):
            left, right = share * self.wide, (1 - share) * self.wide
            return (
                _Opening(self.x - 0.5 * right, self.y, left, self.high),
                _Opening(self.x + 0.5 * left, self.y, right, self.high),
            )
        low, top = share * self.high, (1 - share) * self.high
        return _Opening(self.x, self.y - 0.5 * top, self.wide, low), _Opening(self.x, self.y + 0.5 * low, self.wide, top)


def housing(draw: Draw, crowded: bool) -> SynthObject:
    """Housing, centred at the origin, with one closure per opening and, sometimes, controls. A crowded one often rolls."""
    root = Node("mechanism")
    wide, high, deep = draw.between(0.4, 1.2), draw.between(0.3, 1.8), draw.between(0.3, 0.9)
    wall = draw.between(0.01, 0.05)
    base = Link("body", [], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    hollow = _walls(draw, root, base, wide, high, deep, wall)
    links = [base]
    openings = [_Opening(0.0, 0.0, wide - 2 * wall, high - 2 * wall)]
    for _ in range(draw.pick([0, 1, 2, 3, 4], [4, 4, 2, 2, 1])):
        openings.sort(key=lambda opening: opening.wide * opening.high)
        if min(openings[-1].wide, openings[-1].high) > MIN_OPENING_SIDE:
            openings += openings.pop().divided(draw)
    alike = draw.chance(0.4)
    chosen = [draw.pick(FRONTS)] * len(openings) if alike else [draw.pick(FRONTS) for _ in openings]
    hung = draw.pick([door, flap], [3, 1])
    chosen = [hung if front in (door, flap) and draw.chance(SAME_HINGE_CHANCE) else front for front in chosen]
    draws = draw.identical(len(openings)) if alike else [draw] * len(openings)
    for opening, own, front in zip(openings, draws, chosen, strict=True):
        place = facing(Z, Y, (opening.x, opening.y, 0.5 * deep))
        if draw.chance(0.2):
            links += _controls(draw, root, base, opening, 0.5 * deep)
        else:
            if front is flap and opening.high > 1.2 * opening.wide and draw.chance(0.8):
                front = door  # a tall closure has its hinge at a side
            kinds = [front]
            if hollow and front in (door, flap) and draw.chance(INTERIOR_CHANCE):
                kinds.append(draw.pick(INTERIORS))
            for kind in kinds:
                links += mount(draw, kind(own, opening.wide, opening.high, deep - wall), 1.0, place, root, base)
    links += _feet(draw, root, base, wide, high, deep, 4.0 if crowded else 1.0)
    return SynthObject("Mechanism", root, links)


def _walls(draw: Draw, root: Node, base: Link, wide: float, high: float, deep: float, wall: float) -> bool:
    """Add the body: walls in one piece or several, or a nearly solid block. True if it is hollow."""
    if draw.chance(0.25):
        base.nodes.append(root.add("body", box((wide, high, 0.96 * deep), (0, 0, -0.02 * deep))))
        return False
    sides = [box((wall, high, deep), (s * 0.5 * (wide - wall), 0, 0)) for s in (-1, 1)]
    sides += [box((wide, wall, deep), (0, s * 0.5 * (high - wall), 0)) for s in (-1, 1)]
    back = box((wide, high, wall), (0, 0, -0.5 * (deep - wall)))
    if draw.chance(0.5):
        base.nodes.append(root.add("body", *sides, back))
    else:
        group = root.add("frame")
        base.nodes += [group.add(draw.pick(["side", "board", "panel"]), side) for side in sides] + [group.add("back", back)]
    return True


def _controls(draw: Draw, root: Node, base: Link, opening: _Opening, front: float) -> list[Link]:
    """Panel with keys, a button, a knob or a slide, instead of a closure."""
    panel = box((opening.wide, opening.high, 0.04), (opening.x, opening.y, front - 0.02))
    base.nodes.append(root.add("panel", panel))
    mechanism = draw.pick([keys, knob, pusher, slot])(draw)
    size = draw.between(0.2, 0.9) * min(opening.wide, opening.high)
    return mount(draw, mechanism, size, facing(Z, Y, (opening.x, opening.y, front)), root, base)


def _feet(draw: Draw, root: Node, base: Link, wide: float, high: float, deep: float, rolling: float) -> list[Link]:
    """Nothing, legs, casters or wheels at the corners. Casters have the weight `rolling`, against 12 for nothing."""
    kind = draw.pick(["none", "legs", "casters", "wheels"], [12, 6, rolling, 0.5 * rolling])
    links: list[Link] = []
    if kind == "none":
        return links
    size = draw.between(0.1, 0.3) * min(wide, deep)
    for x, z, own in zip((-1, 1, -1, 1), (-1, -1, 1, 1), draw.identical(4), strict=True):
        at = (x * (0.5 * wide - 0.5 * size), -0.5 * high, z * (0.5 * deep - 0.5 * size))
        if kind == "legs":
            length = 2.0 * size
            base.nodes.append(root.add("leg", cylinder(0.15 * size, length, "y", (at[0], at[1] - 0.5 * length, at[2]), 10)))
        elif kind == "wheels":
            axle = (at[0], at[1] - 0.3 * size, at[2])
            wheel = cylinder(0.5 * size, 0.3 * size, "x", axle, 20)
            links.append(Link("wheel", [root.add("wheel", wheel)], base, spinner(axle, X)))
        else:
            links += mount(draw, caster(own), 1.2 * size, facing(-Y, Z, at), root, base)
    return links
