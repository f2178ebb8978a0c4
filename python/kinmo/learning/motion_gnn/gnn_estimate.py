"""Estimate of the motion GNN for one rigid body, from the predictions for the edges of its parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GnnEstimate:
    """Estimated motion of one body.

    Attributes:
        type_set: Enumeration that the probabilities are over.
        probabilities: Probability of each type [T].
        direction: Unit axis direction [3].
        pivot: Point on the axis [3] in the normalised frame.
    """

    type_set: type[MotionType] | type[CoarseType]
    probabilities: F64
    direction: F64
    pivot: F64

    @property
    def type(self) -> MotionType | CoarseType:
        """Most probable type."""
        return self.type_set(int(np.argmax(self.probabilities)))


def mean_estimate(predictions: EdgePredictions, edges: NDArray[np.int64]) -> GnnEstimate:
    """Mean of the predictions for some edges of a shape, given by at least one index.

    Directions and pivots are weighted by the probability of a motion. Directions are averaged regardless of their sign.
    """
    probabilities = predictions.type_probabilities[edges]
    weights = probabilities[:, : predictions.type_set.FIXED].sum(axis=1) + 1e-9
    weights /= weights.sum()
    directions = predictions.directions[edges]
    heaviest = directions[np.argmax(weights)]
    directions = directions * np.where(directions @ heaviest < 0, -1.0, 1.0)[:, None]
    direction = weights @ directions
    direction /= np.linalg.norm(direction)
    return GnnEstimate(predictions.type_set, probabilities.mean(axis=0), direction, weights @ predictions.pivots[edges])


def gnn_joint(estimate: GnnEstimate | None) -> JointEstimate:
    """Joint estimate from the network alone, in the normalised frame and without limits; no motion where `estimate` is None."""
    if estimate is None:
        return JointEstimate(None, MotionType.NONE, 1.0)
    kind = estimate.type.kind
    joint = None if kind is None else Joint(kind, estimate.direction, estimate.pivot)
    return JointEstimate(joint, estimate.type, float(np.max(estimate.probabilities)))
