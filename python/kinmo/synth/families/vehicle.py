"""Cars, vans, pick-ups, lorries and golf carts with wheels, doors, bonnets, boots, tailgates and steering wheels."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.appliances import frame_bars
from kinmo.synth.details.handles import pull
from kinmo.synth.details.turning_handles import wheel
from kinmo.synth.details.wheels import wheel_pieces
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
    join,
    move,
    rotation,
    sheet,
    transform,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Motion, Node, SynthObject, hinge, slider, spinner


def build(draw: Draw) -> SynthObject:
    """Vehicle on four or more wheels, with its front towards +z.

    Variants: a car with a boot or a hatch, a van, a pick-up, a lorry whose bed may tip, and an open cart with a roof. Wheels
    roll, some steer about a vertical pin. Steering wheels turn. Doors are hinged at an upright edge or slide, bonnets and
    lids fold up, and tailgates fold down.
    """
    kind = draw.pick(["saloon", "hatchback", "van", "pickup", "lorry", "open"], [3, 3, 2, 3, 1.5, 2])
    return _Vehicle(draw, kind).build()


@dataclass(eq=False)
class _Vehicle:
    """A vehicle under construction. Heights are those of its floor, belt line and roof; positions along z divide it."""

    draw: Draw
    kind: str
    root: Node = field(default_factory=lambda: Node("vehicle"))
    links: list[Link] = field(default_factory=list)

    def __post_init__(self) -> None:
        draw = self.draw
        self.length, self.half = draw.between(2.6, 4.6), draw.between(0.6, 1.0)
        self.radius = draw.ratio(0.22, 0.42)
        self.thick = self.radius * draw.ratio(0.3, 0.8)
        self.sheet = draw.ratio(0.015, 0.06)
        self.floor = self.radius * draw.between(0.8, 1.3)
        self.belt = 2.2 * self.radius + draw.between(0.15, 0.4)
        self.roof = self.belt + draw.between(0.35, 0.8)
        front, end = self.length / 2, -self.length / 2
        nose = {"van": 0.12, "lorry": 0.1, "open": 0.2}.get(self.kind, draw.between(0.2, 0.32))
        tail = {"saloon": 0.22, "hatchback": 0.05, "van": 0.0, "pickup": 0.42, "lorry": 0.6, "open": 0.15}[self.kind]
        self.front, self.rear = front, end
        self.nose = front - nose * self.length
        self.tail = end + tail * self.length * draw.between(0.85, 1.15)
        self.base = Link("body", [], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
        self.links.append(self.base)

    def build(self) -> SynthObject:
        """Add all parts."""
        draw = self.draw
        self._floor()
        if self.kind == "open":
            self._open_body()
        else:
            self._nose_and_bonnet()
            self._cabin()
            tails = {"saloon": self._boot, "hatchback": self._hatch, "van": self._van_rear}
            tails.get(self.kind, self._load_bed)()
        self._wheels()
        if draw.chance(0.85):
            self._steering_wheel()
        self._seats()
        self._trim()
        return SynthObject("vehicle", self.root, self.links)

    def _fix(self, name: str, *pieces: Mesh) -> Node:
        """Add a leaf of the body."""
        node = self.root.add(name, *pieces)
        self.base.nodes.append(node)
        return node

    def _move(self, name: str, pieces: list[Mesh], motion: Motion, parent: Link | None = None) -> Link:
        """Add a part with a joint."""
        link = Link(name, [self.root.add(name, *pieces)], parent or self.base, motion)
        self.links.append(link)
        return link

    def _rest(self, opens: float) -> float:
        """A joint value to be shown: mostly closed."""
        return self.draw.pick([0.0, self.draw.between(0.2, 1.0) * opens], [5, 1])

    def _floor(self) -> None:
        """The floor between the wheels, and the side beams below the doors."""
        inner = self.half - 1.3 * self.thick
        low, high = self.floor - self.sheet, self.floor + self.sheet
        pieces = [box_between((-inner, low, self.rear), (inner, high, self.front))]
        between = (self.rear + 2.6 * self.radius, self.front - 2.6 * self.radius)
        pieces.append(box_between((-self.half, low, between[0]), (self.half, high, between[1])))
        self._fix("chassis", *pieces)

    def _wheels(self) -> None:
        """Wheels on two or three axles; the front ones sometimes steer."""
        draw, x = self.draw, self.half - 0.5 * self.thick
        axles = [self.front - 1.3 * self.radius, self.rear + 1.3 * self.radius]
        if self.kind == "lorry" and draw.chance(0.4):
            axles.append(axles[1] + 2.3 * self.radius)
        steers, rod = draw.chance(0.2), 0.12 * self.radius
        for index, z in enumerate(axles):
            if draw.chance(0.6):
                self._fix("axle", cylinder(rod, 2 * x, "x", (0, self.radius, z), 10))
            for own, side in zip(draw.identical(2), (-1.0, 1.0), strict=True):
                at = np.array([side * x, self.radius, z])
                carrier = None
                if steers and index == 0:
                    pin = np.array([side * (x - 0.9 * self.thick), self.radius, z])
                    knuckle = [cylinder(rod, self.radius, "y", pin, 10), cylinder(rod, self.thick, "x", (pin + at) / 2, 10)]
                    carrier = self._move("steering", knuckle, hinge(pin, Y, -35.0, 35.0))
                pieces = [move(piece, at) for piece in wheel_pieces(own, self.radius, self.thick)]
                self._move("wheel", pieces, spinner(at, X), carrier)

    def _nose_and_bonnet(self) -> None:
        """The engine compartment with its wings and a bonnet hinged at its rear or front edge, or a closed nose."""
        draw, x, t = self.draw, self.half, self.sheet
        top, low = self.belt - t, 2.15 * self.radius
        wings = [box_between((s * x - t, low, self.nose), (s * x + t, top, self.front)) for s in (-0.97, 0.97)]
        grille = box_between((-x, self.floor, self.front - 2 * t), (x, top, self.front))
        wall = box_between((-0.95 * x, self.floor, self.nose - t), (0.95 * x, self.belt, self.nose + t))
        self._fix("body", *wings, grille, wall)
        if self.front - self.nose < 0.5:
            self._fix("panel", box_between((-x, top, self.nose), (x, self.belt, self.front)))
            return
        if draw.chance(0.6):
            engine = box((x, 0.6 * (top - self.floor), 0.6 * (self.front - self.nose)))
            self._fix("engine", move(engine, (0, self.floor + 0.3 * (top - self.floor), (self.nose + self.front) / 2)))
        lid = box_between((-x, top, self.nose), (x, self.belt, self.front))
        if draw.chance(0.4):
            lip = self.belt - top
            outline = np.array([(top, self.nose), (self.belt, self.nose), (self.belt, self.front - 0.1), (top, self.front)])
            lid = extrude(outline if lip < 0 else outline[::-1], 2 * x, "x")
        opens = draw.between(40.0, 85.0)
        if draw.chance(0.8):
            motion = hinge((0, top, self.nose), -X, 0.0, opens, rest=self._rest(opens))
        else:
            motion = hinge((0, top, self.front), X, 0.0, opens, rest=self._rest(opens))
        self._move(draw.pick(["hood", "bonnet", "lid"]), [lid], motion)

    def _cabin(self) -> None:
        """Pillars, roof, windscreen and doors."""
        draw, x, t = self.draw, self.half, self.sheet
        post = draw.between(1.2, 2.5) * t
        long = self.nose - self.tail
        rows = 1 if self.kind in ("pickup", "lorry", "van") or long < 1.2 else draw.pick([1, 2], [2, 3])
        end = self.nose - min(long, 1.1) if self.kind in ("van",) else self.tail
        cuts = np.linspace(self.nose, end, rows + 1)
        raked = draw.pick([0.0, draw.between(0.1, 0.35)])
        roof_front = self.nose - raked
        pillars = [
            box_between((s * x - t, self.floor, z - post), (s * x + t, self.roof, z)) for s in (-0.97, 0.97) for z in cuts[1:]
        ]
        for s in (-0.97, 0.97):
            path = [
                (self.belt, self.nose - post),
                (self.belt, self.nose),
                (self.roof, roof_front),
                (self.roof, roof_front - post),
            ]
            pillars.append(extrude(np.array(path), 2 * t, "x", (s * x, 0, 0)))
        top = box_between((-x, self.roof, self.tail), (x, self.roof + 2 * t, roof_front))
        self._fix(draw.pick(["frame", "body"]), *([join(*pillars, top)] if draw.chance(0.4) else [*pillars, top]))
        self._windscreen(roof_front)
        for row, (start, stop) in enumerate(pairwise(cuts.tolist())):
            for own, side in zip(draw.identical(2), (-1.0, 1.0), strict=True):
                self._door(own, side, start - 0.3 * post, stop + 0.3 * post, raked if row == 0 else 0.0)
        if self.kind == "van":
            self._van_sides(float(cuts[-1]))
        if self.kind in ("pickup", "lorry", "saloon"):
            back = [box_between((-x, self.floor, self.tail), (x, self.belt, self.tail + 2 * t))]
            if draw.chance(0.6):
                back.append(sheet((1.8 * x, self.roof - self.belt), (0, (self.roof + self.belt) / 2, self.tail + t), "z"))
            self._fix("body", *back)

    def _windscreen(self, roof_front: float) -> None:
        """A pane between the belt line and the roof."""
        if self.draw.chance(0.2):
            return
        rise, back = self.roof - self.belt, self.nose - roof_front
        pane = box((1.85 * self.half, float(np.hypot(rise, back)), 0.3 * self.sheet))
        pane = turn(pane, X, -np.degrees(np.arctan2(back, rise)))
        self._fix("glass", move(pane, (0, (self.roof + self.belt) / 2, (self.nose + roof_front) / 2)))

    def _door(self, draw: Draw, side: float, start: float, stop: float, raked: float) -> None:
        """A side door between two positions along z, hinged at its front edge, or rarely its rear edge."""
        t, long = self.sheet, start - stop
        low, outside = self.floor + t, draw.pick([0.0, 0.5 * t])
        at = side * (self.half + outside)
        pieces = [box_between((at - t, low, stop), (at + t, self.belt, start))]
        kind = draw.pick(["framed", "pane", "half"], [4, 2, 2])
        near = start - 0.7 * raked
        if kind == "framed" and near - stop > 0.3:
            bars = frame_bars((stop, self.belt, -0.5 * t), (near, self.roof, 0.5 * t), 1.5 * t)
            bars = [transform(bar, facing(-X, Y, (at, 0, 0))) for bar in bars]
            pieces += bars
        if kind != "half" and near - stop > 0.3:
            pane = (0.2 * t, self.roof - self.belt - t, near - stop - t)
            pieces.append(box(pane, (at, (self.roof + self.belt) / 2, (near + stop) / 2)))
        if draw.chance(0.7):
            grip = pull(draw, 0.15 * long, (0, 0, 0), vertical=False, room=0.2)
            place = (at + side * t, self.belt - 0.12, stop + draw.between(0.1, 0.2) * long)
            pieces += [transform(piece, facing(side * X, Y, place)) for piece in grip]
        opens = draw.pick([60.0, 70.0, 90.0])
        rest = self._rest(opens)
        inward = draw.between(0.0, 0.03)
        if draw.chance(0.92):
            motion = hinge((at, 0, start - inward), -side * Y, 0.0, opens, rest=rest)
        else:
            motion = hinge((at, 0, stop + inward), side * Y, 0.0, opens, rest=rest)
        self._move("door", pieces, motion)

    def _van_sides(self, start: float) -> None:
        """The sides of a van's rear; one may have a sliding door."""
        draw, t, x = self.draw, self.sheet, self.half
        low, room = 2.2 * self.radius, start - self.rear
        stop = start - min(0.5 * room, 1.0)
        slides = draw.pick([(), (1.0,), (-1.0,), (-1.0, 1.0)], [1, 3, 2, 2])
        for side in (-1.0, 1.0):
            at = 0.97 * side * x
            near = stop if side in slides else start
            self._fix("panel", box_between((at - t, low, self.rear), (at + t, self.roof, near)))
            if side not in slides:
                continue
            out = side * (x + t)
            leaf = [box_between((out - t, self.floor + t, stop), (out + t, self.roof, start))]
            if draw.chance(0.6):
                window = (2.4 * t, 0.6 * (self.roof - self.belt), 0.6 * (start - stop))
                leaf.append(box(window, (out, (self.belt + self.roof) / 2, (start + stop) / 2)))
            if draw.chance(0.6):
                grip = pull(draw, 0.2, (0, 0, 0), vertical=draw.chance(0.5), room=0.3)
                leaf += [transform(p, facing(side * X, Y, (out + side * t, self.belt, start - 0.15))) for p in grip]
            travel = (start - stop) * draw.between(0.7, 1.0)
            self._move("door", leaf, slider(-Z, 0.0, travel, rest=self._rest(travel)))
            if draw.chance(0.6):
                rail = box((t, 2 * t, 0.9 * (stop - self.rear)), (out - side * 1.5 * t, self.belt, 0.5 * (stop + self.rear)))
                self._fix("rail", rail)

    def _boot(self) -> None:
        """A boot with a lid hinged at its front edge."""
        draw, x, t = self.draw, self.half, self.sheet
        low = 2.15 * self.radius
        sides = [box_between((s * x - t, low, self.rear), (s * x + t, self.belt - t, self.tail)) for s in (-0.97, 0.97)]
        self._fix("body", *sides, box_between((-x, self.floor, self.rear), (x, self.belt - t, self.rear + 2 * t)))
        opens = draw.between(45.0, 90.0)
        lid = [box_between((-x, self.belt - t, self.rear), (x, self.belt, self.tail))]
        if draw.chance(0.4):
            lid.append(box((1.6 * x, 2 * t, 0.15), (0, self.belt + 2 * t, self.rear + 0.1)))
        motion = hinge((0, self.belt, self.tail), X, 0.0, opens, rest=self._rest(opens))
        self._move(draw.pick(["trunk", "boot", "lid"]), lid, motion)

    def _hatch(self) -> None:
        """A rear that one door closes, hinged at the roof or, rarely, at a side."""
        draw, x, t = self.draw, self.half, self.sheet
        low = draw.pick([self.floor + 2 * t, self.belt - 0.2])
        self._fix("bumper", box_between((-x, self.floor - t, self.rear), (x, low, self.rear + 3 * t)))
        sides = [
            box_between((s * x - t, 2.15 * self.radius, self.rear + t), (s * x + t, self.roof, self.tail + 0.1))
            for s in (-0.97, 0.97)
        ]
        ceiling = box_between((-x, self.roof, self.rear), (x, self.roof + 2 * t, self.tail))
        self._fix("body", *sides, ceiling)
        leaf = [box_between((-x, low, self.rear - t), (x, self.belt, self.rear + t))]
        leaf += frame_bars((-x, self.belt, self.rear - t), (x, self.roof, self.rear + t), 0.08)
        leaf.append(box((1.9 * x, self.roof - self.belt, 0.3 * t), (0, (self.roof + self.belt) / 2, self.rear)))
        opens = draw.between(60.0, 100.0)
        if draw.chance(0.85):
            motion = hinge((0, self.roof, self.rear), X, 0.0, opens, rest=self._rest(opens))
        else:
            side = draw.sign()
            motion = hinge((side * x, 0, self.rear), -side * Y, 0.0, opens, rest=self._rest(opens))
        self._move(draw.pick(["trunk", "door", "tailgate"]), leaf, motion)

    def _van_rear(self) -> None:
        """A pair of doors at the rear, or a hatch."""
        draw, x, t = self.draw, self.half, self.sheet
        if draw.chance(0.3):
            self._hatch()
            return
        opens = draw.pick([90.0, 120.0, 180.0])
        for side in (-1.0, 1.0):
            leaf = [box((x, self.roof - self.floor, 2 * t), (side * x / 2, (self.roof + self.floor) / 2, self.rear - t))]
            if draw.chance(0.5):
                leaf.append(box((0.6 * x, 0.3, 2.4 * t), (side * x / 2, 0.7 * self.roof + 0.3 * self.belt, self.rear - t)))
            hinged = hinge((side * x, 0, self.rear - 2 * t), -side * Y, 0.0, opens, rest=self._rest(opens))
            self._move("door", leaf, hinged)

    def _load_bed(self) -> None:
        """A load bed with side walls and a tailgate; it may tip, with what is on it."""
        draw, x, t = self.draw, self.half, self.sheet
        low, near = 2.25 * self.radius, self.tail - 0.05
        high = max(self.belt, low + 0.15) if self.kind == "pickup" else low + draw.between(0.15, 0.5)
        bed = [box_between((-x, low - 2 * t, self.rear), (x, low, near))]
        walls = [box_between((s * x - t, low, self.rear), (s * x + t, high, near)) for s in (-0.97, 0.97)]
        walls.append(box_between((-x, low, near - 2 * t), (x, high, near)))
        carrier = self.base
        if self.kind == "lorry" and draw.chance(0.6):
            opens = draw.between(30.0, 60.0)
            motion = hinge((0, low - 2 * t, self.rear), -X, 0.0, opens, rest=self._rest(opens))
            carrier = self._move(draw.pick(["bed", "container"]), [*bed, *walls], motion)
        else:
            self._fix("container", *bed, *walls)
        gate = [box_between((-0.95 * x, low, self.rear - t), (0.95 * x, high, self.rear + t))]
        if draw.chance(0.5):
            gate.append(box((0.3, 0.06, t), (0, high - 0.08, self.rear - 1.5 * t)))
        opens = draw.pick([90.0, 120.0, 180.0], [6, 1, 1])
        self._move("tailgate", gate, hinge((0, low, self.rear), -X, 0.0, opens, rest=self._rest(opens)), carrier)
        if self.kind == "lorry" and draw.chance(0.4):
            for side in (-1.0, 1.0):
                board = box_between((side * 1.02 * x, low, self.rear), (side * (1.02 * x + 2 * t), high, near))
                opened = hinge((side * (1.02 * x + 2 * t), low, 0), -side * Z, 0.0, 120.0)
                self._move("side", [board], opened, carrier)

    def _open_body(self) -> None:
        """A cowl, a bench and sometimes a roof on posts, with a folding windscreen or a load bed behind."""
        draw, x, t = self.draw, self.half, self.sheet
        top = self.floor + draw.between(0.4, 0.6)
        outline = np.array(
            [(self.floor, self.nose), (top, self.nose), (0.6 * (top + self.floor), self.front), (self.floor, self.front)]
        )
        self._fix("body", extrude(outline[::-1], 2 * (x - 1.3 * self.thick), "x"))
        if draw.chance(0.75):
            posts = [
                cylinder(0.025, self.roof - self.floor, "y", (s * 0.85 * x, 0.5 * (self.roof + self.floor), z), 8)
                for s in (-1, 1)
                for z in (self.nose - 0.1, self.tail)
            ]
            self._fix("frame", *posts)
            self._fix("roof", box_between((-x, self.roof, self.tail - 0.1), (x, self.roof + 2 * t, self.nose)))
        if draw.chance(0.4):
            pane = box((1.6 * x, 0.6 * (self.roof - top), 0.3 * t), (0, top + 0.3 * (self.roof - top), self.nose))
            self._move("windscreen", [pane], hinge((0, top, self.nose), X, 0.0, 90.0))
        if draw.chance(0.5):
            low = 2.25 * self.radius
            box_walls = frame_bars((-x, self.rear, 0), (x, self.tail, 0.2), 2 * t)
            bed = [box_between((-x, low - 2 * t, self.rear), (x, low, self.tail))]
            bed += [transform(wall, facing(Y, Z, (0, low, 0)) @ np.diag([-1.0, 1.0, 1.0, 1.0])) for wall in box_walls]
            self._fix("container", *bed)

    def _steering_wheel(self) -> None:
        """A steering wheel on a slanting column in front of the driver."""
        draw = self.draw
        radius, lean = draw.between(0.13, 0.22), draw.between(20.0, 70.0)
        aside = draw.pick([-0.45, 0.45, 0.0], [3, 2, 1 if self.half < 0.8 else 0]) * self.half
        at = np.array([aside, self.belt + draw.between(-0.05, 0.1), self.nose - draw.between(0.3, 0.45)])
        pieces = [turn(piece, X, -lean) for piece in wheel(draw, radius, 0.1 * radius, 0.0)]
        axis = rotation(X, -lean) @ Y
        column = turn(cylinder(0.15 * radius, 0.4, "y", (0, -0.2, 0), 10), X, -lean)
        if draw.chance(0.5):
            self._fix("column", move(column, at))
        motion = spinner(at, axis) if draw.chance(0.6) else hinge(at, axis, -180.0, 180.0)
        self._move("steering_wheel", [move(piece, at) for piece in pieces], motion)

    def _seats(self) -> None:
        """Seats with backs, one bench or two seats."""
        draw = self.draw
        if draw.chance(0.25):
            return
        z = self.nose - draw.between(0.75, 0.95)
        places = [(0.0, 0.75 * self.half)] if draw.chance(0.4) else [(s * 0.45 * self.half, 0.35 * self.half) for s in (-1, 1)]
        for x, half in places:
            cushion = box((2 * half, 0.15, 0.4), (x, self.floor + 0.3, z))
            back = turn(box((2 * half, 0.5, 0.1), (0, 0.25, 0)), X, -10.0)
            self._fix("seat", cushion, move(back, (x, self.floor + 0.3, z - 0.2)))

    def _trim(self) -> None:
        """Bumpers, lamps and mirrors."""
        draw, x = self.draw, self.half
        if draw.chance(0.6):
            for z in (self.front, self.rear):
                self._fix("bumper", box((2 * x, 0.1, 0.06), (0, self.floor + 0.05, z + np.sign(z) * 0.06)))
        if draw.chance(0.6):
            level, size = 0.5 * (self.floor + self.belt), draw.between(0.05, 0.1)
            lamp = draw.pick([cylinder(size, 0.04, "z", segments=16), box((2 * size, size, 0.04))])
            self._fix("light", *(move(lamp, (s * 0.7 * x, level, self.front + 0.02)) for s in (-1, 1)))
        if draw.chance(0.4) and self.kind != "open":
            for side in (-1.0, 1.0):
                at = (side * (x + 0.12), self.belt + 0.08, self.nose - 0.02)
                self._fix("mirror", box((0.14, 0.1, 0.04), at))
