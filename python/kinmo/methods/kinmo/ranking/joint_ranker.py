"""Prediction by trained ranking networks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from kinmo.config import RankingConfig
from kinmo.core.errors import InputError
from kinmo.learning.weights import load_weights, pick_device
from kinmo.methods.kinmo.ranking.ranking_batches import collate_views
from kinmo.methods.kinmo.ranking.ranking_network import KIND, mean_log_probabilities, ranking_networks
from kinmo.methods.kinmo.ranking.shape_views import ShapeView

F64 = NDArray[np.float64]


class JointRanker:
    """Trained ranking networks, whose mean probabilities count.

    `hide_names` hides the names of parts and categories from them, `hide_categories` those of categories alone.
    """

    def __init__(self, networks: nn.ModuleList, device: str, hide_names: bool, hide_categories: bool) -> None:
        self.networks, self.device = networks.to(device).eval(), device
        self.hide_names, self.hide_categories = hide_names, hide_categories

    @classmethod
    def load(cls, weights: Path, device: str = "auto", hide_names: bool = False) -> JointRanker:
        """Read weights that `train_joint_ranking` wrote.

        Raises:
            InputError: The weights are those of another network, or cut off.
        """
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config = loaded.typed_config(RankingConfig)
        candidate_features, group_features = (loaded.facts.get(name) for name in ("hypothesis_features", "unit_features"))
        if not (isinstance(candidate_features, int) and isinstance(group_features, int)):
            problem = "expected numbers hypothesis_features and unit_features: train again"
            raise InputError(weights.with_suffix(".json"), problem, "facts")
        networks = ranking_networks(config, candidate_features, group_features)
        loaded.fill(networks)
        return cls(networks, device, hide_names, not config.sees_categories)

    @torch.inference_mode()
    def probabilities(self, view: ShapeView) -> tuple[list[F64], F64]:
        """Probabilities [C] of the candidate joints of each of the U groups of a view, and probabilities of rest [U]."""
        batch = collate_views([view], hide_names=self.hide_names, hide_category=float(self.hide_categories))
        candidates, rest = mean_log_probabilities(self.networks, batch.to(torch.device(self.device)))
        flat = candidates.cpu().double().exp().numpy()
        counts = view.features.counts(view.groups)
        return np.split(flat, np.cumsum(counts)[:-1]), rest.cpu().double().exp().numpy()
