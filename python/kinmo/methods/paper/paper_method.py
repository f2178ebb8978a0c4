"""The paper's method: motion GNN, mobility tree, candidate axes, axis selection (paper, section 3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.model_folder import ModelFolder
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_network import TypeSet
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor
from kinmo.methods.method import Method, load_network
from kinmo.methods.paper.axis_selection.axis_selector import AxisSelector
from kinmo.methods.paper.mobility_tree import (
    MobilityTree,
    tree_with_given_bodies,
    tree_with_predicted_bodies,
    with_true_types,
)
from kinmo.methods.paper.refinement import Refiner


@dataclass(frozen=True)
class PaperMethod(Method):
    """The paper's method with fine (ten) or coarse (five) motion types.

    Attributes:
        models: The folder with the trained networks.
        refinement: Candidates of the refinement, and weights of their scores.
        types: `fine` or `coarse`.
        device: Where networks run.
        hide_names: Hide the names of all parts.
        contact_edges: Use the GNN that was trained on edges between touching parts alone.
    """

    models: ModelFolder
    refinement: RefinementConfig
    types: TypeSet = "fine"
    device: str = "auto"
    hide_names: bool = False
    contact_edges: bool = False
    name: ClassVar[str] = "paper"
    finds_parents: ClassVar[bool] = False

    @property
    def model_names(self) -> tuple[str, ...]:
        """Names of its models in the folder of trained networks."""
        return "gnn_contact" if self.contact_edges else f"gnn_{self.types}", "axis"

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
        return self._refine(shape, meshes, tree_with_predicted_bodies(shape, self._edges(shape)))

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies (setting *parts given*); see `Method.predict_given`."""
        return self._refine(shape, meshes, tree_with_given_bodies(shape, self._edges(shape)))

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the bodies whose type the GNN predicts wrongly, with their true types."""
        tree = tree_with_given_bodies(shape, self._edges(shape))
        return self._refine(shape, meshes, with_true_types(tree, shape.body_types))

    def edge_types(self, shape: PreparedShape) -> NDArray[np.int64]:
        """Predicted motion type [E] of every edge."""
        return self._edges(shape).types

    def _refine(self, shape: PreparedShape, meshes: _core.Meshes, tree: MobilityTree) -> ShapeEstimate:
        return Refiner(shape, self.refinement, self._network("axis", shape), meshes).refine(tree)

    def _edges(self, shape: PreparedShape) -> EdgePredictions:
        """Predictions of the motion GNN."""
        gnn: MotionGnnPredictor = self._network(self.model_names[0], shape)
        return gnn.predict_edges(shape)

    def _load(self, model: str, weights: Path) -> Any:
        if model == "axis":
            return load_network(AxisSelector.load, weights, self.device)
        return load_network(MotionGnnPredictor.load, weights, self.device, self.hide_names)
