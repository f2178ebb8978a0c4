"""Training of the axis selection network with a binary cross-entropy loss (paper, section 3.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits

from kinmo.config import AxisConfig
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.learner import Learner
from kinmo.learning.training_loop import FitResult, Progress, fit
from kinmo.learning.weights import load_weights, save_weights
from kinmo.methods.paper.axis_selection.siamese_network import KIND, AxisSelectionNetwork
from kinmo.methods.paper.axis_selection.training_pairs import PairBatch, PairData, joint_samples


def train_axis_selection(
    training: Sequence[PreparedShape],
    validation: Sequence[PreparedShape],
    config: AxisConfig,
    run_dir: Path,
    *,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
    initial: Path | None = None,
) -> FitResult:
    """Train an axis selection network on annotated shapes, with the arguments and results of `train_motion_gnn`.

    Raises:
        InputError: `training` or `validation` has no joint to learn from, or `initial` does not fit.
    """
    samples = [joint_samples(shapes, config) for shapes in (training, validation)]
    for name, found in zip(("training", "validation"), samples, strict=True):
        if not found:
            raise InputError(f"{name} shapes", "expected at least one annotated joint with something to move against")
    torch.manual_seed(seed)
    learner = AxisLearner(config)
    data = PairData(samples[0], samples[1], config)
    if initial is not None:
        load_weights(initial, KIND).fill(learner.network)
    result = fit(learner, data, run_dir, seed=seed, device=device, fingerprint=fingerprint, on_progress=on_progress)
    facts = {"seed": seed, "joints": len(samples[0]), "epochs": len(result.history), "error": result.best_error}
    save_weights(run_dir / "weights.safetensors", learner.network, KIND, to_table(config), facts)
    return result


class AxisLearner(Learner):
    """Binary cross-entropy of feasible and infeasible motions; the best epoch has the least on validation."""

    def __init__(self, config: AxisConfig) -> None:
        super().__init__(config.training)
        self.network = AxisSelectionNetwork(config)

    def training_step(self, batch: PairBatch) -> Tensor:
        loss, metrics = self._step(batch)
        self.log("training", len(batch.original), loss=loss, **metrics)
        return loss

    def validation_step(self, batch: PairBatch) -> None:
        loss, metrics = self._step(batch)
        self.log("validation", len(batch.original), error=loss, **metrics)

    def _step(self, batch: PairBatch) -> tuple[Tensor, dict[str, Tensor]]:
        """Loss, and shares of motions classified correctly and of pairs ranked correctly."""
        logits = self.network(batch.original, batch.feasible, batch.infeasible)
        count = len(batch.original)
        truth = torch.cat([logits.new_ones(count), logits.new_zeros(count)])
        accuracy = ((logits > 0) == (truth > 0.5)).float().mean()
        ranked_right = (logits[:count] > logits[count:]).float().mean()
        return binary_cross_entropy_with_logits(logits, truth), {"accuracy": accuracy, "ranked_right": ranked_right}
