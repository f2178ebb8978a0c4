"""Training the ranking networks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn

from kinmo.config import RankingConfig
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.features.candidate_features import Evidence
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.training_loop import FitResult, Learner, Progress, adam_options, fit
from kinmo.learning.weights import Weights, load_weights, save_weights
from kinmo.methods.kinmo.ranking.ranking_batches import View, collate
from kinmo.methods.kinmo.ranking.ranking_network import (
    KIND,
    JointRanker,
    RankingBatch,
    averaged,
    rankers,
    ranking_loss,
    right_probability,
)
from kinmo.methods.kinmo.ranking.shape_views import body_view, node_view

WARM_UP = 0.1
"""Share of the steps in which the learning rate rises."""
STANDARDIZED_VIEWS = 512
VALIDATION_VIEWS = 64


def train_joint_ranking(
    training: Sequence[PreparedShape],
    validation: Sequence[PreparedShape],
    config: RankingConfig,
    run_dir: Path,
    *,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
    initial: Path | None = None,
) -> FitResult:
    """Train on annotated shapes; leaves `weights.safetensors` and `.json` of the best epoch on `validation` in `run_dir`.

    `initial` are weights of an earlier training with the same sizes: then it starts from those and goes by `config.continued`.
    Resumes what was cut off (`training.fit`). Raises InputError if either set has no joint to learn from, or `initial` does not
    fit.
    """
    views = [shape_views(shapes) for shapes in (training, validation)]
    for name, found in zip(("training", "validation"), views, strict=True):
        if not any(target is not None for view in found for target in view.targets):
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
        "started_from": None if start is None else start.sha256,
    }
    save_weights(run_dir / "weights.safetensors", learner.networks, KIND, to_table(config), facts)
    return result


def _blend(networks: nn.ModuleList, start: Weights, share: float) -> None:
    """Move the networks' weights back by `share` of the way to those they started from."""
    with torch.no_grad():
        for name, values in networks.state_dict().items():
            values.lerp_(start.tensors[name].to(values), share)


def shape_views(shapes: Sequence[PreparedShape]) -> list[View]:
    """Both views of every annotated shape that has evidence."""
    views = []
    for shape in shapes:
        if shape.evidence and shape.mobility is not None:
            evidence = Evidence.of(shape.evidence)
            views.append(body_view(shape, evidence))
            if len(shape.parents) > 1:
                views.append(node_view(shape, evidence))
    return views


class RankingData:
    """Batches of views in an order that every epoch draws anew, names dropped at random."""

    def __init__(self, training: Sequence[View], validation: Sequence[View], config: RankingConfig) -> None:
        self.training, self.validation, self.config = training, validation, config
        spread = np.linspace(0, len(training) - 1, min(STANDARDIZED_VIEWS, len(training))).astype(int)
        self.sample = collate([training[i] for i in spread])
        self.widths = self.sample.hypotheses.shape[1], self.sample.units.shape[1]

    @property
    def words(self) -> torch.Tensor:
        """Hashed words of the names to learn from, each once."""
        known = {word for view in self.training for words in view.words for word in words}
        if self.config.sees_categories:
            known |= {word for view in self.training for word in view.category}
        return torch.tensor(sorted(known), dtype=torch.long)

    @property
    def steps(self) -> int:
        """Batches of an epoch."""
        return math.ceil(len(self.training) / self.config.batch_views)

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[RankingBatch]:
        order = rng.permutation(len(self.training))
        for some in np.array_split(order, self.steps):
            views = [self.training[i] for i in some]
            yield collate(
                views,
                rng=rng,
                hide_view=self.config.hide_names,
                hide_unit=self.config.hide_unit_names,
                hide_category=self.config.hide_categories,
            )

    def validation_batches(self) -> Iterator[RankingBatch]:
        for start in range(0, len(self.validation), VALIDATION_VIEWS):
            hidden = float(not self.config.sees_categories)
            yield collate(self.validation[start : start + VALIDATION_VIEWS], hide_category=hidden)


class RankingLearner(Learner):
    """Cross-entropy of every member; the best epoch gives right answers the most probability on validation.

    That is bounded: a single answer that is wrong and sure, which few shapes to choose by are bound to have, does not decide.
    """

    def __init__(self, config: RankingConfig, data: RankingData) -> None:
        super().__init__(config.training)
        self.networks = rankers(config, *data.widths)
        for network in self.networks:
            assert isinstance(network, JointRanker)
            network.standardize(data.sample.hypotheses, data.sample.units)
            network.silence(data.words)
        self.steps = data.steps * config.training.epochs

    def training_step(self, batch: RankingBatch, index: int) -> torch.Tensor:
        losses = [_loss(network(batch), batch) for network in self.networks]
        self.log(
            "training/loss", torch.stack(losses).mean().detach(), on_step=False, on_epoch=True, batch_size=len(batch.units)
        )
        return torch.stack(losses).sum()

    def validation_step(self, batch: RankingBatch, index: int) -> None:
        hypotheses, rest = averaged(self.networks, batch)
        size = len(batch.units)
        self.log("validation/loss", ranking_loss(hypotheses, rest, batch), batch_size=size)
        self.log("validation/error", 1.0 - right_probability(hypotheses, rest, batch).mean(), batch_size=size)

    def configure_optimizers(self) -> Any:
        config = self.training_config
        optimizer = torch.optim.AdamW(self.parameters(), **adam_options(config))
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimizer, config.learning_rate, total_steps=self.steps + 1, pct_start=WARM_UP
        )
        return [optimizer], [{"scheduler": schedule, "interval": "step"}]


def _loss(said: tuple[torch.Tensor, torch.Tensor], batch: RankingBatch) -> torch.Tensor:
    return ranking_loss(said[0], said[1], batch)
