"""Scores of candidate axes: direction similarity, position similarity, and the final score (paper, section 3.3).

The feasibility score s^f comes from the axis selection network (`kinmo.methods.paper.axis_selection`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.features.candidate_joints import CandidateJoints

F64 = NDArray[np.float64]
PositionReading = Literal["line", "printed"]

TERMS = ("feasibility", "direction", "position", "sweep")
"""Terms of the final score: s^f, s^d and s^p of the paper, and the share of the wanted travel that is free of collisions."""


@dataclass(frozen=True, eq=False)
class CandidateScores:
    """Scores of C candidates.

    Attributes:
        total ([C]): Final scores in [0, 1].
        terms ([C]): Values of the terms, by their names in `TERMS`.
    """

    total: F64
    terms: Mapping[str, F64]


def direction_similarity(direction: F64, candidates: CandidateJoints) -> F64:
    """Direction similarity s^d [C] (paper, section 3.3, equation 5): |cos| of the angles between d [3] and the candidates' d_i.

    The paper prints it without the absolute value, but edges of a box have no sense.
    """
    return np.asarray(np.abs(candidates.directions @ direction) / np.linalg.norm(direction))


def position_similarity(pivot: F64, candidates: CandidateJoints, reading: PositionReading = "line") -> F64:
    """Position similarity s^p [C] (paper, section 3.3, equation 6) of the position p [3] and the candidates' p_i and d_i.

    Reading `line`: `max(0, 1 - ||(p - p_i) x d_i|| / ||d_i||)`, one minus the distance of p from the candidate's line. It has
    the form of the position loss (equation 4). Reading `printed`: `1 - ||(p - p_i) x p|| / ||p_i||`, clipped to [0, 1], and 0
    for p_i = 0. It changes with the origin.
    """
    offset = pivot - candidates.pivots
    if reading == "line":
        distance = np.linalg.norm(np.cross(offset, candidates.directions), axis=1)
        return np.asarray(np.maximum(0.0, 1.0 - distance / np.linalg.norm(candidates.directions, axis=1)))
    lengths = np.linalg.norm(candidates.pivots, axis=1)
    numerator = np.linalg.norm(np.cross(offset, np.broadcast_to(pivot, offset.shape)), axis=1)
    safe = np.where(lengths > 0, lengths, 1.0)
    return np.where(lengths > 0, np.clip(1.0 - numerator / safe, 0.0, 1.0), 0.0)


def score_candidates(
    candidates: CandidateJoints,
    direction: F64,
    pivot: F64,
    feasibility: F64 | None = None,
    sweep: F64 | None = None,
    *,
    weights: tuple[float, ...] = (0.5, 0.3, 0.2, 0.0),
    reading: PositionReading = "line",
) -> CandidateScores:
    """Final score s_i = w_f s_i^f + w_d s_i^d + w_p s_i^p (paper, section 3.3, equation 7), plus an optional sweep term.

    Positions have no meaning for prismatic joints. If a term is missing, the other weights are scaled up to the same sum.

    Args:
        candidates: C candidates.
        direction ([3]): Direction that the motion GNN predicts.
        pivot ([3]): Position that the motion GNN predicts.
        feasibility ([C]): Feasibility scores s^f in [0, 1]; None leaves the term out.
        sweep ([C]): Free share of the wanted travel, in [0, 1]; None leaves the term out.
        weights: Weights of the terms, in the order of `TERMS`.
        reading: Formula of the position similarity.
    """
    values = {"direction": direction_similarity(direction, candidates)}
    values["position"] = position_similarity(pivot, candidates, reading)
    if feasibility is not None:
        values["feasibility"] = feasibility
    if sweep is not None:
        values["sweep"] = sweep
    total, weight_sum = np.zeros(len(candidates)), np.zeros(len(candidates))
    slides = candidates.kinds == JointKind.PRISMATIC.code
    for name, weight in zip(TERMS, (*weights, 0.0), strict=False):
        if name in values:
            effective = np.where(slides & (name == "position"), 0.0, weight)
            total += effective * values[name]
            weight_sum += effective
    terms = {name: values[name] for name in TERMS if name in values}
    return CandidateScores(total / np.where(weight_sum > 0, weight_sum, 1.0), terms)
