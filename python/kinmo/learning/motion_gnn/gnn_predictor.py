"""Predictions of a trained motion GNN."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
import torch

from kinmo.config import GnnConfig
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_batches import batch_groups, shape_graph, subsampled, used_edges, without_names
from kinmo.learning.motion_gnn.gnn_network import CLASSES, KIND, EdgeOutput, MotionGnn, TypeSet
from kinmo.learning.motion_gnn.hierarchy_graph import batch_graphs
from kinmo.learning.weights import load_weights, pick_device


class MotionGnnPredictor:
    """A trained motion GNN with the configuration that it was trained with; `hide_names` hides the names of parts from it."""

    def __init__(self, network: MotionGnn, config: GnnConfig, device: str, hide_names: bool = False) -> None:
        self.network, self.config, self.device = network.to(device).eval(), config, device
        self.hide_names = hide_names
        self._known: WeakKeyDictionary[PreparedShape, EdgePredictions] = WeakKeyDictionary()

    @classmethod
    def load(cls, weights: Path, device: str = "auto", hide_names: bool = False) -> MotionGnnPredictor:
        """Load the weights that `train_motion_gnn` wrote.

        Raises:
            InputError: The file does not hold the weights of a motion GNN, or is cut.
        """
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config = loaded.typed_config(GnnConfig)
        types: TypeSet = "coarse" if loaded.facts.get("types") == "coarse" else "fine"
        network = MotionGnn(config, CLASSES[types])
        loaded.fill(network)
        return cls(network, config, device, hide_names)

    def predict_edges(self, shape: PreparedShape) -> EdgePredictions:
        """Predictions for every edge of a shape, in the normalised frame; edges that the network does not see are NONE.

        The predictions are kept for as long as the shape is in memory.
        """
        if shape not in self._known:
            self._known[shape] = self.predict_many([shape])[0]
        return self._known[shape]

    @torch.inference_mode()
    def predict_many(self, shapes: Sequence[PreparedShape]) -> list[EdgePredictions]:
        """Predictions for the edges of several shapes, computed in batches."""
        graphs = [subsampled(shape_graph(shape, self.config), self.config.leaf.points) for shape in shapes]
        if self.hide_names:
            graphs = [without_names(graph) for graph in graphs]
        outputs: list[EdgeOutput] = []
        for group in batch_groups(graphs, self.config):
            batch = batch_graphs(group).to(self.device)
            columns = [torch.split(values.cpu().double(), list(batch.edge_counts)) for values in self.network(batch)]
            outputs += map(EdgeOutput._make, zip(*columns, strict=True))
        return [self._all_edges(shape, output) for shape, output in zip(shapes, outputs, strict=True)]

    def _all_edges(self, shape: PreparedShape, output: EdgeOutput) -> EdgePredictions:
        """Predictions for all edges of a shape from those that the network sees."""
        count, used = len(shape.edges), used_edges(shape, self.config)
        probabilities = np.zeros((count, self.network.types))
        probabilities[:, -1] = 1.0  # NONE, the last of the fine and of the coarse types
        probabilities[used] = output.logits.softmax(1).numpy()
        directions = np.tile(shape.up, (count, 1))
        predicted = output.directions.numpy()
        lengths = np.linalg.norm(predicted, axis=1, keepdims=True)
        directions[used] = np.where(lengths > 1e-9, predicted / np.maximum(lengths, 1e-9), shape.up)
        pivots = np.zeros((count, 3))
        pivots[used] = output.pivots.numpy()
        return EdgePredictions(probabilities, directions, pivots)
