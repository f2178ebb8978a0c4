"""Kitchens: rows of base units with a worktop, wall units, built-in appliances and tall units."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from kinmo.synth.details.appliances import add_dial, rectangular_frame
from kinmo.synth.details.casework import add_door, add_door_pair, add_drawer
from kinmo.synth.details.casework_doors import add_shutter
from kinmo.synth.details.casework_extras import add_false_front, add_larder
from kinmo.synth.details.casework_filling import bordered, furnish, on_side
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.details.handles import pull
from kinmo.synth.details.turning_handles import lever
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    X,
    Y,
    box,
    box_between,
    cylinder,
    facing,
    join,
    move,
    open_box,
    rounded_path,
    sheet,
    sweep,
    torus,
    turn,
)
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, spinner


def build(draw: Draw) -> SynthObject:
    """Row of kitchen units; sometimes with a second row at a right angle.

    Drawers, larders and racks slide forward. Doors turn about a side; ovens, dishwashers and flaps fold. Knobs and the
    tap's lever turn. Worktops, plinths, fillers, false fronts and splashbacks are fixed.
    """
    root = Node("storage_furniture")
    base = Link("cabinet_frame", [], kind=draw.pick([JointType.STATIC, JointType.HEAVY], [3, 1]))
    style = _Style(draw)
    links = _Row(draw, root, base, style, draw.ratio(1.0, 3.2)).build()
    if draw.chance(0.15):
        long = draw.ratio(0.8, 1.6)
        side = draw.sign()
        row = _Row(draw, root, Link("side", []), style, long, has_tall=False)
        # The second row starts in front of the first one's end, and its fronts face the middle.
        half = max(float(np.abs(piece.vertices[:, 0]).max()) for leaf in base.leaves() for piece in leaf.pieces)
        at = np.array([side * (half - style.depth / 2), 0.0, style.depth / 2 + style.over + long / 2 + 0.02])
        links += on_side(base, facing(-side * X, Y, at), row.build_on)
    return SynthObject("StorageFurniture", root, [base, *links])


class _Style:
    """Facts that all units of one kitchen share."""

    def __init__(self, draw: Draw) -> None:
        self.board = draw.ratio(0.012, 0.03)
        self.depth = draw.between(0.5, 0.7)
        self.height = draw.between(0.65, 0.85)
        self.plinth = draw.pick([0.0, draw.between(0.06, 0.16)], [1, 5])
        self.top = draw.ratio(0.02, 0.08)
        self.over = draw.pick([0.0, draw.between(0.01, 0.06)])
        self.fronts = Fronts.random(draw, self.board)
        if draw.chance(0.8):
            self.fronts = replace(self.fronts, has_handles=True)
        self.solid = draw.chance(0.15)
        self.names = draw.pick([("cabinet", "cabinet_frame"), ("base_unit", "body"), ("unit", "carcass")])


@dataclass(eq=False)
class _Row:
    """A row of units `width` long, centred in x, with its back at -depth / 2 and its floor at y = 0."""

    draw: Draw
    root: Node
    base: Link
    style: _Style
    width: float
    has_tall: bool = True
    links: list[Link] = field(default_factory=list)

    def build_on(self, base: Link) -> list[Link]:
        """Build the row on a link."""
        self.base = base
        return self.build()

    def build(self) -> list[Link]:
        """Add all units, and return the links that move."""
        draw = self.draw
        left, right = -self.width / 2, self.width / 2
        count = max(2, round(self.width / draw.between(0.45, 0.8)))
        shares = np.array([draw.pick([1.0, draw.between(0.5, 1.5)]) for _ in range(count)])
        edges = left + self.width * np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
        kinds = [
            draw.pick(["drawers", "door", "pair", "furnish", "larder", "open"], [4, 4, 3, 2, 1, 0.7]) for _ in range(count)
        ]
        special = ["sink", "oven", "dishwasher", "hob"]
        for index, kind in zip(draw.generator.permutation(count), special, strict=False):
            if draw.chance(0.65):
                kinds[index] = kind
        for kind, (start, end) in zip(kinds, pairwise(edges.tolist()), strict=True):
            self._base_unit(kind, start, end)
        self._worktop(left, right, [float(edges[i]) for i, kind in enumerate(kinds) if kind == "sink"], edges)
        if draw.chance(0.6):
            self._wall_units(left, right)
        if self.has_tall and draw.chance(0.6):
            for side in draw.pick([(1.0,), (-1.0,), (-1.0, 1.0)], [3, 3, 1]):
                self._tall_unit(side)
        return self.links

    @property
    def _front(self) -> float:
        return self.style.depth / 2

    def _carcass(self, low: tuple[float, float, float], high: tuple[float, float, float], *, solid: bool = False) -> Node:
        """Add a unit's carcass, hollow or solid; returns the unit's group."""
        group = self.root.add(self.style.names[0])
        shell = box_between(low, high) if solid else open_box(low, high, self.style.board)
        self.base.nodes.append(group.add(self.style.names[1], shell))
        return group

    def _base_unit(self, kind: str, start: float, end: float) -> None:
        """Add one base unit between two positions along x."""
        draw, style = self.draw, self.style
        low, high, board = style.plinth, style.plinth + style.height, style.board
        group = self._carcass((start, low, -self._front), (end, high, self._front), solid=style.solid and kind != "larder")
        opening = Opening(
            0.5 * (start + end),
            0.5 * (low + high),
            end - start - 2 * board,
            style.height - 2 * board,
            style.depth - board,
            self._front,
            border=(board,) * 4,
        )
        if kind == "drawers":
            count = draw.integer(2, 4)
            shares = np.array([draw.pick([1.0, draw.between(0.4, 1.0)]) for _ in range(count)])
            tops = opening.low + (opening.height + board) * np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
            for row, (bottom, top) in enumerate(pairwise(tops)):
                part = replace(opening, y=0.5 * (bottom + top - board), height=top - bottom - board)
                part = bordered(part, board, board, True, True, row == 0, row == count - 1)
                self.links.append(add_drawer(draw, group, self.base, part, style.fronts))
        elif kind in ("door", "pair", "sink"):
            if draw.chance(0.5) or kind == "sink":
                tall = draw.between(0.15, 0.25) * opening.height
                upper = replace(opening, y=opening.high - tall / 2, height=tall)
                upper = bordered(upper, board, board, True, True, False, True)
                opening = replace(opening, y=opening.y - (tall + board) / 2, height=opening.height - tall - board)
                opening = bordered(opening, board, board, True, True, True, False)
                if kind == "sink":
                    add_false_front(draw, group, self.base, upper, style.fronts)
                else:
                    self.links.append(add_drawer(draw, group, self.base, upper, style.fronts))
            if kind == "door" or opening.width < 0.5:
                self.links.append(add_door(draw, group, self.base, opening, style.fronts, draw.pick(["left", "right"])))
            else:
                self.links += add_door_pair(draw, group, self.base, opening, style.fronts)
        elif kind == "larder":
            self.links.append(add_larder(draw, group, self.base, opening, style.fronts))
        elif kind in ("oven", "hob"):
            self._oven(group, opening)
            self._hob(group, opening)
        elif kind == "dishwasher":
            door = add_door(draw, group, self.base, opening, replace(style.fronts, look="plain"), "bottom")
            self.links.append(door)
        elif kind == "furnish":
            self.links += furnish(draw, group, self.base, opening, style.fronts, board)
        else:
            shelf = box((opening.width, board, 0.9 * style.depth), (opening.x, opening.y, 0))
            self.base.nodes.append(group.add("shelf", shelf))

    def _oven(self, group: Node, opening: Opening) -> None:
        """A built-in oven: a door that folds down, below a panel with knobs."""
        draw, strip = self.draw, self.draw.between(0.12, 0.22) * opening.height
        thick = draw.between(0.015, 0.04)
        half, z = opening.width / 2, opening.front + thick
        top = opening.high - strip
        panel = box_between((opening.x - half, top, z - thick), (opening.x + half, opening.high, z))
        self.base.nodes.append(group.add(draw.pick(["control_panel", "panel"]), panel))
        count = draw.pick([0, 2, 3, 4, 6], [1, 2, 2, 2, 1])
        for own, index in zip(draw.identical(count), range(count), strict=True):
            at = (opening.x + 1.7 * half * ((index + 0.5) / count - 0.5), top + strip / 2, z)
            self.links += add_dial(own, group, self.base, at, min(0.3 * strip, 0.6 * half / count), "knob")
        low = opening.low + draw.pick([0.0, draw.between(0.0, 0.2)]) * opening.height
        door = group.add("door")
        rim = draw.between(0.1, 0.25) * min(2 * half, top - low)
        corners = np.array([opening.x - half, low, z - thick]), np.array([opening.x + half, top - 0.005, z])
        if draw.chance(0.6):
            door.add("door_frame", rectangular_frame(*corners, rim))
            pane = box_between(corners[0] + (rim, rim, 0.3 * thick), corners[1] - (rim, rim, 0.3 * thick))
            door.add("glass", pane)
        else:
            door.add("door_frame", box_between(*corners))
            pane_size = (2 * half - 2 * rim, top - low - 2 * rim)
            door.add("glass", sheet(pane_size, (opening.x, 0.5 * (top + low), z + 0.001), "z"))
        foot = (opening.x, top - 0.5 * rim, z)
        door.add("handle", *pull(draw, 1.6 * half, foot, vertical=False, thickness=0.02, reach=0.05, room=rim))
        motion = hinge((opening.x, low, z - thick * draw.pick([0.0, 0.5])), X, 0.0, draw.pick([90.0, 85.0]))
        if low > opening.low + 0.05 and draw.chance(0.5):
            below = replace(opening, y=0.5 * (opening.low + low), height=low - opening.low - 0.01)
            self.links.append(add_drawer(draw, group, self.base, below, replace(self.style.fronts, look="plain")))
        self.links.append(Link("door", [door], self.base, motion))

    def _hob(self, group: Node, opening: Opening) -> None:
        """Burners or plates on the worktop above an opening, with knobs at the front or none."""
        draw = self.draw
        if draw.chance(0.25):
            return
        y = self.style.plinth + self.style.height + self.style.top
        wide, deep, thin = 0.95 * opening.width, 0.8 * self.style.depth, 0.006
        self.base.nodes.append(group.add("cooktop", box((wide, thin, deep), (opening.x, y + thin / 2, 0))))
        for sx in (-0.25, 0.25):
            for sz in (-0.25, 0.25):
                radius = draw.between(0.13, 0.2) * min(wide, deep)
                at = (opening.x + sx * wide, y + thin + 0.006, sz * deep)
                burner = torus(radius, 0.006, "y", at) if draw.chance(0.4) else cylinder(radius, 0.012, "y", at, 16)
                self.base.nodes.append(group.add("burner", burner))
        if draw.chance(0.4):
            for own, share in zip(draw.identical(4), np.linspace(-0.35, 0.35, 4), strict=True):
                foot = (opening.x + share * wide, y + thin, 0.44 * deep)
                radius = own.between(0.02, 0.035) * deep
                tall = radius * own.between(0.8, 2.0)
                node = group.add("knob", cylinder(radius, tall, "y", np.add(foot, (0, tall / 2, 0)), 14))
                self.links.append(Link("knob", [node], self.base, spinner(foot, Y)))

    def _worktop(self, left: float, right: float, sinks: list[float], edges: np.ndarray) -> None:
        """The worktop in one piece or with a hole for each sink, a plinth, and sometimes a splashback."""
        draw, style = self.draw, self.style
        low, high = style.plinth + style.height, style.plinth + style.height + style.top
        rear, near = -self._front, self._front + style.over
        cuts, pieces, start = [], [], left
        for sink in sinks:
            end = float(edges[int(np.argmin(np.abs(edges - sink))) + 1])
            margin = 0.12 * (end - sink)
            cuts.append((sink + margin, end - margin))
        if draw.chance(0.3):
            cuts = []
        for hole_left, hole_right in cuts:
            pieces.append(box_between((start, low, rear), (hole_left, high, near)))
            z0, z1 = rear + 0.25 * style.depth, near - 0.15 * style.depth
            pieces += [
                box_between((hole_left, low, rear), (hole_right, high, z0)),
                box_between((hole_left, low, z1), (hole_right, high, near)),
            ]
            start = hole_right
            deep = draw.between(0.12, 0.2)
            basin = turn(open_box((hole_left, z0, -deep / 2), (hole_right, z1, deep / 2), 0.01), X, -90.0)
            # The turn maps the opening's y to -z.
            basin = move(basin, (0, high - deep / 2, z0 + z1))
            self.base.nodes.append(self.root.add("sink", basin))
            self._tap(0.5 * (hole_left + hole_right), high, rear + 0.12 * style.depth, z1)
        pieces.append(box_between((start, low, rear), (right, high, near)))
        self.base.nodes.append(self.root.add("countertop", *(pieces if draw.chance(0.5) else [join(*pieces)])))
        if style.plinth:
            back = draw.between(0.0, 0.1)
            board = box_between((left, 0.0, self._front - back - style.board), (right, style.plinth, self._front - back))
            self.base.nodes.append(self.root.add(draw.pick(["plinth", "base_side_panel", "skirting"]), board))
        if draw.chance(0.5):
            rise = draw.pick([0.06, draw.between(0.06, 0.6)])
            self.base.nodes.append(
                self.root.add("splashback", box_between((left, high, rear), (right, high + rise, rear + 0.01)))
            )
        if draw.chance(0.3):
            tray = turn(open_box((-0.2, -0.14, -0.02), (0.2, 0.14, 0.02), 0.008), X, -90.0)
            at = (draw.between(0.6, 0.9) * left, high + 0.02, 0.1 * style.depth)
            self.base.nodes.append(self.root.add("tray", move(tray, at)))

    def _tap(self, x: float, y: float, z: float, near: float) -> None:
        """A tap behind a sink: a swivelling or fixed spout, and a lever."""
        draw = self.draw
        rise, reach, rod = draw.between(0.12, 0.35), 0.6 * (near - z), draw.between(0.01, 0.018)
        path = np.array([(x, y, z), (x, y + rise, z), (x, y + rise, z + reach), (x, y + 0.7 * rise, z + reach)])
        spout = self.root.add("spout", sweep(rounded_path(path, 0.4 * reach), rod, 10))
        foot = cylinder(1.6 * rod, 2 * rod, "y", (x, y + rod, z), 14)
        self.base.nodes.append(self.root.add("faucet_base", foot))
        if draw.chance(0.5):
            self.links.append(Link("spout", [spout], self.base, spinner((x, y, z), Y)))
        else:
            self.base.nodes.append(spout)
        if draw.chance(0.7):
            side = draw.sign()
            at = np.array([x + side * 6 * rod, y, z])
            handle = [move(piece, at) for piece in lever(draw, 5 * rod, 0.5 * rod, 2 * rod)]
            handle.append(cylinder(rod, 2 * rod, "y", at + (0, rod, 0), 12))
            self.links.append(Link("switch", [self.root.add("switch", *handle)], self.base, hinge(at, Y, -60.0, 60.0)))

    def _wall_units(self, left: float, right: float) -> None:
        """Units on the wall above the worktop: doors, pairs, flaps, shutters or open shelves, beside a hood."""
        draw, style = self.draw, self.style
        low = style.plinth + style.height + style.top + draw.between(0.4, 0.6)
        tall, deep = draw.between(0.35, 0.9), style.depth * draw.between(0.45, 0.65)
        start = left + draw.pick([0.0, draw.between(0.0, 0.3) * (right - left)])
        count = max(1, round((right - start) / draw.between(0.45, 0.9)))
        edges, rear, board = np.linspace(start, right, count + 1), -self._front, style.board
        for a, b in pairwise(edges):
            kind = draw.pick(["door", "pair", "flap", "shutter", "open", "hood", "gap"], [4, 3, 2, 0.6, 1, 0.6, 0.6])
            middle, z = 0.5 * (a + b), rear + deep
            if kind == "gap":
                continue
            if kind == "hood":
                canopy = box((b - a, 0.08, deep), (middle, low + 0.04, rear + deep / 2))
                chimney = box((0.4 * (b - a), tall - 0.08, 0.6 * deep), (middle, low + 0.04 + tall / 2, rear + 0.3 * deep))
                self.base.nodes.append(self.root.add("hood", canopy, chimney))
                continue
            group = self._carcass((a, low, rear), (b, low + tall, z), solid=style.solid)
            size = (b - a - 2 * board, tall - 2 * board, deep - board)
            opening = Opening(middle, low + tall / 2, *size, z, border=(board,) * 4)
            if kind == "pair":
                self.links += add_door_pair(draw, group, self.base, opening, style.fronts)
            elif kind == "shutter":
                self.links.append(add_shutter(draw, group, self.base, opening, 0.8 * board))
            elif kind == "open":
                shelf = box((opening.width, board, 0.9 * deep), (middle, opening.y, rear + deep / 2))
                self.base.nodes.append(group.add("shelf", shelf))
            else:
                side = "top" if kind == "flap" else draw.pick(["left", "right"])
                self.links.append(add_door(draw, group, self.base, opening, style.fronts, side))
        if draw.chance(0.3):
            strip = box_between((start, low + tall, rear), (right, low + tall + 0.05, rear + deep + 0.02))
            self.base.nodes.append(self.root.add("cornice", strip))

    def _tall_unit(self, side: float) -> None:
        """A tall unit at an end of the row: a fridge with one or two doors, a larder, or doors above each other."""
        draw, style = self.draw, self.style
        wide, tall, deep = draw.between(0.4, 0.8), draw.between(1.6, 2.3), style.depth * draw.between(1.0, 1.15)
        gap = draw.pick([0.0, draw.between(0.0, 0.05)])
        inner = side * (self.width / 2 + gap)
        start, end = sorted((inner, inner + side * wide))
        front, low, board = -self._front + deep, style.plinth, style.board
        group = self._carcass((start, low, -self._front), (end, tall, front))
        opening = Opening(
            0.5 * (start + end), 0.5 * (low + tall), wide - 2 * board, tall - low - 2 * board, deep - board, front
        )
        hinge_side = draw.pick(["left", "right"])
        kind = draw.pick(["fridge", "larder", "doors"], [4, 2, 2])
        if kind == "larder":
            self.links.append(add_larder(draw, group, self.base, opening, style.fronts))
            return
        fronts = style.fronts
        if kind == "fridge":
            fronts = replace(fronts, thickness=draw.between(0.03, 0.08), gap=-board, look="plain", grips=None)
        shares = draw.pick([(1.0,), (0.3, 0.7), (0.65, 0.35), (0.33, 0.33, 0.34)], [1, 2, 2, 1])
        bottom = opening.low
        for share in shares:
            high = share * opening.height
            part = replace(opening, y=bottom + high / 2, height=high - 2.2 * max(board, 0.0))
            if kind == "fridge" and share < 0.4 and bottom == opening.low and draw.chance(0.3):
                self.links.append(add_drawer(draw, group, self.base, part, fronts))
            else:
                self.links.append(add_door(draw, group, self.base, part, fronts, hinge_side))
            bottom += high
        if draw.chance(0.3):
            at = (opening.x, opening.low - board / 2, front + 0.005)
            self.base.nodes.append(group.add("vent", box((0.8 * wide, 0.04, 0.01), at)))
