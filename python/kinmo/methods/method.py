"""The interface of both methods, and the networks that they share."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.prediction import Prediction
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor

NETWORKS_KEPT = 8
"""Networks of each kind that stay in memory."""


class Method(Protocol):
    """A trained method: it predicts the joints of shapes, in each shape's own frame and lengths."""

    @property
    def name(self) -> str:
        """Name of the method: `kinmo` or `paper`."""

    @property
    def weights(self) -> str:
        """Hash of all networks that take part."""

    @property
    def config(self) -> Mapping[str, Any]:
        """Everything else that predictions depend on, as plain data."""

    @property
    def is_fine(self) -> bool:
        """True if it tells ten motion types apart, False for five."""

    @property
    def finds_parents(self) -> bool:
        """True if, with parts given, it also predicts what every body is attached to."""

    def check(self) -> None:
        """Raise InputError if one of the networks is missing or cannot be read."""

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """Predict bodies and joints from the hierarchy (setting *hierarchy given*).

        Args:
            shape: the prepared shape.
            meshes: meshes of its leaves, in the normalised frame (`prepared_shape.leaf_meshes`).
        """

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """Predict the joints of the annotated bodies (setting *parts given*)."""

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """Predict with the true motion types given, at least for the bodies whose type `predict_given` gets wrong."""

    def edge_types(self, shape: PreparedShape) -> NDArray[np.int64] | None:
        """Predicted motion type [E] of every edge; None if the method does not use edges."""


def load_gnn(weights: Path, device: str, hide_names: bool) -> MotionGnnPredictor:
    """The motion GNN of a file of weights, kept in memory until the file changes."""
    return _load_gnn(weights, weights.stat().st_mtime_ns, device, hide_names)


@lru_cache(maxsize=NETWORKS_KEPT)
def _load_gnn(weights: Path, written: int, device: str, hide_names: bool) -> MotionGnnPredictor:
    return MotionGnnPredictor.load(weights, device, hide_names)
