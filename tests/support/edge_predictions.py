"""Predictions of the motion GNN that repeat the labels."""

from __future__ import annotations

import numpy as np

from kinmo.core.joint import MotionType
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions


def told(shape: PreparedShape, sure: float = 0.9) -> EdgePredictions:
    """Predictions that say what the labels say."""
    labels = shape.edge_labels
    probabilities = np.full((len(shape.edges), 10), (1 - sure) / 9)
    probabilities[np.arange(len(shape.edges)), labels.types] = sure
    directions = np.where(labels.types[:, None] < MotionType.FIXED, labels.directions, [0.0, 1.0, 0.0])
    return EdgePredictions(probabilities, directions, labels.pivots)
