"""Scissors: two blades with handles that turn about a screw."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import arc_path, cylinder, extrude, mirror, move, rounded_path, sweep, torus
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge


def build(draw: Draw) -> SynthObject:
    """Scissors whose halves both turn against the screw, or one against the other.

    Built closed, along z with the blades to +z and the screw at the origin, flat across y. The posture is always the same,
    since two equal halves differ only in where they lie.
    """
    thickness = draw.between(0.015, 0.04)
    root = Node("scissors")
    sets = []
    half = _Half(draw, thickness)
    for side in (1.0, -1.0):
        group = root.add("blade_handle_set")
        group.add("blade", _mirrored(half.blade(side), side))
        group.add("handle", *(_mirrored(piece, side) for piece in half.handle(draw, side)))
        sets.append(group)
    size = draw.between(0.02, 0.05)
    pin = root.add("screw", cylinder(size, thickness * draw.between(2.1, 3.5), "y", (0, 0, 0), 16))
    opening = draw.between(30.0, 60.0)
    lean = draw.pick([0.0, draw.between(0.0, opening)], [1, 4])
    fixed = Link("screw", [pin], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    if draw.chance(0.5):
        # Both halves turn about the screw.
        motions = [hinge((0, 0, 0), (0, sense, 0), 0.0, 0.5 * opening, rest=0.5 * lean) for sense in (1, -1)]
        links = [fixed, *(Link("leg", [group], fixed, motion) for group, motion in zip(sets, motions, strict=True))]
    else:
        fixed.nodes.append(sets[0])
        links = [fixed, Link("leg", [sets[1]], fixed, hinge((0, 0, 0), (0, -1, 0), 0.0, opening, rest=lean))]
    return SynthObject("Scissors", root, links)


class _Half:
    """Sizes of one half, shared by both."""

    def __init__(self, draw: Draw, thickness: float) -> None:
        self.thickness = thickness
        self.length = draw.between(0.6, 1.4)
        self.width = draw.between(0.05, 0.12)
        self.tail = draw.between(0.35, 0.8)
        self.bow = draw.between(0.12, 0.22)
        self.rod = draw.between(0.02, 0.05)
        self.straight = draw.chance(0.5)

    def blade(self, side: float) -> Mesh:
        """Blade from behind the screw to the tip. The cutting edge is at x = 0 when closed."""
        w, n = self.width, self.length
        belly = 0.8 if self.straight else 1.2
        heel, edge = [[-0.12, -0.4], [0.0, -0.6]], [[0.25 * n, -0.2], [n, -0.1], [0.7 * n, belly]]
        outline = np.array([*heel, *edge, [0.1 * n, 1.0], [-0.12, 1.0]]) * (1.0, w)
        return extrude(outline, self.thickness, "y", (0, side * 0.5 * self.thickness, 0))

    def handle(self, draw: Draw, side: float) -> list[Mesh]:
        """A shank that crosses over behind the screw, and a ring or a hook for the fingers."""
        y = side * 0.3 * self.thickness
        start, end = (0.02, y, -0.05), (-self.bow - self.rod, 0.0, -self.tail + self.bow)
        bend = (-0.3 * self.bow, y, -0.4 * self.tail)
        shank = sweep(rounded_path(np.array([start, bend, end]), 0.2), self.rod, 8)
        long = draw.between(1.0, 1.8)
        if draw.chance(0.85):
            ring = torus(self.bow, self.rod, "y", (0, 0, 0), 20, 8)
            ring = Mesh(ring.vertices * (1.0, 1.0, long), ring.faces)
            return [shank, move(ring, (-self.bow - self.rod, 0, -self.tail - (long - 1.0) * self.bow))]
        hook = sweep(arc_path((-self.bow, 0, -self.tail), self.bow, -60, 200, "y", 14), self.rod, 8)
        return [shank, hook]


def _mirrored(mesh: Mesh, side: float) -> Mesh:
    """The mesh for side 1, or its mirror image for side -1."""
    return mesh if side > 0 else mirror(mesh, 0)
