"""Mechanisms: blocks, housings, pedestals and other bodies that carry random mechanisms and belong to no category.

They teach networks how parts can move for categories that have no family: from where parts touch and which way is free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector
from kinmo.synth.details.controls import grid_places
from kinmo.synth.details.posture import lay_down
from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms import MECHANISMS, STRETCHABLE
from kinmo.synth.mechanisms.hollow import hollow
from kinmo.synth.mechanisms.housing import housing
from kinmo.synth.mechanisms.mount import mount
from kinmo.synth.mechanisms.pedestal import pedestal
from kinmo.synth.mechanisms.slab import slab
from kinmo.synth.mechanisms.slender import slender
from kinmo.synth.primitives import X, Y, Z, box, facing, rotation_about, rounded_box
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject

SIDES = ((Z, Y), (-Z, Y), (X, Y), (-X, Y), (Y, Z), (-Y, Z))
"""Outward normal of each side of the block, and the direction on that side that is up or to the front."""
TURNED_CHANCE = 0.2
"""Chance that a block lies on another side, and that a pedestal hangs from the ceiling."""
USUAL_TURN_CHANCE = 0.7
"""Chance that a mechanism is turned as usual for such a side."""
CROWDED_SHARE, MAX_MECHANISMS = 0.5, 6
"""Share of objects with many small mechanisms instead of few large ones, and most mechanisms of a block."""


def build(draw: Draw) -> SynthObject:
    """Body with random mechanisms.

    Variants: a block with mechanisms on its sides, and the bodies of `kinmo.synth.mechanisms` (housing, pedestal, hollow,
    slender, slab).
    """
    style = draw.pick([_block, housing, pedestal, hollow, slender, slab], [5, 5, 4, 3, 3, 2])
    made = style(draw, draw.chance(CROWDED_SHARE))
    if style is _block and draw.chance(TURNED_CHANCE):
        lay_down(draw, made)
    elif style is pedestal and draw.chance(TURNED_CHANCE):
        made.move(rotation_about(X, 180.0))
    return made


def _block(draw: Draw, crowded: bool) -> SynthObject:
    """A block, often thin along one or two axes, with mechanisms on some of its sides."""
    root = Node("mechanism")
    size = np.array([draw.between(0.3, 1.2) for _ in range(3)])
    for axis in draw.pick([(), (0,), (1,), (2,), (0, 1), (1, 2), (0, 2)], [4, 1, 2, 1, 1, 1, 2]):
        size[axis] *= draw.between(0.1, 0.3)
    block = draw.pick([box(size), rounded_box(size, 0.15 * size.min(), draw.pick(["x", "y", "z"]))])
    base = Link("body", [root.add("body", block)], kind=draw.pick([JointType.FREE, JointType.STATIC, JointType.HEAVY]))
    links = [base]
    left = draw.integer(2, MAX_MECHANISMS) if draw.chance(0.6 if crowded else 0.4) else 1
    largest = draw.between(0.8, 4.0) if left == 1 else draw.between(0.8, 1.5)
    for index in draw.generator.permutation(len(SIDES)):
        if left > 0:
            normal, up = SIDES[index]
            left -= _Side(normal, up, size).furnish(draw, root, links, left, largest)
    return SynthObject("Mechanism", root, links)


@dataclass(frozen=True, eq=False)
class _Side:
    """One side of a block of `size`, with its outward `normal` and the direction `up` on it."""

    normal: Vector
    up: Vector
    size: Vector

    @property
    def across(self) -> Vector:
        """Direction to the right on the side."""
        return np.cross(self.up, self.normal)

    def furnish(self, draw: Draw, root: Node, links: list[Link], most: int, largest: float) -> int:
        """Put mechanisms on the side, equal or not; returns their number."""
        wide, high = (float(np.abs(axis) @ self.size) for axis in (self.across, self.up))
        if draw.chance(0.25):
            mechanism, depth, angle = draw.pick(STRETCHABLE)(draw), draw.between(0.3, 1.0), self.quarters(draw)
            size = (wide, high) if angle % 180.0 == 0.0 else (high, wide)
            fitted = self.frame(0.0, 0.0) @ rotation_about(Z, angle)
            links += mount(draw, mechanism, (*size, depth * min(wide, high)), fitted, root, links[0])
            return 1
        columns, rows = draw.pick([(1, 1), (2, 1), (1, 2), (3, 1), (2, 2)], [6, 2, 2, 1, 1])
        cell = largest * max(min(wide / columns, high / rows), 0.1)
        places = grid_places(columns, rows, wide, high)[:most]
        draws = draw.identical(len(places)) if draw.chance(0.5) else [draw] * len(places)
        for place, own in zip(places, draws, strict=True):
            mechanism = own.pick(MECHANISMS)(own)
            turned = rotation_about(Z, self.quarters(own))
            if own.chance(0.15):
                turned = turned @ rotation_about(own.pick([X, Y]), own.sign() * own.between(5.0, 30.0))
            links += mount(draw, mechanism, own.between(0.5, 0.95) * cell, self.frame(*place) @ turned, root, links[0])
        return len(places)

    def quarters(self, draw: Draw) -> float:
        """Angle (degrees) by which a mechanism is turned on the side. Most doors are hinged at a side, lids at the rear."""
        if draw.chance(USUAL_TURN_CHANCE):
            return draw.pick([90.0, 270.0], [3, 1]) if abs(self.normal @ Y) > 0.5 else draw.pick([0.0, 180.0])
        return 90.0 * draw.integer(0, 3)

    def frame(self, right: float, up: float) -> NDArray[np.float64]:
        """Rigid transform [4, 4] from a mechanism's cell to a place on the side, given from its centre."""
        deep = float(np.abs(self.normal) @ self.size)
        return facing(self.normal, self.up, self.across * right + self.up * up + 0.5 * deep * self.normal)
