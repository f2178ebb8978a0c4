"""Asking a trained motion GNN."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
import torch

from kinmo.config import GnnConfig
from kinmo.core.joint import CoarseType, MotionType
from kinmo.core.typed_tables import from_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_batches import grouped, shape_graph, thinned, used_edges, without_names
from kinmo.learning.motion_gnn.gnn_network import CLASSES, KIND, EdgeOutput, MotionGnn, TypeSet
from kinmo.learning.motion_gnn.hierarchy_graph import batch_graphs
from kinmo.learning.weights import load_weights, pick_device


class MotionGnnPredictor:
    """A trained network with its configuration. `hide_names` keeps the names of parts from it."""

    def __init__(self, network: MotionGnn, config: GnnConfig, device: str, sha256: str = "", hide_names: bool = False) -> None:
        self.network, self.config, self.device = network.to(device).eval(), config, device
        self.sha256, self.hide_names = sha256, hide_names
        self._known: WeakKeyDictionary[PreparedShape, EdgePredictions] = WeakKeyDictionary()

    @classmethod
    def load(cls, weights: Path, device: str = "auto", hide_names: bool = False) -> MotionGnnPredictor:
        """Read `weights.safetensors` of `train_motion_gnn`. Raises InputError if they are not a motion GNN's, or not whole."""
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config = from_table(GnnConfig, loaded.config, weights.with_suffix(".json"), "config.")
        types: TypeSet = "coarse" if loaded.facts.get("types") == "coarse" else "fine"
        network = MotionGnn(config, CLASSES[types])
        loaded.fill(network)
        return cls(network, config, device, loaded.sha256, hide_names)

    def predict_edges(self, shape: PreparedShape) -> EdgePredictions:
        """What the network says of every edge of `shape`, in the normalised frame; edges it does not see are NONE.

        A shape is looked at once for as long as it is in memory.
        """
        if shape not in self._known:
            self._known[shape] = self.predict_many([shape])[0]
        return self._known[shape]

    @torch.inference_mode()
    def predict_many(self, shapes: Sequence[PreparedShape]) -> list[EdgePredictions]:
        """`predict_edges` of several shapes, batched."""
        graphs = [thinned(shape_graph(shape, self.config), self.config.leaf.points) for shape in shapes]
        if self.hide_names:
            graphs = [without_names(graph) for graph in graphs]
        pieces: list[EdgeOutput] = []
        for group in grouped(graphs, self.config):
            batch = batch_graphs(group).to(self.device)
            output = EdgeOutput(*(values.cpu().double() for values in self.network(batch)))
            pieces += map(
                EdgeOutput._make, zip(*(torch.split(values, list(batch.edge_counts)) for values in output), strict=True)
            )
        return [self._whole(shape, output) for shape, output in zip(shapes, pieces, strict=True)]

    def _whole(self, shape: PreparedShape, output: EdgeOutput) -> EdgePredictions:
        none = MotionType.NONE if self.network.types == len(MotionType) else CoarseType.NONE
        count, used = len(shape.edges), used_edges(shape, self.config)
        probabilities = np.zeros((count, self.network.types))
        probabilities[:, none] = 1.0
        probabilities[used] = output.logits.softmax(1).numpy()
        directions = np.tile(shape.up, (count, 1))
        found = output.directions.numpy()
        lengths = np.linalg.norm(found, axis=1, keepdims=True)
        directions[used] = np.where(lengths > 1e-9, found / np.maximum(lengths, 1e-9), shape.up)
        pivots = np.zeros((count, 3))
        pivots[used] = output.pivots.numpy()
        return EdgePredictions(probabilities, directions, pivots)
