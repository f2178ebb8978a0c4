"""Asking trained ranking networks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from kinmo.config import RankingConfig
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import from_table
from kinmo.learning.weights import load_weights, pick_device
from kinmo.methods.kinmo.ranking.ranking_batches import View, collate
from kinmo.methods.kinmo.ranking.ranking_network import KIND, averaged, rankers

F64 = NDArray[np.float64]


class JointRanking:
    """Trained networks. `hide_names` keeps the names of parts and categories from them, `hide_categories` the latter alone."""

    def __init__(self, networks: nn.ModuleList, device: str, hide_names: bool = False, hide_categories: bool = False) -> None:
        self.networks, self.device = networks.to(device).eval(), device
        self.hide_names, self.hide_categories = hide_names, hide_categories

    @classmethod
    def load(cls, weights: Path, device: str = "auto", hide_names: bool = False) -> JointRanking:
        """Read `weights.safetensors` of `train_joint_ranking`. Raises InputError if they are another network's or cut."""
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        header = weights.with_suffix(".json")
        config = from_table(RankingConfig, loaded.config, header, "config.")
        hypothesis_features, unit_features = (loaded.facts.get(name) for name in ("hypothesis_features", "unit_features"))
        if not (isinstance(hypothesis_features, int) and isinstance(unit_features, int)):
            raise InputError(header, "expected the numbers of features", "facts")
        networks = rankers(config, hypothesis_features, unit_features)
        loaded.fill(networks)
        return cls(networks, device, hide_names, not config.sees_categories)

    @torch.inference_mode()
    def probabilities(self, view: View) -> tuple[list[F64], F64]:
        """For every unit of `view` the probabilities [h] of its hypotheses, and for all of them that of rest [U]."""
        batch = collate([view], hide_names=self.hide_names, hide_category=float(self.hide_categories))
        batch = batch.to(torch.device(self.device))
        hypotheses, rest = averaged(self.networks, batch)
        flat = hypotheses.cpu().double().exp().numpy()
        counts = [view.evidence.rows(unit).stop - view.evidence.rows(unit).start for unit in view.units]
        return np.split(flat, np.cumsum(counts)[:-1]), rest.cpu().double().exp().numpy()
