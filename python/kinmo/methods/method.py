"""Interface of both methods, and the motion GNN that they share."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor

CACHED_NETWORKS = 8
"""Number of networks of each kind that stay in memory."""


class Method(Protocol):
    """A trained method: it predicts the joints of shapes, in each shape's own frame and lengths."""

    @property
    def name(self) -> str:
        """Name of the method: `kinmo` or `paper`."""

    @property
    def model_names(self) -> tuple[str, ...]:
        """Names of its models in the folder of trained networks."""

    @property
    def weights(self) -> str:
        """Hash of all networks of the method."""

    @property
    def config(self) -> Mapping[str, Any]:
        """Settings that predictions depend on, as plain data."""

    @property
    def is_fine(self) -> bool:
        """True for ten motion types, False for five."""

    @property
    def finds_parents(self) -> bool:
        """True if, with parts given, the method also predicts the parent of every body."""

    def check(self) -> None:
        """Check that all networks can be read.

        Raises:
            InputError: A network is missing or cannot be read.
        """

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict bodies and joints (setting *hierarchy given*).

        Args:
            shape: The prepared shape; its annotation is not used.
            meshes: Meshes of its leaves, in the normalised frame (`prepared_shape.leaf_meshes`).

        Returns:
            Bodies, ranked joints and limits in the shape's own frame.
        """

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies (setting *parts given*).

        Args:
            shape: An annotated shape; joints and parents of the annotation are not used.
            meshes: Meshes of its leaves, in the normalised frame.

        Returns:
            Ranked joints and limits of the annotated bodies, in the shape's own frame.
        """

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict axes with the true motion types given, at least for the bodies whose type `predict_given` gets wrong."""

    def edge_types(self, shape: PreparedShape) -> NDArray[np.int64] | None:
        """Predicted motion type [E] of every edge; None if the method does not use edge types by themselves."""


def load_gnn(weights: Path, device: str, hide_names: bool) -> MotionGnnPredictor:
    """Load a motion GNN. It stays in memory until its file changes.

    Args:
        weights: File of the weights.
        device: Where the network runs: auto, cpu, cuda, cuda:1, mps.
        hide_names: Hide the names of all parts from the network.

    Raises:
        InputError: The file is not a whole file of GNN weights.
    """
    return _load_gnn(weights, weights.stat().st_mtime_ns, device, hide_names)


@lru_cache(maxsize=CACHED_NETWORKS)
def _load_gnn(weights: Path, written: int, device: str, hide_names: bool) -> MotionGnnPredictor:
    return MotionGnnPredictor.load(weights, device, hide_names)
