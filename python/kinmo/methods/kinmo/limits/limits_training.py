"""Training of the limits network."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from kinmo.config import LimitsConfig
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.learning.learner import Learner, adam_options
from kinmo.learning.training_loop import FitResult, Progress, fit
from kinmo.learning.weights import load_weights, save_weights
from kinmo.methods.kinmo.limits.limits_network import KIND, LimitsNetwork, likely_travel, limits_loss
from kinmo.methods.kinmo.limits.travel_examples import NO_WORD, UNLIMITED, TravelExamples, joined

VALIDATION_JOINTS = 1024
"""Joints in a batch of validation."""


def train_joint_limits(
    training: Sequence[TravelExamples],
    validation: Sequence[TravelExamples],
    config: LimitsConfig,
    run_dir: Path,
    *,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
    initial: Path | None = None,
) -> FitResult:
    """Train a limits network on annotated joints, with the arguments and results of `train_motion_gnn`.

    Training that starts from `initial` weights has the schedule `config.continued`.

    Raises:
        InputError: `training` or `validation` has no joint, or `initial` does not fit.
    """
    for name, found in (("training", training), ("validation", validation)):
        if not found:
            raise InputError(f"{name} shapes", "expected at least one annotated joint")
    torch.manual_seed(seed)
    start = None if initial is None else load_weights(initial, KIND)
    if start is not None:
        config, fingerprint = replace(config, training=config.continued), fingerprint + start.sha256
    data = LimitsData(joined(training), joined(validation), config)
    learner = LimitsLearner(config, data)
    if start is not None:
        start.fill(learner.network)
    result = fit(learner, data, run_dir, seed=seed, device=device, fingerprint=fingerprint, on_progress=on_progress)
    facts: dict[str, Any] = {
        "seed": seed,
        "joints": len(data.training),
        "epochs": len(result.history),
        "started_from": None if start is None else start.sha256,
        "error": result.best_error,
        "directed_features": data.training.directed.shape[2],
        "shared_features": data.training.shared.shape[1],
    }
    save_weights(run_dir / "weights.safetensors", learner.network, KIND, to_table(config), facts)
    return result


@dataclass(frozen=True)
class LimitsBatch:
    """Some joints: directed and shared features, words, and true travel, as in `TravelExamples`."""

    directed: Tensor
    shared: Tensor
    words: Tensor
    travel: Tensor

    def to(self, device: torch.device) -> LimitsBatch:
        """The batch on a device."""
        return LimitsBatch(*(values.to(device) for values in vars(self).values()))


class LimitsData:
    """Batches of joints, in a new order in every epoch, with names hidden at random."""

    def __init__(self, training: TravelExamples, validation: TravelExamples, config: LimitsConfig) -> None:
        self.training, self.validation, self.config = training, validation, config

    @property
    def steps(self) -> int:
        """Number of batches per epoch."""
        return math.ceil(len(self.training) / self.config.batch_joints)

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[LimitsBatch]:
        """Batches of one epoch."""
        for rows in np.array_split(rng.permutation(len(self.training)), self.steps):
            batch = _batch(self.training, rows)
            hidden = torch.from_numpy(rng.random(len(rows)) < self.config.hide_names)
            yield replace(batch, words=torch.where(hidden[:, None], NO_WORD, batch.words))

    def validation_batches(self) -> Iterator[LimitsBatch]:
        """Batches of the validation joints, the same in every epoch."""
        for start in range(0, len(self.validation), VALIDATION_JOINTS):
            yield _batch(self.validation, np.arange(start, min(start + VALIDATION_JOINTS, len(self.validation))))


class LimitsLearner(Learner):
    """Loss of the limits; the best epoch has the largest overlap of predicted and true ranges on validation joints."""

    def __init__(self, config: LimitsConfig, data: LimitsData) -> None:
        super().__init__(config.training)
        every = _batch(data.training, np.arange(len(data.training)))
        self.network = LimitsNetwork(every.directed.shape[2], every.shared.shape[1], config)
        self.network.standardize(every.directed, every.shared)
        self.network.silence_unknown_words(torch.unique(every.words[every.words != NO_WORD]))

    def training_step(self, batch: LimitsBatch) -> Tensor:
        travel, is_limited = self.network(batch.directed, batch.shared, batch.words)
        loss = limits_loss(travel, is_limited, batch.travel)
        self.log("training", len(batch.travel), loss=loss)
        return loss

    def validation_step(self, batch: LimitsBatch) -> None:
        travel, is_limited = self.network(batch.directed, batch.shared, batch.words)
        limited = batch.travel[:, 0] != UNLIMITED
        error = 1.0 - ((is_limited > 0) == limited).float().mean()
        if limited.any():
            found = likely_travel(travel[limited].exp().double().cpu().numpy())
            true = batch.travel[limited].double().cpu().numpy()
            overlap = np.minimum(found, true).sum(axis=1) / np.maximum(np.maximum(found, true).sum(axis=1), 1e-9)
            error = error + 1.0 - float(overlap.mean())
        self.log("validation", len(batch.travel), loss=limits_loss(travel, is_limited, batch.travel), error=error)

    def make_optimizer(self) -> torch.optim.Optimizer:
        """AdamW."""
        return torch.optim.AdamW(self.parameters(), **adam_options(self.training_config))


def _batch(examples: TravelExamples, rows: NDArray[np.int64]) -> LimitsBatch:
    return LimitsBatch(**{field.name: torch.from_numpy(getattr(examples, field.name)[rows]) for field in fields(examples)})
