"""Where what folds about a pin that nobody sees is closed, such as scissors: where tips of its two halves meet first.

Halves that cross at their pin have two tips each. Those of blades meet where the object is closed; those of handles would meet
only beyond, where these lie over each other. So of the two angles the one nearer to the pose of the file is where it is closed,
and it opens away from the other. What a sweep finds free is no guide: blades touch all along, and halves share their pin.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import rotation_about
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh
from kinmo.scans.visible_base import moved_as_a_whole

F64 = NDArray[np.float64]
C128 = NDArray[np.complex128]

TIP = 0.95
"""The share of the farthest point's distance from the hinge from which on points are of the tip."""
SHORTEST = 0.25
"""The share of the longest tip's distance from the hinge below which another tip is none, but the stump behind a hinge."""
ONE_ANGLE = math.radians(2.0)
"""Angles that are as near are one."""
PARALLEL = math.cos(math.radians(5.0))


@dataclass(frozen=True)
class Fold:
    """How a part folds over another: `closed`, the angle in radians about its joint, from the pose of the file, where it is so.

    From there it `opens` to 1 or -1, or 0 where its tips do not tell. `tips` [3] is the unit vector from the hinge to where
    they meet if the other part stays, `between` [3] the one to half way between them in the file. It `crosses` the other part
    if it has two tips that meet such of that.
    """

    closed: float
    opens: float
    tips: F64
    between: F64
    crosses: bool


def folds_of(mobility: Mobility, meshes: Sequence[Mesh], hung_by: Joint) -> dict[int, Fold]:
    """How the bodies below the base fold over it which turn, with limits, along the hinge that the base hung by.

    `meshes` are those of the bodies; they are as in the file.
    """
    found = {}
    for index, body in mobility.movable():
        joint = body.joint
        if body.parent != 0 or joint is None or not joint.is_limited or not joint.kind is hung_by.kind is JointKind.REVOLUTE:
            continue
        fold = fold_of(joint, meshes[index], meshes[0]) if abs(float(joint.direction @ hung_by.direction)) >= PARALLEL else None
        if fold is not None:
            found[index] = fold
    return found


def fold_of(joint: Joint, mesh: Mesh, base: Mesh) -> Fold | None:
    """How the part that hangs by a hinge folds over `base`; None if no tip of the one reaches as far as a tip of the other.

    The two tips belong together which are nearest to each other in the file, as seen from the hinge, and the other two.
    """
    across = _across(joint)
    own, fixed = _tips(joint, mesh, across), _tips(joint, base, across)
    farthest = max(float(np.abs([own, fixed]).max()), np.finfo(float).tiny)
    pairings = [_Pairing.of(tips, fixed, farthest) for tips in (own, own[::-1])]
    pairing = min(pairings, key=lambda pairing: abs(pairing.angles[0]) if pairing.count else math.inf)
    if not pairing.count:
        return None
    closed, beyond = pairing.angles
    opens = 0.0
    if pairing.count == 2 and abs(beyond - closed) > ONE_ANGLE:
        opens = -math.copysign(1.0, beyond - closed)
    elif abs(closed) > ONE_ANGLE:
        opens = -math.copysign(1.0, closed)
    tip = pairing.tip / abs(pairing.tip)
    tips, between = (across.T @ [way.real, way.imag] for way in (tip, tip * np.exp(-0.5j * closed)))
    return Fold(closed, opens, tips, between, pairing.count == 2)


def folded(joint: Joint, fold: Fold, widest: float) -> Joint:
    """The hinge, which has limits, with one end where its part is closed, and the other `widest` radians from there.

    Where tips do not tell which way it opens, that is to where it is free for longer by its own limits.
    """
    if joint.lower is None or joint.upper is None:
        raise ValueError("a hinge without limits is nowhere closed")
    closed = joint.rest + fold.closed
    opens = fold.opens or (1.0 if joint.upper - closed >= closed - joint.lower else -1.0)
    ends = sorted((closed, closed + opens * widest))
    return replace(joint, lower=ends[0], upper=ends[1])


def laid_straight(
    mobility: Mobility, meshes: Sequence[Mesh], axis: Joint, folds: Mapping[int, Fold]
) -> tuple[Mobility, tuple[Mesh, ...]]:
    """What folds, which nothing holds but the hinge `axis`, turned as a whole about it until its tips will meet along an axis.

    That is the axis of the frame, as the hinge has it seen, which is nearest to half way between the tips in the file.
    """
    tips, between = (np.sum(ways, axis=0) for ways in zip(*((fold.tips, fold.between) for fold in folds.values()), strict=True))
    across = np.eye(3) - np.outer(axis.direction, axis.direction)
    place = int(np.argmax(np.abs(between)))
    near = across[place] * np.sign(between[place])
    angle = math.atan2(float(axis.direction @ np.cross(tips, near)), float(tips @ near))
    return moved_as_a_whole(mobility, meshes, rotation_about(axis, angle))


def _across(joint: Joint) -> F64:
    """Two unit vectors [2, 3] across the hinge, the second a quarter of a turn about it from the first."""
    first = np.linalg.svd(joint.direction[None])[2][1]
    return np.stack([first, np.cross(joint.direction, first)])


def _seen(joint: Joint, mesh: Mesh, across: F64) -> C128:
    """The corners [triangles, 3] as seen along the hinge, which is at 0: to turn about it is to multiply by a phase."""
    flat = (mesh.vertices - joint.pivot) @ across.T
    return np.asarray((flat[:, 0] + 1j * flat[:, 1])[mesh.faces])


def _tips(joint: Joint, mesh: Mesh, across: F64) -> C128:
    """The tips [2] on both sides of the hinge along the surface's long side, seen along the hinge; 0 where there is nothing."""
    seen = _seen(joint, mesh, across)
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    squares = np.square(seen).sum(axis=1) + np.square(seen.sum(axis=1))  # 12 times the mean square over a triangle
    long_side = np.exp(0.5j * np.angle(areas @ squares))
    points = np.unique(seen)
    is_ahead = (points * np.conj(long_side)).real > 0.0
    return np.array([_tip(points[is_ahead]), _tip(points[~is_ahead])])


def _tip(points: C128) -> complex:
    distances = np.abs(points)
    return complex(points[distances >= TIP * distances.max()].mean()) if len(points) else 0j


@dataclass(frozen=True)
class _Pairing:
    """Tips of a part and of its base that belong together: `angles`, from each of the part's to that of the base.

    `count` pairs are tips indeed, the nearer ones first; the first one's `tip` of the base.
    """

    angles: tuple[float, float]
    count: int
    tip: complex

    @classmethod
    def of(cls, own: C128, fixed: C128, farthest: float) -> _Pairing:
        angles = np.angle(fixed * np.conj(own))
        reach = np.minimum(np.abs(own), np.abs(fixed)) >= SHORTEST * farthest
        order = np.argsort(np.where(reach, np.abs(angles), np.inf))
        return cls((float(angles[order[0]]), float(angles[order[1]])), int(reach.sum()), complex(fixed[order[0]]))
