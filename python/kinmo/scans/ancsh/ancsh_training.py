"""Training the networks of ANCSH."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from kinmo.config import AncshConfig, AncshNetworkName
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.learning.learner import Learner
from kinmo.learning.training_loop import FitResult, Progress, fit
from kinmo.learning.weights import save_weights
from kinmo.scans.ancsh.ancsh_loss import ScanBatch, joint_losses, part_losses, total
from kinmo.scans.ancsh.ancsh_network import KIND, AncshNetwork, PartNetwork
from kinmo.scans.ancsh.scan_batches import ScanData
from kinmo.scans.files.scan_file import ScanFile, count_objects
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.rendering.renderers import NO_PART


def train_ancsh(
    training: Sequence[ScanFile],
    validation: Sequence[ScanFile],
    config: AncshConfig,
    run_dir: Path,
    *,
    which: AncshNetworkName,
    labelled: int = 0,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
) -> FitResult:
    """Train on scans of objects of one structure; leaves `weights.safetensors` and `.json` of the epoch to
    keep (`TrainingConfig.keep`) in `run_dir`. Of the objects to train on so many are `labelled`, which goes into its facts.

    Resumes what was cut off (`training.fit`). Raises InputError if either set is empty, or structures differ.
    """
    structure = structure_of([*training, *validation])
    for name, files in (("training", training), ("validation", validation)):
        if not any(file.frames for file in files):
            raise InputError(f"{name} scans", "expected at least one frame")
    torch.manual_seed(seed)
    used = [[file for file in files if file.frames] for files in (training, validation)]
    sees_more = any(bool(np.any(file.read("parts") == NO_PART)) for file in used[0])
    learner = AncshLearner(config, which, structure.part_count, structure.part_count + int(sees_more))
    data = ScanData(used[0], used[1], config)
    result = fit(learner, data, run_dir, seed=seed, device=device, fingerprint=fingerprint, on_progress=on_progress)
    facts = {
        "network": which,
        "kinds": [kind.value for kind in structure.kinds],
        "parents": list(structure.parents),
        "classes": learner.classes,
        "typical": CategoryPrior.from_scans([file for file in used[0] if file.provenance.has_true_labels] or used[0]).to_data(),
        "seed": seed,
        "objects": count_objects(used[0]),
        "labelled": labelled,
        "frames": sum(file.frames for file in used[0]),
        "epochs": len(result.history),
        "error": result.best_error,
    }
    save_weights(run_dir / "weights.safetensors", learner.network, KIND, to_table(config), facts)
    return result


def structure_of(files: Sequence[ScanFile]) -> Structure:
    """The structure that all `files` have. Raises InputError for none, or for one that differs."""
    if not files:
        raise InputError("scans", "expected those of at least one object")
    for file in files:
        if file.structure != files[0].structure:
            raise InputError(file.path, f"has {file.structure.in_words}, expected {files[0].structure.in_words}")
    return files[0].structure


FIRST_MOMENTUM, LEAST_MOMENTUM = 0.5, 0.01
"""By how much the running statistics of batch norms move a step, as the release trains (`AncshConfig.norms`)."""


class AncshLearner(Learner):
    """The weighted sum of the losses, which is the error on validation, too."""

    def __init__(self, config: AncshConfig, which: AncshNetworkName, parts: int, classes: int) -> None:
        super().__init__(config.training)
        self.config, self.classes = config, classes
        self.network = (AncshNetwork if which == "ancsh" else PartNetwork)(config, parts, classes)

    def start_epoch(self, epoch: int) -> None:
        if self.config.norms == "release":
            halved = epoch // self.config.training.decay_epochs if self.config.training.decay_epochs else 0
            for layer in self.modules():
                if isinstance(layer, nn.BatchNorm1d):
                    layer.momentum = max(FIRST_MOMENTUM * 0.5**halved, LEAST_MOMENTUM)

    def training_step(self, batch: ScanBatch) -> torch.Tensor:
        loss = total(self._losses(batch), self.config)
        self.log("training", len(batch.points), loss=loss)
        return loss

    def validation_step(self, batch: ScanBatch) -> None:
        losses = self._losses(batch)
        self.log("validation", len(batch.points), error=total(losses, self.config), **losses)

    def _losses(self, batch: ScanBatch) -> dict[str, torch.Tensor]:
        mean_over = self.config.mean_over
        if isinstance(self.network, AncshNetwork):
            parts, joints = self.network.forward_all(batch.points)
            return part_losses(parts, batch, mean_over) | joint_losses(parts, joints, batch, mean_over)
        return part_losses(self.network(batch.points), batch, mean_over)
