"""Training of the ANCSH networks on scans of one object."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from tiny_ancsh import TINY

from kinmo.config import AncshNetworkName, Precision
from kinmo.core.errors import InputError
from kinmo.scans.ancsh.ancsh_predictor import AncshPredictor
from kinmo.scans.ancsh.ancsh_training import AncshLearner, train_ancsh
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.poses.category_prior import CategoryPrior


def test_training_reduces_the_loss_and_its_weights_predict_scans(file: ScanFile, tmp_path: Path) -> None:
    config = replace(TINY, training=replace(TINY.training, epochs=8, learning_rate=1e-2), batches_per_epoch=8)
    for which in ("ancsh", "npcs"):
        result = train_ancsh([file], [file], config, tmp_path / which, which=which, device="cpu")
        assert result.best_error < 0.95 * result.history[0]["validation/error"]
    networks = AncshPredictor.load(tmp_path / "ancsh" / "weights.safetensors", tmp_path / "npcs" / "weights.safetensors", "cpu")
    assert networks.structure == file.structure
    assert networks.prior.to_data() == CategoryPrior.from_scans([file]).to_data()
    predictions, found = networks.predict(list(file.read("points", slice(0, 3))))
    assert len(found) == 3
    assert all(len(each.parts) == 256 and each.npcs.shape == (256, 3) for each in predictions)
    again = networks.predict_points(list(file.read("points", slice(0, 3))))
    np.testing.assert_array_equal(predictions[0].npcs, again[0].npcs)


@pytest.mark.parametrize("which", ["ancsh", "npcs"])
def test_training_in_mixed_precision_gives_about_the_same_error(
    file: ScanFile, tmp_path: Path, which: AncshNetworkName
) -> None:
    precisions: tuple[Precision, ...] = ("32-true", "bf16-mixed")
    errors = [
        train_ancsh(
            [file],
            [file],
            replace(TINY, training=replace(TINY.training, precision=precision)),
            tmp_path / precision,
            which=which,
            device="cpu",
        ).best_error
        for precision in precisions
    ]
    assert errors[0] != errors[1] == pytest.approx(errors[0], rel=0.05)


@pytest.mark.parametrize(("release", "momenta"), [(True, [0.5, 0.25, 0.01]), (False, [0.1, 0.1, 0.1])])
def test_batch_norms_slow_down_with_the_learning_rate_in_the_release(release: bool, momenta: list[float]) -> None:
    config = replace(TINY, release=release, training=replace(TINY.training, decay_epochs=10))
    learner = AncshLearner(config, "npcs", 2, 2)
    for epoch, momentum in zip((9, 10, 100), momenta, strict=True):
        learner.start_epoch(epoch)
        found = {layer.momentum for layer in learner.modules() if isinstance(layer, torch.nn.BatchNorm1d)}
        assert found == {momentum}


def test_objects_of_two_structures_are_not_trained_together(file: ScanFile) -> None:
    other = replace(file, structure=replace(file.structure, parents=(0, 1, 0)))
    with pytest.raises(InputError, match="expected 4 parts"):
        train_ancsh([file, other], [file], TINY, Path("nowhere"), which="ancsh")
    with pytest.raises(InputError, match="at least one object"):
        train_ancsh([], [], TINY, Path("nowhere"), which="ancsh")
