"""The motion GNN's estimate for one rigid body, taken from the edges of its parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import CoarseType, Joint, MotionType
from kinmo.core.prediction import JointEstimate
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GnnEstimate:
    """What is said of one body: `probabilities` over `type_set`, a unit `direction` [3], a `pivot` [3] (normalised)."""

    type_set: type[MotionType] | type[CoarseType]
    probabilities: F64
    direction: F64
    pivot: F64

    @property
    def type(self) -> MotionType | CoarseType:
        return self.type_set(int(np.argmax(self.probabilities)))


def mean_estimate(predictions: EdgePredictions, edges: NDArray[np.int64]) -> GnnEstimate:
    """The mean of some edges, at least one; directions and pivots count by how probable a motion is, directions regardless of
    their sense.
    """
    probabilities = predictions.type_probabilities[edges]
    weights = probabilities[:, : predictions.type_set.FIXED].sum(axis=1) + 1e-9
    weights /= weights.sum()
    directions = predictions.directions[edges]
    leader = directions[np.argmax(weights)]
    directions = directions * np.where(directions @ leader < 0, -1.0, 1.0)[:, None]
    direction = weights @ directions
    return GnnEstimate(
        predictions.type_set,
        probabilities.mean(axis=0),
        direction / np.linalg.norm(direction),
        weights @ predictions.pivots[edges],
    )


def gnn_joint(estimate: GnnEstimate | None) -> JointEstimate:
    """What the network says of one body by itself, in the normalised frame, without limits."""
    if estimate is None:
        return JointEstimate(None, MotionType.NONE, 1.0)
    kind = estimate.type.kind
    joint = None if kind is None else Joint(kind, estimate.direction, estimate.pivot)
    return JointEstimate(joint, estimate.type, float(np.max(estimate.probabilities)))
