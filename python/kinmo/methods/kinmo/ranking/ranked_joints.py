"""From probabilities of hypotheses to ranked answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.box import Box
from kinmo.core.edge_labels import motion_type
from kinmo.core.joint import KINDS, Joint, JointKind, MotionType
from kinmo.core.prediction import JointEstimate
from kinmo.features.candidate_features import PRISMATIC, Evidence

F64 = NDArray[np.float64]

AGREE_DIRECTION = np.cos(np.radians(5.0))
AGREE_LINE = 0.05
"""Answers within 5 degrees and 0.05 diagonals of each other count as the same (the strict measure of a joint)."""
MOVES = 0.5
ALTERNATIVES = 5
DIGITS = 9
"""Of a sum of probabilities: the order of its terms must not decide."""


def parallel(directions: F64) -> NDArray[np.bool_]:
    """Which hypotheses [h, h] have the same direction by the strict measure."""
    same: NDArray[np.bool_] = np.abs(directions @ directions.T) >= AGREE_DIRECTION
    return same


def agreement(kinds: NDArray[np.int64], directions: F64, pivots: F64) -> NDArray[np.bool_]:
    """Which hypotheses [h, h] are the same answer by the strict measure. Pivots are the points nearest the part's centre."""
    kind = kinds[:, None] == kinds[None]
    offset = pivots[:, None] - pivots[None]
    offset -= np.einsum("abi,ai->ab", offset, directions)[..., None] * directions[:, None]
    close = (np.linalg.norm(offset, axis=-1) <= AGREE_LINE) | (kinds == PRISMATIC)[:, None]
    agree: NDArray[np.bool_] = kind & parallel(directions) & close
    return agree


def same_joint(first: Joint, second: Joint) -> bool:
    """Whether two joints are the same answer by the strict measure, at the second one's pivot."""
    if first.kind is not second.kind or abs(float(first.direction @ second.direction)) < AGREE_DIRECTION:
        return False
    offset = second.pivot - first.pivot
    offset = offset - (offset @ first.direction) * first.direction
    return first.kind is JointKind.PRISMATIC or float(np.linalg.norm(offset)) <= AGREE_LINE


def rank_answers(
    evidence: Evidence, unit: int, probabilities: F64, rest: float, box: Box, up: F64
) -> tuple[JointEstimate, ...]:
    """Ranked answers for one unit, in the normalised frame; the first one is what kinmo says.

    `probabilities` [h] of the unit's hypotheses and `rest`, that of not moving, sum to one. The score of a hypothesis is the
    probability of all that agree with it, so it is the chance that the answer is right by the strict measure. A part that
    rather rests gets that as its first answer, its best joint as the second.

    Answers are ordered by their score, the probability of their kind and that of their direction, whatever the kind, together:
    several doubtful hinges at upright edges speak against a single surer one that lies across.
    """
    rows = evidence.rows(unit)
    kinds, directions, pivots = evidence.kinds[rows], evidence.directions[rows], evidence.pivots[rows]
    agree = agreement(kinds, directions, pivots)
    support = agree @ probabilities
    kind_mass = np.array([probabilities[kinds == kind].sum() for kind in range(len(KINDS))])
    favour = np.round(support + kind_mass[kinds] + parallel(directions) @ probabilities, DIGITS)
    order = np.lexsort((-probabilities, -favour))
    answers: list[JointEstimate] = []
    covered = np.zeros(len(kinds), bool)
    for index in order:
        if covered[index] or len(answers) == ALTERNATIVES:
            continue
        strongest = int(np.flatnonzero(agree[index] & ~covered)[np.argmax(probabilities[agree[index] & ~covered])])
        covered |= agree[index]
        joint = Joint(KINDS[int(kinds[strongest])], directions[strongest], pivots[strongest])
        terms = {"moves": 1.0 - rest, "kind": float(kind_mass[int(kinds[strongest])]), "axis": float(probabilities[strongest])}
        answers.append(JointEstimate(joint, motion_type(joint, box, up), float(support[index]), terms, "ranking"))
    still = JointEstimate(None, MotionType.FIXED, rest, {"moves": 1.0 - rest}, "ranking")
    return (still, *answers) if rest >= MOVES else (*answers, still)
