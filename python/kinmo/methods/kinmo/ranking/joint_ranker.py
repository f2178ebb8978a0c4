"""Prediction by trained ranking networks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from kinmo.config import RankingConfig
from kinmo.learning.weights import load_weights, pick_device
from kinmo.methods.kinmo.ranking.ranking_batches import collate_views
from kinmo.methods.kinmo.ranking.ranking_network import KIND, mean_log_probabilities, ranking_networks
from kinmo.methods.kinmo.ranking.shape_views import ShapeView

F64 = NDArray[np.float64]

MIN_CHANCE = 1e-6
"""Scores are taken as at least so far from 0 and 1 before they are calibrated."""


class JointRanker:
    """Trained ranking networks, whose mean probabilities count.

    `hide_names` hides the names of parts and categories from them.
    """

    def __init__(self, networks: nn.ModuleList, config: RankingConfig, device: str, hide_names: bool) -> None:
        self.networks, self.config, self.device = networks.to(device).eval(), config, device
        self.hide_names = hide_names

    @classmethod
    def load(cls, weights: Path, device: str = "auto", hide_names: bool = False) -> JointRanker:
        """Read weights that `train_joint_ranking` wrote.

        Raises:
            InputError: The weights are those of another network, or cut off.
        """
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config = loaded.typed_config(RankingConfig)
        candidate_features, group_features = loaded.sizes("hypothesis_features", "unit_features")
        networks = ranking_networks(config, candidate_features, group_features)
        loaded.fill(networks)
        return cls(networks, config, device, hide_names)

    @torch.inference_mode()
    def probabilities(self, view: ShapeView) -> tuple[list[F64], F64]:
        """Probabilities [C] of the candidate joints of each of the U groups of a view, and probabilities of rest [U]."""
        batch = collate_views([view], hide_names=self.hide_names, hide_category=float(not self.config.sees_categories))
        candidates, rest = mean_log_probabilities(self.networks, batch.to(torch.device(self.device)))
        flat = candidates.cpu().double().exp().numpy()
        counts = view.features.counts(view.groups)
        return np.split(flat, np.cumsum(counts)[:-1]), rest.cpu().double().exp().numpy()

    def calibrated(self, score: float) -> float:
        """A score as the chance that the joint is right on objects unlike those of training (`score_slope`, `score_offset`)."""
        inside = min(max(score, MIN_CHANCE), 1.0 - MIN_CHANCE)
        logit = self.config.score_slope * math.log(inside / (1.0 - inside)) + self.config.score_offset
        return 1.0 / (1.0 + math.exp(-logit))
