"""Interface between a network and the training loop: losses, metrics, optimizer and learning-rate schedule."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import torch
from torch import Tensor, nn
from torch.optim.lr_scheduler import CosineAnnealingLR, LRScheduler, OneCycleLR, StepLR

from kinmo.config import TrainingConfig

MONITOR = "validation/error"
"""Metric that decides which epoch is the best: the one with the least value."""
WARM_UP = 0.1
"""Share of the steps of a cycle in which the learning rate rises."""


class Learner(nn.Module):
    """A network with its losses and its optimizer, by default Adam as a `TrainingConfig` says.

    Subclasses define `training_step` and `validation_step`. Validation logs a value named "error" (`MONITOR`), or the subclass
    overrides `validation_error`.
    """

    schedule_every_step = False
    """True if the learning rate changes after every step instead of after every epoch."""

    def __init__(self, training: TrainingConfig) -> None:
        super().__init__()
        self.training_config = training
        self._sums: dict[str, tuple[Tensor | float, int]] = {}

    def training_step(self, batch: Any) -> Tensor:
        """Loss of one batch, a scalar to be minimised."""
        raise NotImplementedError

    def validation_step(self, batch: Any) -> None:
        """Log the metrics of one validation batch."""
        raise NotImplementedError

    def start_epoch(self, epoch: int) -> None:
        """Prepare for an epoch, counted from 0. Does nothing unless overridden."""

    def validation_error(self, means: Mapping[str, Tensor]) -> Tensor:
        """Value of `MONITOR`, from the means of all logged metrics over the validation set."""
        return means[MONITOR]

    def log(self, stage: Literal["training", "validation"], count: int, **values: Tensor) -> None:
        """Add metrics of one batch, each a mean over `count` examples, to the means of "stage/name" over the epoch."""
        for name, value in values.items():
            total, seen = self._sums.get(f"{stage}/{name}", (0.0, 0))
            self._sums[f"{stage}/{name}"] = total + value.detach().float() * count, seen + count

    def take_means(self) -> dict[str, Tensor]:
        """Means of all metrics logged since the last call."""
        means = {name: torch.as_tensor(total / count) for name, (total, count) in self._sums.items()}
        self._sums = {}
        return means

    def make_optimizer(self) -> torch.optim.Optimizer:
        """Optimizer of all parameters."""
        return torch.optim.Adam(self.parameters(), **adam_options(self.training_config))

    def make_schedule(self, optimizer: torch.optim.Optimizer) -> LRScheduler:
        """Schedule of the learning rate, stepped once an epoch (or once a step: `schedule_every_step`)."""
        config = self.training_config
        if config.decay_epochs:
            return StepLR(optimizer, config.decay_epochs, config.decay)
        return CosineAnnealingLR(optimizer, max(config.epochs, 1))


def adam_options(config: TrainingConfig) -> dict[str, Any]:
    """Keyword arguments for `torch.optim.Adam` and `AdamW`: fused in full precision, PyTorch's choice in mixed precision."""
    fused = True if config.precision == "32-true" else None
    return {"lr": config.learning_rate, "weight_decay": config.weight_decay, "fused": fused}


def mixed_dtype(config: TrainingConfig, device_type: str) -> torch.dtype | None:
    """Type of number that layers compute in under mixed precision; None for full precision. On a CPU, half is bfloat16."""
    if config.precision == "32-true":
        return None
    return torch.half if config.precision == "16-mixed" and device_type != "cpu" else torch.bfloat16


def one_cycle(optimizer: torch.optim.Optimizer, rate: float, steps: int) -> LRScheduler:
    """A learning rate that rises to `rate` and falls again, once in a training of some steps."""
    total = steps + 1
    return OneCycleLR(optimizer, rate, total_steps=total, pct_start=max(WARM_UP, 2.0 / total))  # it needs a rising step
