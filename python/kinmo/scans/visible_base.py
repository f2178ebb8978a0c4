"""What other parts move against in a scan: not a pin that nobody sees, as scissors have, but a part that hangs by it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.joint import Joint, JointKind
from kinmo.mobility import Mobility
from kinmo.scans.part_order import in_a_row
from kinmo.shape import Mesh, join

AS_LARGE = 0.8
"""Parts whose diagonals are at least this share of the largest one's are as good a base as that."""
SAME_DIRECTION = math.cos(math.radians(2.0))
SAME_AXIS = 0.01
"""Diagonals between two axes that are one."""


def with_visible_base(
    mobility: Mobility, meshes: Sequence[Mesh], smallest: float, to_z_up: NDArray[np.float64]
) -> tuple[Mobility, tuple[Mesh, ...]]:
    """The object with another base, where that is smaller than `smallest` (or nothing) and several parts hang by it.

    Body 0 is the base, every other one has a joint and comes after its parent; `meshes` are theirs, those of an object with the
    diagonal 1, and `to_z_up` [3, 3] turns their frame to one with z up and the front at -x. Of the largest parts below the base
    the one that comes first in a row (`part_order`) takes its place, and the base goes with it. The others move against that:
    about the same axis, or along the same line, as far as both do together; else as they do against the old base.
    """
    bodies = mobility.bodies
    below = [index for index, body in enumerate(bodies) if body.parent == 0]
    sizes = [_diagonal(mesh) for mesh in meshes]
    if sizes[0] >= smallest or len(below) < 2:
        return mobility, tuple(meshes)
    most = max(sizes[index] for index in below)
    fit = [index for index in below if sizes[index] >= max(AS_LARGE * most, smallest)]
    if not fit:
        return mobility, tuple(meshes)
    centers = np.stack([0.5 * (meshes[index].vertices.min(axis=0) + meshes[index].vertices.max(axis=0)) for index in fit])
    chosen = fit[in_a_row(centers @ to_z_up.T)[0]]
    order = [chosen, *(index for index in range(1, len(bodies)) if index != chosen)]
    place = {index: position for position, index in enumerate(order)} | {0: 0}
    leaves = tuple(sorted(bodies[0].leaves + bodies[chosen].leaves))
    found = [replace(bodies[chosen], id=0, leaves=leaves, parent=None, joint=None)]
    for body in (bodies[index] for index in order[1:]):
        joint, base = body.joint, bodies[chosen].joint
        if body.parent == 0 and joint is not None and base is not None:
            joint = against(joint, base)
        found.append(replace(body, id=place[body.id], parent=None if body.parent is None else place[body.parent], joint=joint))
    joined = join(meshes[0], meshes[chosen])
    return replace(mobility, bodies=tuple(found)), (joined, *(meshes[index] for index in order[1:]))


def against(mine: Joint, other: Joint) -> Joint:
    """How a part moves against another, both of which hang by the same thing, the one by `mine`, the other by `other`."""
    along = float(mine.direction @ other.direction)
    if mine.kind is not other.kind or mine.kind is JointKind.SCREW or abs(along) < SAME_DIRECTION:
        return mine
    if mine.kind is JointKind.REVOLUTE and np.linalg.norm(np.cross(other.pivot - mine.pivot, mine.direction)) > SAME_AXIS:
        return mine
    other = other if along > 0.0 else other.reversed()
    rest = mine.rest - other.rest
    if mine.lower is None or mine.upper is None or other.lower is None or other.upper is None:
        return replace(mine, lower=None, upper=None, rest=rest)
    return replace(mine, lower=mine.lower - other.upper, upper=mine.upper - other.lower, rest=rest)


def _diagonal(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) if len(mesh.vertices) else 0.0
