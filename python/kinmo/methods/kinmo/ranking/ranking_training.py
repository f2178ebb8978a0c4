"""Training of the ranking networks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.optim.lr_scheduler import LRScheduler

from kinmo.config import RankingConfig
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.learner import Learner, adam_options, one_cycle
from kinmo.learning.model_folder import networks_digest
from kinmo.learning.training_loop import FitResult, Progress, fit
from kinmo.learning.weights import Weights, load_weights, save_weights
from kinmo.methods.kinmo.grouping.part_grouper import PartGrouper
from kinmo.methods.kinmo.ranking.ranking_batches import RankingBatch, collate_views
from kinmo.methods.kinmo.ranking.ranking_network import (
    KIND,
    RankingNetwork,
    correct_probability,
    mean_log_probabilities,
    ranking_loss,
    ranking_networks,
)
from kinmo.methods.kinmo.ranking.shape_views import ShapeView
from kinmo.methods.kinmo.ranking.training_views import training_views

STANDARDIZATION_VIEWS = 512
"""Largest number of views that mean and scale of the features are computed from."""
VALIDATION_VIEWS = 16
"""Views per batch in validation."""
POOLED_BATCHES = 24
"""Batches that a draw of views fills by size: views of one batch have about as many groups, so attention pads few."""


def train_joint_ranking(
    training: Sequence[PreparedShape],
    validation: Sequence[PreparedShape],
    config: RankingConfig,
    run_dir: Path,
    *,
    grouping: Path,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
    initial: Path | None = None,
) -> FitResult:
    """Train ranking networks on annotated shapes, with the arguments and results of `train_motion_gnn`.

    `grouping` are the weights of the grouping networks whose proposals are ranked. Training that starts from `initial` weights
    has the schedule `config.continued`.

    Raises:
        InputError: `training` or `validation` has no joint to learn from, or `initial` does not fit.
    """
    grouper = PartGrouper.load(grouping, "cpu")
    views = [training_views(shapes, grouper, config) for shapes in (training, validation)]
    for name, found in zip(("training", "validation"), views, strict=True):
        if not any(view.has_joints for view in found):
            raise InputError(f"{name} shapes", "expected at least one annotated joint")
    torch.manual_seed(seed)
    start = None if initial is None else load_weights(initial, KIND)
    if start is not None:
        config = replace(config, training=config.continued.training, batch_views=config.continued.batch_views)
        fingerprint += start.sha256
    data = RankingData(views[0], views[1], config)
    learner = RankingLearner(config, data)
    if start is not None:
        start.fill(learner.networks)
    result = fit(learner, data, run_dir, seed=seed, device=device, fingerprint=fingerprint, on_progress=on_progress)
    if start is not None:
        _blend(learner.networks, start, config.continued.initial_share)
    facts: dict[str, Any] = {
        "seed": seed,
        "shapes": len(training),
        "epochs": len(result.history),
        "error": result.best_error,
        "hypothesis_features": data.widths[0],
        "unit_features": data.widths[1],
        "grouping": networks_digest((grouping,)),
        "started_from": None if start is None else start.sha256,
    }
    save_weights(run_dir / "weights.safetensors", learner.networks, KIND, to_table(config), facts)
    return result


def _blend(networks: nn.ModuleList, start: Weights, share: float) -> None:
    """Move the networks' weights back by `share` of the way to those they started from."""
    with torch.no_grad():
        for name, values in networks.state_dict().items():
            values.lerp_(start.tensors[name].to(values), share)


class RankingData:
    """Batches of views, in a new order in every epoch and with names hidden at random."""

    def __init__(self, training: Sequence[ShapeView], validation: Sequence[ShapeView], config: RankingConfig) -> None:
        self.training, self.validation, self.config = training, validation, config
        spread = np.linspace(0, len(training) - 1, min(STANDARDIZATION_VIEWS, len(training))).astype(int)
        self.sample = collate_views([training[i] for i in spread])
        self.batch_weight = config.batch_views * float(np.mean([view.weights.sum() for view in training]))
        self.widths = self.sample.candidates.shape[1], self.sample.groups.shape[1]

    @property
    def words(self) -> torch.Tensor:
        """Hashed words of all names in the training views, each once."""
        known = {word for view in self.training for words in view.words for word in words}
        if self.config.sees_categories:
            known |= {word for view in self.training for word in view.category}
        return torch.tensor(sorted(known), dtype=torch.long)

    @property
    def steps(self) -> int:
        """Number of batches per epoch."""
        return math.ceil(len(self.training) / self.config.batch_views)

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[RankingBatch]:
        """Batches of one epoch."""
        order, size = rng.permutation(len(self.training)), self.config.batch_views
        batches: list[NDArray[np.int64]] = []
        for start in range(0, len(order), POOLED_BATCHES * size):
            pool = sorted(order[start : start + POOLED_BATCHES * size], key=lambda view: len(self.training[view].groups))
            batches += np.array_split(np.array(pool), math.ceil(len(pool) / size))
        for place in rng.permutation(len(batches)):
            yield collate_views(
                [self.training[i] for i in batches[place]],
                rng=rng,
                hide_group=self.config.hide_group_names,
                hide_category=self.config.hide_categories,
            )

    def validation_batches(self) -> Iterator[RankingBatch]:
        """Batches of the validation views, the same in every epoch."""
        hidden = float(not self.config.sees_categories)
        for start in range(0, len(self.validation), VALIDATION_VIEWS):
            yield collate_views(self.validation[start : start + VALIDATION_VIEWS], hide_category=hidden)


class RankingLearner(Learner):
    """Cross-entropy of every network; the best epoch has the highest mean probability of correct joints on validation.

    The mean probability is bounded. With few validation shapes, one confident error would otherwise decide.
    """

    schedule_every_step = True

    def __init__(self, config: RankingConfig, data: RankingData) -> None:
        super().__init__(config.training)
        self.networks = ranking_networks(config, *data.widths)
        for network in self.networks:
            assert isinstance(network, RankingNetwork)
            network.standardize(data.sample.candidates, data.sample.groups)
            network.silence_unknown_words(data.words)
        self.steps = data.steps * config.training.epochs
        self.batch_weight = data.batch_weight

    def training_step(self, batch: RankingBatch) -> torch.Tensor:
        outputs = [network(batch) for network in self.networks]
        losses = torch.stack([ranking_loss(candidates, rest, batch) for candidates, rest in outputs])
        self.log("training", len(batch.groups), loss=losses.mean())
        return losses.sum() * (batch.weights.sum() / self.batch_weight)  # a batch of large views weighs more

    def validation_step(self, batch: RankingBatch) -> None:
        candidates, rest = mean_log_probabilities(self.networks, batch)
        loss, error = ranking_loss(candidates, rest, batch), 1.0 - correct_probability(candidates, rest, batch)
        self.log("validation", len(batch.groups), loss=loss, error=error)

    def make_optimizer(self) -> torch.optim.Optimizer:
        """AdamW for all networks."""
        return torch.optim.AdamW(self.parameters(), **adam_options(self.training_config))

    def make_schedule(self, optimizer: torch.optim.Optimizer) -> LRScheduler:
        """One cycle of the learning rate over the whole training."""
        return one_cycle(optimizer, self.training_config.learning_rate, self.steps)
