"""Predictions of a motion GNN, made from labels or by hand."""

from __future__ import annotations

import numpy as np

from kinmo.core.motion_types import MotionType
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions


def predictions_from_labels(shape: PreparedShape, probability: float = 0.9) -> EdgePredictions:
    """Predictions that repeat the labels, with the given probability for the true types."""
    labels = shape.edge_labels
    probabilities = np.full((len(shape.edges), 10), (1 - probability) / 9)
    probabilities[np.arange(len(shape.edges)), labels.types] = probability
    directions = np.where(labels.types[:, None] < MotionType.FIXED, labels.directions, [0.0, 1.0, 0.0])
    return EdgePredictions(probabilities, directions, labels.pivots)


def uniform_predictions(shape: PreparedShape, **probabilities: float) -> EdgePredictions:
    """Predictions with the same type probabilities, given by the names of types, for every edge."""
    types = np.zeros((len(shape.edges), len(MotionType)))
    for name, probability in probabilities.items():
        types[:, MotionType[name]] = probability
    return EdgePredictions(types, np.tile([0.0, 1.0, 0.0], (len(types), 1)), np.zeros((len(types), 3)))
