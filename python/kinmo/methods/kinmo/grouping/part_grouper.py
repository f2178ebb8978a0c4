"""Prediction by trained grouping networks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from kinmo.config import GroupingConfig
from kinmo.learning.weights import load_weights, pick_device
from kinmo.methods.kinmo.grouping.grouping_batches import collate_graphs
from kinmo.methods.kinmo.grouping.grouping_network import KIND, grouping_networks, mean_logits
from kinmo.methods.kinmo.grouping.leaf_graph import LeafGraph

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Grouping:
    """Answers of the networks about a shape with L leaves and P pairs of touching leaves.

    Attributes:
        pairs ([P, 2] int64): Positions of the leaves, each pair once.
        logits ([P] float64): Logits that the two belong to one body.
        moves ([L] float64): Probabilities that a leaf belongs to a body that moves.
    """

    pairs: NDArray[np.int64]
    logits: F64
    moves: F64


class PartGrouper:
    """Trained grouping networks, whose mean logits count. `hide_names` hides the names of parts from them."""

    def __init__(self, networks: nn.ModuleList, device: str, hide_names: bool) -> None:
        self.networks, self.device, self.hide_names = networks.to(device).eval(), device, hide_names

    @classmethod
    def load(cls, weights: Path, device: str = "auto", hide_names: bool = False) -> PartGrouper:
        """Read weights that `train_part_grouping` wrote.

        Raises:
            InputError: The weights are those of another network, or cut off.
        """
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        leaf_features, pair_features = loaded.sizes("leaf_features", "pair_features")
        networks = grouping_networks(loaded.typed_config(GroupingConfig), leaf_features, pair_features)
        loaded.fill(networks)
        return cls(networks, device, hide_names)

    @torch.inference_mode()
    def group(self, graph: LeafGraph, *, hide_names: bool = False, hide_hierarchy: bool = False) -> Grouping:
        """Probabilities for the leaves of a shape, with names and hierarchy shown unless they are hidden."""
        hidden = float(self.hide_names or hide_names)
        batch = collate_graphs([graph], hide_names=hidden, hide_hierarchy=float(hide_hierarchy))
        same_body, moves = mean_logits(self.networks, batch.to(torch.device(self.device)))
        half = len(graph.pairs) // 2
        return Grouping(graph.pairs[:half], same_body[:half].cpu().double().numpy(), moves.sigmoid().cpu().double().numpy())
