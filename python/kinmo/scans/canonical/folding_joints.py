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
    """Folding joints between the base and its children.

    Args:
        mobility: Joints; their rest values describe `meshes`.
        meshes: Meshes of the bodies, one each, as in the file.
        base_joint: Joint by which the base hung from an invisible pin (`visible_base`).

    Returns:
        Folding joints by body index: hinges with limits that are parallel to the hinge `base_joint`.
    """
    found = {}
    for index, body in mobility.movable():
        joint = body.joint
        if body.parent != 0 or joint is None or not joint.is_limited:
            continue
        if not joint.kind is base_joint.kind is JointKind.REVOLUTE:
            continue
        if abs(float(joint.direction @ base_joint.direction)) < MIN_PARALLEL_COSINE:
            continue
        folding = find_folding_joint(joint, meshes[index], meshes[0])
        if folding is not None:
            found[index] = folding
    return found


def find_folding_joint(joint: Joint, mesh: Mesh, parent: Mesh) -> FoldingJoint | None:
    """Folding joint of a part about a hinge.

    Tips are paired by their angle about the hinge: the nearest two, and the other two.

    Args:
        joint: The hinge.
        mesh: Mesh of the part, as in the file.
        parent: Mesh of the parent, as in the file.

    Returns:
        The folding joint; None if no tip of the part reaches as far as a tip of the parent.
    """
    across = _plane(joint)
    own, fixed = _tips(joint, mesh, across), _tips(joint, parent, across)
    farthest = max(float(np.abs([own, fixed]).max()), np.finfo(float).tiny)
    pairings = [_TipPairing.of(tips, fixed, farthest) for tips in (own, own[::-1])]
    pairing = min(pairings, key=lambda pairing: abs(pairing.angles[0]) if pairing.count else math.inf)
    if not pairing.count:
        return None
    closed, beyond = pairing.angles
    opens = 0.0
    if pairing.count == 2 and abs(beyond - closed) > SAME_ANGLE:
        opens = -math.copysign(1.0, beyond - closed)
    elif abs(closed) > SAME_ANGLE:
        opens = -math.copysign(1.0, closed)
    tip = pairing.tip / abs(pairing.tip)
    tips, between = (across.T @ [way.real, way.imag] for way in (tip, tip * np.exp(-0.5j * closed)))
    return FoldingJoint(closed, opens, tips, between, pairing.count == 2)


def with_folding_limits(joint: Joint, folding: FoldingJoint, max_guessed_opening: float) -> Joint:
    """The hinge with one limit at its closed pose and the other `max_guessed_opening` rad from there.

    A hinge whose tips do not tell its opening direction opens to the wider side of its own limits.

    Raises:
        ValueError: If the joint has no limits.
    """
    if joint.lower is None or joint.upper is None:
        raise ValueError("expected a hinge with limits, got one without")
    closed = joint.rest + folding.closed
    opens = folding.opens or (1.0 if joint.upper - closed >= closed - joint.lower else -1.0)
    ends = sorted((closed, closed + opens * max_guessed_opening))
    return replace(joint, lower=ends[0], upper=ends[1])


def align_tips(
    mobility: Mobility, meshes: Sequence[Mesh], axis: Joint, foldings: Mapping[int, FoldingJoint]
) -> tuple[Mobility, tuple[Mesh, ...]]:
    """Turn a folding object as a whole about its hinge, so that its tips will meet along an axis of the frame.

    Args:
        mobility: The object's joints.
        meshes: Meshes of the bodies, one each, as in the file.
        axis: The hinge that alone holds the object.
        foldings: At least one folding joint, by body index.

    Returns:
        The turned object. The axis is the one nearest to the middle between the tips in the file, projected along the hinge.
    """
    tips, between = (
        np.sum(ways, axis=0) for ways in zip(*((each.tips, each.between) for each in foldings.values()), strict=True)
    )
    across = np.eye(3) - np.outer(axis.direction, axis.direction)
    place = int(np.argmax(np.abs(between)))
    near = across[place] * np.sign(between[place])
    angle = math.atan2(float(axis.direction @ np.cross(tips, near)), float(tips @ near))
    return transform_object(mobility, meshes, rotation_about(axis, angle))


def _plane(joint: Joint) -> F64:
    """Two unit vectors [2, 3] across the hinge; the second is a quarter turn from the first."""
    first = np.linalg.svd(joint.direction[None])[2][1]
    return np.stack([first, np.cross(joint.direction, first)])


def _projected(joint: Joint, mesh: Mesh, across: F64) -> C128:
    """Triangle corners [triangles, 3] projected along the hinge as complex numbers; a turn about it multiplies by a phase."""
    flat = (mesh.vertices - joint.pivot) @ across.T
    return np.asarray((flat[:, 0] + 1j * flat[:, 1])[mesh.faces])


def _tips(joint: Joint, mesh: Mesh, across: F64) -> C128:
    """Projected tips [2] on both sides of the hinge, along the surface's principal direction; 0 for a side without points."""
    seen = _projected(joint, mesh, across)
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    squares = np.square(seen).sum(axis=1) + np.square(seen.sum(axis=1))  # 12 times the mean square over a triangle
    long_side = np.exp(0.5j * np.angle(areas @ squares))
    points = np.unique(seen)
    is_ahead = (points * np.conj(long_side)).real > 0.0
    return np.array([_tip(points[is_ahead]), _tip(points[~is_ahead])])


def _tip(points: C128) -> complex:
    distances = np.abs(points)
    return complex(points[distances >= TIP_SHARE * distances.max()].mean()) if len(points) else 0j


@dataclass(frozen=True)
class _TipPairing:
    """Paired tips of a part and its parent: `angles` from the part's tips to the parent's.

    `count` pairs consist of true tips, nearest first; `tip` is the parent's tip of the first pair.
    """

    angles: tuple[float, float]
    count: int
    tip: complex

    @classmethod
    def of(cls, own: C128, fixed: C128, farthest: float) -> _TipPairing:
        angles = np.angle(fixed * np.conj(own))
        is_tip = np.minimum(np.abs(own), np.abs(fixed)) >= MIN_TIP_SHARE * farthest
        order = np.argsort(np.where(is_tip, np.abs(angles), np.inf))
        return cls((float(angles[order[0]]), float(angles[order[1]])), int(is_tip.sum()), complex(fixed[order[0]]))
