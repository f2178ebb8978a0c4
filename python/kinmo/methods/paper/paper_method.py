"""The paper's method: motion GNN, mobility tree, candidate axes, axis selection (paper, section 3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.model_folder import ModelFolder
from kinmo.learning.motion_gnn.gnn_network import TypeSet
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor
from kinmo.methods.method import CACHED_NETWORKS, load_gnn
from kinmo.methods.paper.axis_selection.axis_selector import AxisSelector
from kinmo.methods.paper.mobility_tree import (
    MobilityTree,
    tree_with_given_bodies,
    tree_with_predicted_bodies,
    with_true_types,
)
from kinmo.methods.paper.refinement import Refiner


@dataclass(frozen=True)
class PaperMethod:
    """The paper's method with fine (ten) or coarse (five) motion types.

    Networks are read from `models` when they are first needed. Networks trained for one category alone take precedence.

    Attributes:
        models: The folder with the trained networks.
        refinement: Candidates of the refinement, and weights of their scores.
        types: `fine` or `coarse`.
        device: Where networks run.
        hide_names: Hide the names of all parts.
        contact_edges: Use the GNN that was trained on edges between touching parts alone.
        name: Name of the method.
        finds_parents: False: with parts given, the method does not predict parents of bodies.
    """

    models: ModelFolder
    refinement: RefinementConfig
    types: TypeSet = "fine"
    device: str = "auto"
    hide_names: bool = False
    contact_edges: bool = False
    name: str = "paper"
    finds_parents: bool = False

    @property
    def model_names(self) -> tuple[str, ...]:
        """Names of its models in the folder of trained networks."""
        return self._gnn_model, "axis"

    @cached_property
    def weights(self) -> str:
        """Hash of all networks of the method."""
        return self.models.digest(self.model_names)

    def check(self) -> None:
        """Check that all networks can be read.

        Raises:
            InputError: A network is missing or cannot be read.
        """
        for path in self.models.all_weights(self._gnn_model):
            load_gnn(path, self.device, self.hide_names)
        for path in self.models.all_weights("axis"):
            _load_selector(path, path.stat().st_mtime_ns, self.device)

    @property
    def is_fine(self) -> bool:
        """True for ten motion types, False for five."""
        return self.types == "fine"

    @property
    def config(self) -> Mapping[str, Any]:
        """Settings that predictions depend on, as plain data."""
        return {"types": self.types, "refinement": to_table(self.refinement), "hide_names": self.hide_names}

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict bodies and joints (setting *hierarchy given*); see `Method.predict`."""
        return self._refine(shape, meshes, tree_with_predicted_bodies(shape, self._gnn(shape).predict_edges(shape)))

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies (setting *parts given*); see `Method.predict_given`."""
        return self._refine(shape, meshes, tree_with_given_bodies(shape, self._gnn(shape).predict_edges(shape)))

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the bodies whose type the GNN predicts wrongly, with their true types."""
        tree = tree_with_given_bodies(shape, self._gnn(shape).predict_edges(shape))
        return self._refine(shape, meshes, with_true_types(tree, shape.body_types))

    def edge_types(self, shape: PreparedShape) -> NDArray[np.int64]:
        """Predicted motion type [E] of every edge."""
        return self._gnn(shape).predict_edges(shape).types

    @property
    def _gnn_model(self) -> str:
        return "gnn_contact" if self.contact_edges else f"gnn_{self.types}"

    def _gnn(self, shape: PreparedShape) -> MotionGnnPredictor:
        return load_gnn(self.models.weights_for(self._gnn_model, shape.category), self.device, self.hide_names)

    def _refine(self, shape: PreparedShape, meshes: _core.Meshes, tree: MobilityTree) -> ShapeEstimate:
        weights = self.models.weights_for("axis", shape.category)
        selector = _load_selector(weights, weights.stat().st_mtime_ns, self.device)
        return Refiner(shape, self.refinement, selector, meshes).refine(tree, self.name)


@lru_cache(maxsize=CACHED_NETWORKS)
def _load_selector(weights: Path, written: int, device: str) -> AxisSelector:
    return AxisSelector.load(weights, device)
