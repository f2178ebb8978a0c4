"""Feasibility and consistency of candidate joints (paper, section 3.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.features.candidate_joints import Candidates

F64 = NDArray[np.float64]
PositionReading = Literal["line", "printed"]

TERMS = ("feasibility", "direction", "position", "sweep")
"""s^f, s^d, s^p of the paper, and the share of the part's travel that is free."""


@dataclass(frozen=True, eq=False)
class Scores:
    """`total` [C] in [0, 1], and the `terms` [C] that it is made of."""

    total: F64
    terms: Mapping[str, F64]


def direction_similarity(direction: F64, candidates: Candidates) -> F64:
    """s^d [C] = |cos| of the angle between the predicted direction [3] and each candidate's.

    Printed without the absolute value, although the edges of a box have no sense.
    """
    return np.asarray(np.abs(candidates.directions @ direction) / np.linalg.norm(direction))


def position_similarity(pivot: F64, candidates: Candidates, reading: PositionReading = "line", length: float = 1.0) -> F64:
    """s^p [C] for the predicted pivot [3].

    `line`: max(0, 1 - ||(p - p_i) x d_i|| / (||d_i|| length)), one minus the distance of p from the candidate's line, in the
    form of the position loss. `printed`: 1 - ||(p - p_i) x p|| / ||p_i||, which changes with the origin; kept within [0, 1],
    and 0 at p_i = 0.
    """
    offset = pivot - candidates.pivots
    if reading == "line":
        across = np.linalg.norm(np.cross(offset, candidates.directions), axis=1)
        return np.asarray(np.maximum(0.0, 1.0 - across / (np.linalg.norm(candidates.directions, axis=1) * length)))
    lengths = np.linalg.norm(candidates.pivots, axis=1)
    across = np.linalg.norm(np.cross(offset, np.broadcast_to(pivot, offset.shape)), axis=1)
    safe = np.where(lengths > 0, lengths, 1.0)
    return np.where(lengths > 0, np.clip(1.0 - across / safe, 0.0, 1.0), 0.0)


def score(
    candidates: Candidates,
    direction: F64,
    pivot: F64,
    feasibility: F64 | None = None,
    sweep: F64 | None = None,
    *,
    weights: tuple[float, ...] = (0.5, 0.3, 0.2, 0.0),
    reading: PositionReading = "line",
) -> Scores:
    """S = w_f s^f + w_d s^d + w_p s^p (+ w_s times the sweep term), with `weights` in the order of TERMS.

    `direction` and `pivot` [3] are the network's; `feasibility` and `sweep` [C] are in [0, 1]. The position has no meaning for
    prismatic joints, and a term that is not given has none for any: the other weights are then scaled up to the same sum.
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
    return Scores(total / np.where(weight_sum > 0, weight_sum, 1.0), {name: values[name] for name in TERMS if name in values})
