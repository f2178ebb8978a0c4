"""Ranked joints of one part, from the probabilities of its candidate joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import KINDS, Joint, JointKind
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.core.oriented_box import Box
from kinmo.core.shape_estimate import JointEstimate
from kinmo.features.candidate_features import CandidateFeatures

F64 = NDArray[np.float64]

SAME_DIRECTION = np.cos(np.radians(5.0))
"""Least cosine between the axes of equal joints (5 degrees, the strict measure of a correct joint)."""
SAME_LINE = 0.05
"""Largest distance between the axes of equal joints, in diagonals (the strict measure of a correct joint)."""
MIN_REST_PROBABILITY = 0.5
"""Probability of rest from which a part rests."""
MAX_JOINTS = 5
"""Largest number of ranked joints per part."""
DIGITS = 9
"""Digits that sums of probabilities are rounded to, so that the order of summation does not matter."""


def parallel(directions: F64) -> NDArray[np.bool_]:
    """Pairs [C, C] of candidates with the same direction [C, 3] by the strict measure."""
    return np.asarray(np.abs(directions @ directions.T) >= SAME_DIRECTION)


def agreement(kinds: NDArray[np.int64], directions: F64, pivots: F64) -> NDArray[np.bool_]:
    """Pairs [C, C] of candidates that are the same joint by the strict measure, at the pivots nearest to the part's centre."""
    kind = kinds[:, None] == kinds[None]
    offset = pivots[:, None] - pivots[None]
    offset -= np.einsum("abi,ai->ab", offset, directions)[..., None] * directions[:, None]
    close = (np.linalg.norm(offset, axis=-1) <= SAME_LINE) | (kinds == JointKind.PRISMATIC.code)[:, None]
    return np.asarray(kind & parallel(directions) & close)


def same_joint(first: Joint, second: Joint) -> bool:
    """True if two joints are the same by the strict measure, at the pivot of the second."""
    if first.kind is not second.kind or abs(float(first.direction @ second.direction)) < SAME_DIRECTION:
        return False
    offset = second.pivot - first.pivot
    offset = offset - (offset @ first.direction) * first.direction
    return first.kind is JointKind.PRISMATIC or float(np.linalg.norm(offset)) <= SAME_LINE


def rank_joints(
    features: CandidateFeatures, group: int, probabilities: F64, rest: float, box: Box, up: F64
) -> tuple[JointEstimate, ...]:
    """Ranked joints of one group, best first, in the normalised frame.

    There is one estimate without a joint: the first of all if the group rests, the last otherwise.
    The score of a joint is the total probability of all candidates that agree with it: the probability that it is correct by
    the strict measure. Joints are ordered by the sum of their score, the probability of their kind, and the probability of
    their direction. Several uncertain hinges at upright edges can so outweigh one more probable horizontal hinge.

    The probabilities of the group's candidates [C] and of `rest` sum to one. Motion types depend on the symmetry-aligned box of
    the group and on the unit vector `up`.
    """
    rows = features.rows(group)
    kinds, directions, pivots = features.kinds[rows], features.directions[rows], features.pivots[rows]
    agree = agreement(kinds, directions, pivots)
    support = agree @ probabilities
    kind_probability = np.array([probabilities[kinds == kind].sum() for kind in range(len(KINDS))])
    order_by = np.round(support + kind_probability[kinds] + parallel(directions) @ probabilities, DIGITS)
    joints: list[JointEstimate] = []
    covered = np.zeros(len(kinds), bool)
    for index in np.lexsort((-probabilities, -order_by)):
        if covered[index] or len(joints) == MAX_JOINTS:
            continue
        alike = np.flatnonzero(agree[index] & ~covered)
        best = int(alike[np.argmax(probabilities[alike])])
        covered |= agree[index]
        joint = Joint(KINDS[int(kinds[best])], directions[best], pivots[best])
        terms = {"moves": 1.0 - rest, "kind": float(kind_probability[kinds[best]]), "axis": float(probabilities[best])}
        joints.append(JointEstimate(joint, motion_type(joint, box, up), float(support[index]), terms, "ranking"))
    at_rest = JointEstimate(None, MotionType.FIXED, rest, {"moves": 1.0 - rest}, "ranking")
    return (at_rest, *joints) if rest >= MIN_REST_PROBABILITY else (*joints, at_rest)
