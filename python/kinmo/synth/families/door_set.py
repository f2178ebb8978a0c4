"""Doors in a frame, with one or two leaves, handles, knobs, locks, knockers and letter flaps."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.door_leaves import board, sash
from kinmo.synth.details.door_locks import add_door_lock
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import knob_handle, pull
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, box_between, cylinder, move, rounded_path, sweep, torus, turn
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge, slider, spinner

BARS_SHARE = 0.3
"""Share of frames that are a part for each bar."""
GATE_SHARE = 0.08
"""Share of leaves that are made of bars."""


def build(draw: Draw) -> SynthObject:
    """Door frame with one or two leaves that turn about an outer edge or slide sideways.

    Levers, knobs, locks, knockers and letter flaps turn on their leaf.
    """
    root = Node(draw.pick(["door_set", "Door"], [4, 1]))
    leaves = draw.pick([1, 2], [3, 2])
    width, height = draw.between(0.7, 1.1) * leaves, draw.between(1.7, 2.3)
    rim, depth = draw.between(0.03, 0.12), draw.between(0.05, 0.2)
    frame = _frame(draw, width, height, rim, depth)
    pieces = [[piece] for piece in frame] if draw.chance(BARS_SHARE) else [frame]
    frame_nodes = [root.add("outside_frame", *piece) for piece in pieces]
    base = Link("outside_frame", frame_nodes, kind=draw.pick([JointType.STATIC, JointType.HEAVY], [4, 1]))
    links = [base]
    thickness = draw.between(0.03, 0.07)
    sliding = draw.chance(0.15)
    face = draw.pick([0.0, depth / 2 - thickness / 2, -depth / 2 + thickness / 2])
    side = draw.sign()
    glazed = draw.chance(0.35)
    for index in range(leaves):
        out = side if leaves == 1 else (-1.0, 1.0)[index]
        x = 0.0 if leaves == 1 else out * width / 4
        leaf = _Leaf(draw, root, base, (x, 0.0, face), width / leaves, height, thickness)
        leaf.fill(glazed=glazed)
        links.append(leaf.sliding(out, index * 1.1 * thickness) if sliding else leaf.hinged(out))
        links += leaf.hardware(out, links[-1])
    if draw.chance(0.25):
        bars, glass = sash(draw, width, 0.3, 0.6 * depth)
        over = root.add("transom")
        base.nodes.append(over)
        up = height / 2 + rim + 0.15
        over.add("horizontal_bar", *(move(bar, (0, up, 0)) for bar in bars))
        over.add("glass", *(move(pane, (0, up, 0)) for pane in glass))
    return SynthObject("Door", root, links)


def _frame(draw: Draw, width: float, height: float, rim: float, depth: float) -> list[Mesh]:
    """Two posts and a lintel around the opening, sometimes with a threshold and a casing."""
    x, y = width / 2, height / 2
    posts = [box((rim, height, depth), (s * (x + rim / 2), 0, 0)) for s in (-1, 1)]
    pieces = [*posts, box((width + 2 * rim, rim, depth), (0, y + rim / 2, 0))]
    if draw.chance(0.3):
        pieces.append(box((width, 0.02, depth), (0, -y - 0.01, 0)))
    if draw.chance(0.3):
        pieces += [box((1.6 * rim, height + rim, 0.02), (s * (x + 0.8 * rim), rim / 2, depth / 2)) for s in (-1, 1)]
    return pieces


class _Leaf:
    """One leaf under construction, centred at `at`."""

    def __init__(
        self, draw: Draw, root: Node, base: Link, at: tuple[float, float, float], width: float, height: float, thickness: float
    ) -> None:
        self.draw, self.base, self.at, self.thickness = draw, base, np.array(at), thickness
        gap = draw.pick([0.0, draw.between(0.002, 0.012)])
        self.width, self.height = width - 2 * gap, height - gap
        self.node = root.add("door")
        self.body = self.node.add("door_body")

    def fill(self, *, glazed: bool) -> None:
        """Add a glazed sash, a board, or bars."""
        if self.draw.chance(GATE_SHARE):
            self._add_bars()
        elif glazed:
            bars, glass = sash(self.draw, self.width, self.height, self.thickness)
            self.body.add("surface_board" if self.draw.chance(0.5) else "vertical_bar", *self._placed(bars))
            self.body.add("glass", *self._placed(glass))
        else:
            self.body.add("surface_board", *self._placed(board(self.draw, self.width, self.height, self.thickness)))
            half = 0.5 * np.array([self.width, self.height])
            face = self.at[2] + 0.5 * self.thickness
            add_fittings(self.draw, self.body, self.at[:2] - half, self.at[:2] + half, face)

    def _add_bars(self) -> None:
        """Add two or three rails, and upright bars across them, each a part of its own."""
        draw, thick = self.draw, self.thickness
        wide, rails = draw.between(0.02, 0.08) * self.width, draw.pick([2, 3])
        levels = np.linspace(-0.5, 0.5, rails) * self.height * draw.between(0.7, 0.95)
        pieces = [box((self.width, wide, thick), (0, level, 0)) for level in levels]
        places = np.linspace(-0.5, 0.5, draw.integer(4, 9)) * (self.width - wide)
        pieces += [box((wide, self.height, draw.pick([0.6, 1.0]) * thick), (x, 0, 0)) for x in places]
        for piece in self._placed(pieces):
            self.body.add("bar", piece)

    def _placed(self, pieces: list[Mesh]) -> list[Mesh]:
        return [move(piece, self.at) for piece in pieces]

    def hinged(self, out: float) -> Link:
        """Make the leaf turn about its outer edge (`out` -1 left, 1 right), to the front or to the rear."""
        front = self.draw.sign()
        offset = self.draw.pick([0.0, front * 0.5 * self.thickness, front * 0.7 * self.thickness])
        axis = self.at + [out * (self.width / 2 - self.draw.pick([0.0, self.draw.between(-0.01, 0.02)])), 0, offset]
        limits = self.draw.pick([(0.0, 90.0), (0.0, 120.0), (0.0, 180.0), (-90.0, 90.0)], [5, 1, 1, 1])
        rest = self.draw.between(15, 85) if self.draw.chance(0.4) else 0.0
        if self.draw.chance(0.3):
            for level in (-0.38, 0.0, 0.38):
                barrel = cylinder(0.012, 0.1, "y", axis + [0, level * self.height, 0], 10)
                self.body.children[0].pieces.append(barrel)
        return Link(
            "door", [self.body], self.base, hinge(axis, (0, out * front, 0), *limits, rest=rest), leaf_name="rotation_door"
        )

    def sliding(self, out: float, shift: float) -> Link:
        """Make the leaf slide sideways, shifted by `shift` along z past the leaf next to it."""
        travel = self.width * self.draw.between(0.7, 0.95)
        for leaf in self.body.leaves():
            leaf.pieces = [move(piece, (0, 0, shift)) for piece in leaf.pieces]
        rest = travel * self.draw.between(0.1, 0.8) if self.draw.chance(0.3) else 0.0
        return Link("door", [self.body], self.base, slider((out, 0, 0), 0, travel, rest=rest), leaf_name="translation_door")

    def hardware(self, out: float, leaf: Link) -> list[Link]:
        """Add a fixed pull, or a lever or knob that turns, on one or both faces, away from the hinge."""
        kind = self.draw.pick(["lever", "knob", "pull", "none"], [4, 3, 3, 1])
        x, y = -out * self.width * self.draw.between(0.38, 0.46), self.draw.between(-0.1, 0.05) * self.height
        place = self.at + [x, y, 0]
        if kind == "none":
            return []
        group = self.node.add("handle")
        if kind == "pull":
            foot, room = place + [0, 0, self.thickness / 2], 0.15 * self.width
            grip = pull(self.draw, self.draw.between(0.1, 0.4), foot, vertical=True, room=room)
            leaf.nodes.append(group.add("fixed_part", *grip))
            return []
        reach = self.draw.between(0.04, 0.07)
        faces = (1.0, -1.0) if self.draw.chance(0.6) else (1.0,)
        grips = []
        for own, face in zip(self.draw.identical(len(faces)), faces, strict=True):
            start = place + [0, 0, face * self.thickness / 2]
            grips.append([move(piece, start) for piece in self._grip(own, kind, reach, out, face)])
        for plate in self._roses(place, faces):
            leaf.nodes.append(group.add("fixed_part", plate))
        if self.draw.chance(0.35):
            leaf.nodes.append(group.add("fixed_part", *(piece for grip in grips for piece in grip)))
            return []
        if self.draw.chance(0.7):
            grips = [[piece for grip in grips for piece in grip]]
        turns = self.draw.between(30, 60)
        links = []
        for grip in grips:
            motion = hinge(place, (0, 0, out), 0, turns) if kind == "lever" else spinner(place, (0, 0, 1))
            links.append(Link("handle", [group.add("moving_part", *grip)], leaf, motion, leaf_name="handle"))
        return [*links, *self.extras(group, place, leaf)]

    def _roses(self, place: np.ndarray, faces: tuple[float, ...]) -> list[Mesh]:
        """Mounts of handles: a plate through the leaf, a plate or disc on each face (and one for the key), or nothing."""
        kind = self.draw.pick(["through", "plates", "discs", "none"], [3, 2, 4, 4])
        if kind == "through":
            return [box_between(place - [0.03, 0.09, 0.52 * self.thickness], place + [0.03, 0.09, 0.52 * self.thickness])]
        thin, radius, drop = self.draw.between(0.003, 0.012), self.draw.between(0.02, 0.035), self.draw.between(0.07, 0.12)
        keyhole = self.draw.chance(0.6)
        pieces = []
        for face in faces if kind != "none" else ():
            foot = place + [0, 0, face * (self.thickness + thin) / 2]
            if kind == "plates":
                pieces.append(box((1.8 * radius, 2.6 * drop, thin), foot - [0, 0.5 * drop, 0]))
                continue
            pieces.append(cylinder(radius, thin, "z", foot, 20))
            if keyhole:
                pieces.append(cylinder(0.9 * radius, thin, "z", foot - [0, drop, 0], 20))
        return pieces

    def _grip(self, draw: Draw, kind: str, reach: float, out: float, face: float) -> list[Mesh]:
        """A lever or knob with its foot at the origin, to the front (`face` 1) or to the rear (-1)."""
        if kind == "knob":
            knob = knob_handle(draw, draw.between(0.02, 0.045), reach)
            return knob if face > 0 else [turn(piece, (0, 1, 0), 180.0) for piece in knob]
        hub = cylinder(draw.between(0.012, 0.025), reach, "z", (0, 0, face * reach / 2), 12)
        long, thick = draw.between(0.09, 0.2), draw.between(0.012, 0.03)
        if draw.chance(0.5):
            return [hub, box((long, thick, 0.7 * thick), (out * (0.5 * long - 0.01), 0, face * reach))]
        bend = draw.pick([0.0, draw.between(-0.3, 0.3)]) * long
        path = np.array([(0, 0, face * reach), (0.5 * out * long, bend, face * reach), (out * long, 0.5 * bend, face * reach)])
        return [hub, sweep(rounded_path(path, 0.3 * long), 0.5 * thick, 8)]

    def extras(self, group: Node, place: np.ndarray, leaf: Link) -> list[Link]:
        """Add a second lock, a knocker, or a letter flap."""
        draw, front = self.draw, self.thickness / 2
        kind = draw.pick(["none", "lock", "knocker", "flap"], [6, 2, 1, 1])
        if kind == "lock":
            at = place + [0, draw.pick([-1.0, 1.0, 1.0]) * draw.between(0.08, 0.3), front]
            return [
                add_door_lock(draw, group, leaf, draw.pick(["cylinder", "tee", "lever", "cover"]), at, draw.between(0.04, 0.1))
            ]
        middle = self.at + [0, draw.between(-0.1, 0.25) * self.height, front]
        if kind == "knocker":
            ring = move(torus(0.05, 0.01, "z", segments=18), middle + [0, -0.05, 0.012])
            swing = hinge(middle + [0, 0, 0.012], (-1, 0, 0), 0, draw.between(20, 60))
            return [Link("knocker", [group.add("moving_part", ring)], leaf, swing)]
        if kind == "flap":
            size = (draw.between(0.2, 0.35), draw.between(0.05, 0.09), 0.01)
            plate = box(size, middle + [0, 0, 0.005])
            upper = middle + [0, 0.5 * size[1], 0.005]
            return [Link("flap", [group.add("moving_part", plate)], leaf, hinge(upper, (-1, 0, 0), 0, draw.between(30, 80)))]
        return []
