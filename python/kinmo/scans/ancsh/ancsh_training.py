"""Training of the ANCSH networks (Li et al. 2020, section 4; paper, section 3.4)."""

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
from kinmo.scans.ancsh.ancsh_loss import ScanBatch, joint_losses, part_losses, total_loss
from kinmo.scans.ancsh.ancsh_network import KIND, AncshNetwork, PartNetwork
from kinmo.scans.ancsh.scan_batches import ScanData
from kinmo.scans.files.scan_file import ScanFile, count_objects
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.rendering.renderers import NO_PART

FIRST_MOMENTUM, MIN_MOMENTUM = 0.5, 0.01
"""Momentum of batch norms in the release's schedule (`AncshConfig.norms`): in the first epoch, and its least value."""


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
    """Train one network and write `weights.safetensors` and `weights.json` of the kept epoch.

    Validation scans choose the best epoch. The header of the weights notes the number of `labelled` training objects. An
    interrupted training in `run_dir` is resumed (`fit`, which explains the other arguments).

    Raises:
        InputError: Either set has no frames, structures differ, or the training fails (`fit`).
    """
    structure = _common_structure([*training, *validation])
    for name, files in (("training", training), ("validation", validation)):
        if not any(file.frames for file in files):
            raise InputError(f"{name} scans", "expected at least one frame")
    torch.manual_seed(seed)
    used = [[file for file in files if file.frames] for files in (training, validation)]
    has_background = any(bool(np.any(file.read("parts") == NO_PART)) for file in used[0])
    learner = AncshLearner(config, which, structure.part_count, structure.part_count + int(has_background))
    data = ScanData(used[0], used[1], config)
    result = fit(learner, data, run_dir, seed=seed, device=device, fingerprint=fingerprint, on_progress=on_progress)
    prior = CategoryPrior.from_scans([file for file in used[0] if file.provenance.has_true_labels] or used[0])
    facts = {
        "network": which,
        "kinds": [kind.value for kind in structure.kinds],
        "parents": list(structure.parents),
        "classes": learner.classes,
        "category_prior": prior.to_data(),
        "seed": seed,
        "objects": count_objects(used[0]),
        "labelled": labelled,
        "frames": sum(file.frames for file in used[0]),
        "epochs": len(result.history),
        "error": result.best_error,
    }
    save_weights(run_dir / "weights.safetensors", learner.network, KIND, to_table(config), facts)
    return result


def _common_structure(files: Sequence[ScanFile]) -> Structure:
    """Structure that the objects of all files have; InputError if there is no file, or a structure differs."""
    if not files:
        raise InputError("scans", "expected those of at least one object")
    for file in files:
        if file.structure != files[0].structure:
            raise InputError(file.path, f"has {file.structure.in_words}, expected {files[0].structure.in_words}")
    return files[0].structure


class AncshLearner(Learner):
    """An ANCSH network with the weighted sum of its losses, which is also the validation error."""

    def __init__(self, config: AncshConfig, which: AncshNetworkName, parts: int, classes: int) -> None:
        super().__init__(config.training)
        self.config, self.classes = config, classes
        self.network = (AncshNetwork if which == "ancsh" else PartNetwork)(config, parts, classes)

    def start_epoch(self, epoch: int) -> None:
        if self.config.norms == "release":
            decays = epoch // self.config.training.decay_epochs if self.config.training.decay_epochs else 0
            for layer in self.modules():
                if isinstance(layer, nn.BatchNorm1d):
                    layer.momentum = max(FIRST_MOMENTUM * 0.5**decays, MIN_MOMENTUM)

    def training_step(self, batch: ScanBatch) -> torch.Tensor:
        loss = total_loss(self._losses(batch), self.config)
        self.log("training", len(batch.points), loss=loss)
        return loss

    def validation_step(self, batch: ScanBatch) -> None:
        losses = self._losses(batch)
        self.log("validation", len(batch.points), error=total_loss(losses, self.config), **losses)

    def _losses(self, batch: ScanBatch) -> dict[str, torch.Tensor]:
        mean_over = self.config.mean_over
        if isinstance(self.network, AncshNetwork):
            parts, joints = self.network.forward_all(batch.points)
            return part_losses(parts, batch, mean_over) | joint_losses(parts, joints, batch, mean_over)
        return part_losses(self.network(batch.points), batch, mean_over)
