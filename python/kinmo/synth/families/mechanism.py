"""Mechanisms: no kind of thing, but blocks, housings, pedestals and the like with mechanisms, as things of all kinds have.

What is learnt from them holds for categories that nobody made a family of: where parts touch, which way they can go.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector
from kinmo.synth.details.controls import grid_places
from kinmo.synth.details.posture import lay, reorient
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms import FITTED, MECHANISMS
from kinmo.synth.mechanisms.hollow import hollow
from kinmo.synth.mechanisms.housing import housing
from kinmo.synth.mechanisms.mount import mount
from kinmo.synth.mechanisms.pedestal import pedestal
from kinmo.synth.mechanisms.slab import slab
from kinmo.synth.mechanisms.slender import slender
from kinmo.synth.model import JointName, Link, Node, SynthObject
from kinmo.synth.primitives import X, Y, Z, box, rounded_box
from kinmo.synth.primitives.place import facing, rotation_about

SIDES = ((Z, Y), (-Z, Y), (X, Y), (-X, Y), (Y, Z), (-Y, Z))
"""The outward normal of each side of the block, and the direction on it that is up or to the front."""
ORIGIN = (0.0, 0.0, 0.0)
TURNED = 0.2
"""Chance that a block lies, and that a pedestal hangs from the ceiling."""
USUAL = 0.7
"""Chance that a mechanism is turned as it mostly is on such a side."""
CROWDED, MOST = 0.5, 6
"""Share of objects that have many small mechanisms rather than few large ones, and how many a block has at most."""


def build(draw: Draw) -> SynthObject:
    style = draw.pick([_block, housing, pedestal, hollow, slender, slab], [5, 5, 4, 3, 3, 2])
    made = style(draw, draw.chance(CROWDED))
    if style is _block and draw.chance(TURNED):
        lay(draw, made)
    elif style is pedestal and draw.chance(TURNED):
        reorient(made, rotation_about(X, 180.0, ORIGIN))
    return made


def _block(draw: Draw, crowded: bool) -> SynthObject:
    root = Node("mechanism")
    size = np.array([draw.between(0.3, 1.2) for _ in range(3)])
    for axis in draw.pick([(), (0,), (1,), (2,), (0, 1), (1, 2), (0, 2)], [4, 1, 2, 1, 1, 1, 2]):
        size[axis] *= draw.between(0.1, 0.3)
    block = draw.pick([box(size), rounded_box(size, 0.15 * size.min(), draw.pick(["x", "y", "z"]))])
    base = Link("body", [root.add("body", block)], kind=draw.pick([JointName.FREE, JointName.STATIC, JointName.HEAVY]))
    links = [base]
    left = draw.integer(2, MOST) if draw.chance(0.6 if crowded else 0.4) else 1
    largest = draw.between(0.8, 4.0) if left == 1 else draw.between(0.8, 1.5)
    for index in draw.generator.permutation(len(SIDES)):
        if left > 0:
            normal, up = SIDES[index]
            left -= _Side(normal, up, size).furnish(draw, root, links, left, largest)
    return SynthObject("Mechanism", root, links)


@dataclass(frozen=True, eq=False)
class _Side:
    """One side of a block of `size`, its outward `normal` and the direction `up` on it."""

    normal: Vector
    up: Vector
    size: Vector

    @property
    def across(self) -> Vector:
        return np.cross(self.up, self.normal)

    def furnish(self, draw: Draw, root: Node, links: list[Link], most: int, largest: float) -> int:
        """Put mechanisms on the side, alike or not, and say how many."""
        wide, high = (float(np.abs(axis) @ self.size) for axis in (self.across, self.up))
        if draw.chance(0.25):
            mechanism, depth, angle = draw.pick(FITTED)(draw), draw.between(0.3, 1.0), self.quarters(draw)
            size = (wide, high) if angle % 180.0 == 0.0 else (high, wide)
            fitted = self.frame(0.0, 0.0) @ rotation_about(Z, angle, ORIGIN)
            links += mount(draw, mechanism, (*size, depth * min(wide, high)), fitted, root, links[0])
            return 1
        columns, rows = draw.pick([(1, 1), (2, 1), (1, 2), (3, 1), (2, 2)], [6, 2, 2, 1, 1])
        cell = largest * max(min(wide / columns, high / rows), 0.1)
        places = grid_places(columns, rows, wide, high)[:most]
        draws = draw.alike(len(places)) if draw.chance(0.5) else [draw] * len(places)
        for place, own in zip(places, draws, strict=True):
            mechanism = own.pick(MECHANISMS)(own)
            turned = rotation_about(Z, self.quarters(own), ORIGIN)
            if own.chance(0.15):
                turned = turned @ rotation_about(own.pick([X, Y]), own.sign() * own.between(5.0, 30.0), ORIGIN)
            links += mount(draw, mechanism, own.between(0.5, 0.95) * cell, self.frame(*place) @ turned, root, links[0])
        return len(places)

    def quarters(self, draw: Draw) -> float:
        """By how much a mechanism is turned on the side, in degrees. Doors mostly hang at a side, lids at the back."""
        if draw.chance(USUAL):
            return draw.pick([90.0, 270.0], [3, 1]) if abs(self.normal @ Y) > 0.5 else draw.pick([0.0, 180.0])
        return 90.0 * draw.integer(0, 3)

    def frame(self, right: float, up: float) -> NDArray[np.float64]:
        """Rigid transform [4, 4] from a mechanism's cell to the place (right, up) of the middle."""
        deep = float(np.abs(self.normal) @ self.size)
        return facing(self.normal, self.up, self.across * right + self.up * up + 0.5 * deep * self.normal)
