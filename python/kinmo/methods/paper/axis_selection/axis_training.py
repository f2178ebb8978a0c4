"""Training the axis-selection network."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import torch
from torch.nn.functional import binary_cross_entropy_with_logits

from kinmo.config import AxisConfig
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.training_loop import FitResult, Learner, Progress, fit
from kinmo.learning.weights import load_weights, save_weights
from kinmo.methods.paper.axis_selection.cloud_pairs import PairBatch, PairData, joint_samples
from kinmo.methods.paper.axis_selection.siamese_network import KIND, AxisSelectionNetwork


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
    """Train on annotated shapes; leaves `weights.safetensors` and `.json` of the best epoch on `validation` in `run_dir`.

    `initial` are weights of an earlier training with the same sizes to start from. Resumes what was cut off (`training.fit`).
    Raises InputError if either set has no joint to learn from, or `initial` does not fit.
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
    """Binary cross entropy; the best epoch is that with the least on validation (`training.MONITOR`)."""

    def __init__(self, config: AxisConfig) -> None:
        super().__init__(config.training)
        self.network = AxisSelectionNetwork(config)

    def training_step(self, batch: PairBatch, index: int) -> torch.Tensor:
        return self._step("training", batch, "loss")

    def validation_step(self, batch: PairBatch, index: int) -> None:
        self._step("validation", batch, "error")

    def _step(self, stage: str, batch: PairBatch, loss_name: str) -> torch.Tensor:
        logits = self.network(batch.original, batch.feasible, batch.infeasible)
        count = len(batch.original)
        truth = torch.cat([logits.new_ones(count), logits.new_zeros(count)])
        loss = binary_cross_entropy_with_logits(logits, truth)
        logged = {
            f"{stage}/{loss_name}": loss,
            f"{stage}/accuracy": ((logits > 0) == (truth > 0.5)).float().mean(),
            f"{stage}/ranked_right": (logits[:count] > logits[count:]).float().mean(),
        }
        self.log_dict(logged, on_step=False, on_epoch=True, batch_size=count)
        return loss
