"""Closed poses of folding joints, such as those of scissors: the pose in which the tips of both halves meet first.

Halves that cross at their pin have two tips each. The tips of the blades meet where the object is closed. The tips of the
handles would meet only beyond, where the handles overlap. Hence the angle nearer to the file's pose is the closed one, and the
object opens away from the other. The free range of a sweep is no guide, because blades touch and halves share their pin.
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
from kinmo.scans.canonical.closed_pose import Parts, area_normals
from kinmo.scans.canonical.visible_base import transform_object

F64 = NDArray[np.float64]
C128 = NDArray[np.complex128]

TIP_SHARE = 0.95
"""Share of the largest distance from the hinge beyond which points belong to a tip."""
MIN_TIP_SHARE = 0.25
"""Share of the longest tip's distance from the hinge below which another one is no tip, but a stump behind the hinge."""
SAME_ANGLE = math.radians(2.0)
"""Largest difference of equal angles, rad."""
MIN_PARALLEL_COSINE = math.cos(math.radians(5.0))


@dataclass(frozen=True)
class FoldingJoint:
    """Closed pose of a part that folds over its parent.

    Attributes:
        closed: Angle from the file's pose to the closed pose about the joint, rad.
        opens: Direction from closed to open, 1 or -1; 0 if the tips do not tell.
        tips: Unit vector [3] from the hinge to the meeting point of the tips, if the parent stays.
        between: Unit vector [3] from the hinge to the middle between the tips in the file's pose.
        crosses: True if both tips of the part meet tips of its parent.
    """

    closed: float
    opens: float
    tips: F64
    between: F64
    crosses: bool


def find_folding_joints(mobility: Mobility, meshes: Sequence[Mesh], base_joint: Joint) -> dict[int, FoldingJoint]:
    """Folding joints of the base's children, by body index: hinges with limits that are parallel to the hinge `base_joint`.

    By `base_joint` the base hung from an invisible pin (`visible_base`). The joints' rest values describe `meshes`.
    """
    found = {}
    for index, body in mobility.movable():
        joint = body.joint
        if body.parent != 0 or joint is None or not joint.is_limited:
            continue
        are_hinges = joint.kind is base_joint.kind is JointKind.REVOLUTE
        if are_hinges and abs(float(joint.direction @ base_joint.direction)) >= MIN_PARALLEL_COSINE:
            folding = find_folding_joint(joint, meshes[index], meshes[0])
            if folding is not None:
                found[index] = folding
    return found


def find_folding_joint(joint: Joint, mesh: Mesh, parent: Mesh) -> FoldingJoint | None:
    """Folding joint of a part about a hinge; None if no tip of the part reaches as far as a tip of the parent.

    Tips are paired by their angle about the hinge: the nearest two, and the other two. Both meshes are as in the file.
    """
    first = np.linalg.svd(joint.direction[None])[2][1]
    across = np.stack([first, np.cross(joint.direction, first)])  # the second is a quarter turn from the first
    own, fixed = _tips(joint, mesh, across), _tips(joint, parent, across)
    farthest = max(float(np.abs([own, fixed]).max()), np.finfo(float).tiny)
    pairings = [_paired(tips, fixed, farthest) for tips in (own, own[::-1])]
    (closed, beyond), count, tip = min(pairings, key=lambda pairing: abs(pairing[0][0]) if pairing[1] else math.inf)
    if not count:
        return None
    opens = 0.0
    if count == 2 and abs(beyond - closed) > SAME_ANGLE:
        opens = -math.copysign(1.0, beyond - closed)
    elif abs(closed) > SAME_ANGLE:
        opens = -math.copysign(1.0, closed)
    tip /= abs(tip)
    tips, between = (across.T @ [way.real, way.imag] for way in (tip, tip * np.exp(-0.5j * closed)))
    return FoldingJoint(closed, opens, tips, between, count == 2)


def with_folding_limits(joint: Joint, folding: FoldingJoint, max_guessed_opening: float) -> Joint:
    """The hinge, which has limits, with one at its closed pose and the other `max_guessed_opening` rad from there.

    A hinge whose tips do not tell its opening direction opens to the wider side of its own limits.
    """
    assert joint.lower is not None and joint.upper is not None
    closed = joint.rest + folding.closed
    opens = folding.opens or (1.0 if joint.upper - closed >= closed - joint.lower else -1.0)
    lower, upper = sorted((closed, closed + opens * max_guessed_opening))
    return replace(joint, lower=lower, upper=upper)


def align_tips(mobility: Mobility, meshes: Sequence[Mesh], axis: Joint, foldings: Mapping[int, FoldingJoint]) -> Parts:
    """Turn a folding object as a whole about its hinge `axis`, so that its tips will meet along an axis of the frame.

    That axis is the one nearest to the middle between the tips in the file, projected along the hinge. There is at least one
    folding joint.
    """
    tips = np.sum([each.tips for each in foldings.values()], axis=0)
    between = np.sum([each.between for each in foldings.values()], axis=0)
    across = np.eye(3) - np.outer(axis.direction, axis.direction)
    place = int(np.argmax(np.abs(between)))
    near = across[place] * np.sign(between[place])
    angle = math.atan2(float(axis.direction @ np.cross(tips, near)), float(tips @ near))
    return transform_object(mobility, meshes, rotation_about(axis, angle))


def _tips(joint: Joint, mesh: Mesh, across: F64) -> C128:
    """Projected tips [2] on both sides of the hinge, along the surface's principal direction; 0 for a side without points.

    Projections along the hinge are complex numbers. A turn about it multiplies them by a phase.
    """
    flat = (mesh.vertices - joint.pivot) @ across.T
    seen = (flat[:, 0] + 1j * flat[:, 1])[mesh.faces]
    areas = np.linalg.norm(area_normals(mesh), axis=1)
    squares = np.square(seen).sum(axis=1) + np.square(seen.sum(axis=1))  # 12 times the mean square over a triangle
    long_side = np.exp(0.5j * np.angle(areas @ squares))
    points = np.unique(seen)
    is_ahead = (points * np.conj(long_side)).real > 0.0
    return np.array([_tip(points[is_ahead]), _tip(points[~is_ahead])])


def _tip(points: C128) -> complex:
    distances = np.abs(points)
    return complex(points[distances >= TIP_SHARE * distances.max()].mean()) if len(points) else 0j


def _paired(own: C128, fixed: C128, farthest: float) -> tuple[tuple[float, float], int, complex]:
    """Angles from a part's tips to its parent's, the number of pairs of true tips, and the parent's tip of the first pair.

    Pairs of true tips come first, the nearest before the other.
    """
    angles = np.angle(fixed * np.conj(own))
    is_tip = np.minimum(np.abs(own), np.abs(fixed)) >= MIN_TIP_SHARE * farthest
    first, second = np.argsort(np.where(is_tip, np.abs(angles), np.inf))
    return (float(angles[first]), float(angles[second])), int(is_tip.sum()), complex(fixed[first])
