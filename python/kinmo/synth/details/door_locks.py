"""Door hardware on a front (+z) that turns about its normal: dials, wheels, levers, key cylinders and their covers."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.controls import dial
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, Z, box, cylinder, join, lathe, move, rounded_path, sweep, torus, turn
from kinmo.synth.synth_object import Link, Node, hinge, spinner

LOCK_NAMES = {
    "dial": ("switch", "knob"),
    "wheel": ("switch", "handle"),
    "lever": ("handle", "switch", "lever"),
    "tee": ("handle", "switch"),
    "cylinder": ("lock", "switch", "key_hole"),
    "cover": ("lock", "switch"),
}
"""Names of the leaf of each kind, most frequent first."""


def add_door_lock(draw: Draw, above: Node, door: Link, kind: str, at: Point, size: float) -> Link:
    """Add a lock that turns about the normal of a door.

    Args:
        above: Node that the lock is added below.
        door: Link of the door.
        kind: Key of `LOCK_NAMES`.
        at: Foot [3] of the lock.
        size: Diameter or length of the lock.

    Returns:
        Link of the lock.
    """
    pieces = [move(piece, at) for piece in lock_pieces(draw, kind, size)]
    names = LOCK_NAMES[kind]
    node = above.add(draw.pick(names, [4, *[1] * (len(names) - 1)]), *pieces)
    origin = (float(at[0]), float(at[1]), draw.pick([0.0, float(at[2])]))
    if kind in ("lever", "tee", "cover") and draw.chance(0.6):
        motion = hinge(origin, Z, *draw.pick([(-90.0, 0.0), (0.0, 90.0), (-45.0, 0.0), (0.0, 60.0), (-90.0, 90.0)]))
    else:
        motion = spinner(origin, Z)
    return Link("knob", [node], door, motion, leaf_name=node.name)


def lock_pieces(draw: Draw, kind: str, size: float) -> list[Mesh]:
    """Meshes of a lock with its axis along z and its foot on z = 0. `kind` is a key of `LOCK_NAMES`."""
    if kind == "dial":
        return dial(draw, 0.5 * size, 0.5 * size * draw.between(0.25, 0.9), (0, 0, 0))
    if kind == "wheel":
        return _wheel(draw, 0.5 * size)
    if kind == "cylinder":
        radius, proud = 0.5 * size, size * draw.between(0.1, 0.6)
        slot = box((0.15 * radius, 0.9 * radius, 0.1 * proud), (0, 0, proud))
        return [cylinder(radius, proud, "z", (0, 0, proud / 2), draw.pick([12, 20, 32])), *([slot] if draw.chance(0.6) else [])]
    if kind == "cover":
        plate = join(
            cylinder(0.2 * size, 0.06 * size, "z", (0, 0, 0.03 * size), 16),
            box((0.35 * size, 0.8 * size, 0.05 * size), (0, -0.4 * size, 0.03 * size)),
        )
        return [plate]
    return _arm_handle(draw, size, both_ways=kind == "tee")


def _arm_handle(draw: Draw, size: float, *, both_ways: bool) -> list[Mesh]:
    """A hub with an arm to one side of the axis or to both, at a random angle."""
    reach, thick = size * draw.between(0.2, 0.6), size * draw.between(0.06, 0.16)
    hub = size * draw.between(0.1, 0.2)
    start = -size * (0.5 if both_ways else draw.between(0.0, 0.2))
    end = start + size
    if draw.chance(0.5):
        middle = (0.5 * (start + end), 0, reach - thick / 2)
        arm = box((end - start, thick * draw.between(1.0, 2.5), thick), middle)
    else:
        bend = 0.0 if both_ways else draw.between(-0.3, 0.3) * size
        path = np.array([(start, 0, reach), (0.5 * (start + end), 0, reach), (end, bend, reach)])
        arm = sweep(rounded_path(path, 0.2 * size), thick / 2, 8)
    pieces = [cylinder(hub, reach, "z", (0, 0, reach / 2), draw.pick([10, 16, 24])), arm]
    if draw.chance(0.4):
        pieces.append(cylinder(1.6 * hub, 0.15 * reach, "z", (0, 0, 0.075 * reach), 20))
    angle = draw.pick([0.0, 180.0, -90.0, 90.0, draw.between(-180.0, 180.0)], [3, 3, 4, 1, 1])
    pieces = [turn(piece, Z, angle) for piece in pieces]
    return [join(*pieces)] if draw.chance(0.5) else pieces


def _wheel(draw: Draw, radius: float) -> list[Mesh]:
    """A hub with one to five spokes, sometimes with knobs or a rim at their ends."""
    reach, rod = radius * draw.between(0.12, 1.0), radius * draw.between(0.07, 0.16)
    level = max(0.8 * reach, 2.0 * rod)
    hub = cylinder(draw.between(0.2, 0.45) * radius, reach, "z", (0, 0, reach / 2), 20)
    if draw.chance(0.3):
        profile = np.array([[0.45, 0], [0.3, 0.3], [0.25, 0.8], [0.35, 1.0], [0, 1.1]]) * (radius, reach)
        hub = turn(lathe(profile, 20), (1, 0, 0), 90.0)
    count, start = draw.pick([1, 2, 3, 4, 5], [1, 2, 4, 2, 2]), draw.between(0.0, 120.0)
    spoke = cylinder(rod, radius, "x", (radius / 2, 0, level), 8, top_radius=rod * draw.between(0.6, 1.4))
    if draw.chance(0.3):
        spoke = join(spoke, cylinder(1.8 * rod, 3 * rod, "x", (radius, 0, level), 12))
    pieces = [hub, *(turn(spoke, Z, start + 360.0 * i / count) for i in range(count))]
    if count >= 2 and draw.chance(0.4):
        pieces.append(torus(radius, rod, "z", (0, 0, level), 24))
    return pieces
