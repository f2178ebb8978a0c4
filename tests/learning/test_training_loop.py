"""The training loop: resuming, choice of the epoch, averaging, precision, learning rate, files and errors."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from kinmo.config import TrainingConfig
from kinmo.core.errors import InputError
from kinmo.learning import training_loop
from kinmo.learning.learner import MONITOR, Learner, mixed_dtype
from kinmo.learning.training_loop import fit

CONFIG = TrainingConfig(epochs=5, learning_rate=0.05, decay_epochs=2)
AVERAGED = replace(CONFIG, average=0.9)


class LineLearner(Learner):
    """Fits a linear function with a small network that has dropout, and notes the learning rate of every step."""

    def __init__(self, config: TrainingConfig = CONFIG) -> None:
        super().__init__(config)
        torch.manual_seed(0)
        self.layers = nn.Sequential(nn.Linear(2, 8), nn.Dropout(0.3), nn.ReLU(), nn.Linear(8, 1))
        self.rates: list[float] = []

    def training_step(self, batch: Tensor) -> Tensor:
        self.rates.append(self.optimizer.param_groups[0]["lr"])
        return (self.layers(batch[:, :2]) - batch[:, 2:]).square().mean()

    def validation_step(self, batch: Tensor) -> None:
        self.log("validation", len(batch), error=(self.layers(batch[:, :2]) - batch[:, 2:]).abs().mean())

    def make_optimizer(self) -> torch.optim.Optimizer:
        self.optimizer = super().make_optimizer()
        return self.optimizer


class PlanePoints:
    """Random points of a plane; reading them fails at the (epoch, batch) `fail_at`."""

    def __init__(self, fail_at: tuple[int, int] | None = None) -> None:
        self.fail_at = fail_at
        self.epochs: list[int] = []

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[Tensor]:
        self.epochs.append(epoch)
        for index in range(4):
            if (epoch, index) == self.fail_at:
                raise RuntimeError("power cut")
            points = torch.from_numpy(rng.normal(size=(16, 3)).astype(np.float32))
            points[:, 2] = points[:, 0] - 2 * points[:, 1]
            yield points

    def validation_batches(self) -> list[Tensor]:
        return list(PlanePoints().training_batches(0, np.random.default_rng(99)))


def trained(folder: Path, config: TrainingConfig = CONFIG, seed: int = 3) -> tuple[list[Tensor], list[int]]:
    """Final parameters, and the epochs that were run."""
    learner, data = LineLearner(config), PlanePoints()
    fit(learner, data, folder, seed=seed, device="cpu")
    return [p.detach().clone() for p in learner.parameters()], data.epochs


def equal(one: list[Tensor], other: list[Tensor]) -> bool:
    return all(torch.equal(a, b) for a, b in zip(one, other, strict=True))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> list[Tensor]:
    """Parameters of a run that was never interrupted."""
    return trained(tmp_path_factory.mktemp("undisturbed"))[0]


@pytest.mark.parametrize("moment", [(0, 2), (1, 0), (3, 3)])
def test_an_interrupted_run_ends_like_an_undisturbed_one(tmp_path: Path, undisturbed: list[Tensor], moment) -> None:
    with pytest.raises(RuntimeError, match="power cut"):
        fit(LineLearner(), PlanePoints(moment), tmp_path / "cut", seed=3, device="cpu")
    again, epochs = trained(tmp_path / "cut")
    assert epochs == list(range(moment[0], CONFIG.epochs)), "finished epochs are not run again"
    assert equal(again, undisturbed)
    trained(tmp_path / "whole")
    files = [
        {path.name: path.read_bytes() for path in (tmp_path / name).iterdir() if path.suffix != ".ckpt"}
        for name in ("cut", "whole")
    ]
    assert files[0] == files[1]


def test_averaged_weights_are_validated_and_kept_and_survive_an_interruption(tmp_path: Path, undisturbed: list[Tensor]) -> None:
    averaged, _ = trained(tmp_path / "whole", AVERAGED)
    assert not equal(averaged, undisturbed)
    with pytest.raises(RuntimeError, match="power cut"):
        fit(LineLearner(AVERAGED), PlanePoints((2, 1)), tmp_path / "cut", seed=3, device="cpu")
    again, epochs = trained(tmp_path / "cut", AVERAGED)
    assert epochs == [2, 3, 4]
    assert equal(again, averaged)


def test_gradients_can_be_clipped_in_mixed_precision(tmp_path: Path) -> None:
    config = replace(CONFIG, precision="bf16-mixed", gradient_clip=1e-9)
    history = fit(LineLearner(config), PlanePoints(), tmp_path, device="cpu").history
    assert len(history) == config.epochs


def test_half_precision_scales_its_losses_and_comes_to_about_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = replace(CONFIG, precision="16-mixed", gradient_clip=0.5)
    exact = fit(LineLearner(replace(config, precision="32-true")), PlanePoints(), tmp_path / "exact", device="cpu")
    monkeypatch.setattr(training_loop, "mixed_dtype", lambda *_: torch.half)  # a CPU would use bfloat16
    half = fit(LineLearner(config), PlanePoints(), tmp_path / "half", device="cpu")
    assert half.best_error != exact.best_error
    assert half.best_error == pytest.approx(exact.best_error, rel=0.05)
    checkpoint = torch.load(tmp_path / "half" / "last.ckpt", weights_only=True)
    assert checkpoint["scaler"]["scale"] > 1.0, "losses are scaled, and a resumed run goes on with the scale"


def test_layers_compute_in_the_precision_that_is_configured() -> None:
    expected = {"32-true": (None, None), "bf16-mixed": (torch.bfloat16,) * 2, "16-mixed": (torch.bfloat16, torch.half)}
    for precision, types in expected.items():
        config = replace(CONFIG, precision=precision)
        assert (mixed_dtype(config, "cpu"), mixed_dtype(config, "cuda")) == types


def test_an_average_over_nearly_all_steps_lags_behind(tmp_path: Path) -> None:
    errors = {}
    for average in (0.0, 1e-6, 0.9999):
        learner = LineLearner(replace(CONFIG, average=average))
        errors[average] = fit(learner, PlanePoints(), tmp_path / str(average), device="cpu").history[1][MONITOR]
    assert errors[1e-6] == pytest.approx(errors[0.0], rel=1e-3)
    assert errors[0.9999] > errors[0.0]


@pytest.mark.parametrize(
    ("decay_epochs", "rates"),
    [(2, [1.0, 1.0, 0.7, 0.7, 0.49]), (0, [(1.0 + np.cos(np.pi * epoch / 5)) / 2 for epoch in range(5)])],
)
def test_the_learning_rate_falls_once_an_epoch(tmp_path: Path, decay_epochs: int, rates: list[float]) -> None:
    learner = LineLearner(replace(CONFIG, decay_epochs=decay_epochs))
    fit(learner, PlanePoints(), tmp_path, device="cpu")
    np.testing.assert_allclose(np.array(learner.rates).reshape(5, 4), CONFIG.learning_rate * np.repeat([rates], 4, axis=0).T)


def test_a_learner_may_change_the_learning_rate_every_step(tmp_path: Path) -> None:
    learner = LineLearner(replace(CONFIG, epochs=2, decay_epochs=1))
    learner.schedule_every_step = True
    fit(learner, PlanePoints(), tmp_path, device="cpu")
    np.testing.assert_allclose(learner.rates, CONFIG.learning_rate * 0.7 ** np.arange(8))


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_a_truncated_checkpoint_gives_way_to_the_previous_one(tmp_path: Path, undisturbed: list[Tensor], share: float) -> None:
    with pytest.raises(RuntimeError):
        fit(LineLearner(), PlanePoints((3, 1)), tmp_path, seed=3, device="cpu")
    last = tmp_path / "last.ckpt"
    whole = last.read_bytes()
    last.write_bytes(whole[: int(len(whole) * share)])
    again, epochs = trained(tmp_path)
    assert epochs == [2, 3, 4]
    assert equal(again, undisturbed)


def test_a_finished_run_is_not_repeated(tmp_path: Path, undisturbed: list[Tensor]) -> None:
    trained(tmp_path)
    again, epochs = trained(tmp_path)
    assert epochs == []
    assert equal(again, undisturbed)


def test_another_seed_or_configuration_starts_anew(tmp_path: Path) -> None:
    trained(tmp_path)
    assert trained(tmp_path, seed=4)[1] == [0, 1, 2, 3, 4]
    assert trained(tmp_path, replace(CONFIG, epochs=2), seed=4)[1] == [0, 1]


def test_the_best_epoch_is_kept_and_every_epoch_is_logged(tmp_path: Path) -> None:
    learner, seen = LineLearner(), []
    result = fit(learner, PlanePoints(), tmp_path, seed=3, device="cpu", on_progress=seen.append)
    errors = [row[MONITOR] for row in json.loads((tmp_path / "metrics.json").read_text())]
    assert len(errors) == len(seen) == CONFIG.epochs
    assert [(progress.epoch, progress.epochs) for progress in seen] == [(n, 5) for n in range(1, 6)]
    assert result.best_error == min(errors) == errors[result.best_epoch]
    assert len((tmp_path / "metrics.csv").read_text().splitlines()) == CONFIG.epochs + 1
    batches = PlanePoints().validation_batches()
    with torch.no_grad():
        error = np.mean([(learner.layers(b[:, :2]) - b[:, 2:]).abs().mean().item() for b in batches])
    assert error == pytest.approx(result.best_error, rel=1e-5)


def test_the_last_epoch_is_kept_if_configured(tmp_path: Path) -> None:
    result = fit(LineLearner(replace(CONFIG, keep="last")), PlanePoints(), tmp_path, seed=3, device="cpu")
    assert result.best_epoch == CONFIG.epochs - 1
    assert result.best_error == result.history[-1][MONITOR]


def test_a_metric_is_the_mean_over_all_examples_of_an_epoch() -> None:
    learner = LineLearner()
    learner.log("validation", 1, error=torch.tensor(4.0))
    learner.log("validation", 3, error=torch.tensor(8.0), loss=torch.tensor(1.0))
    assert {name: float(mean) for name, mean in learner.take_means().items()} == {MONITOR: 7.0, "validation/loss": 1.0}
    assert learner.take_means() == {}


def test_a_non_finite_error_ends_the_training_and_names_the_epoch(tmp_path: Path) -> None:
    class Poisoned(PlanePoints):
        def validation_batches(self) -> list[Tensor]:
            return [torch.full((4, 3), torch.nan)]

    with pytest.raises(InputError, match="after epoch 1 the error is nan"):
        fit(LineLearner(), Poisoned(), tmp_path, device="cpu")
    assert not (tmp_path / "best.pt").exists()


def test_the_number_of_threads_changes_for_the_training_alone(tmp_path: Path) -> None:
    seen: list[int] = []

    class Counting(LineLearner):
        def training_step(self, batch: Tensor) -> Tensor:
            seen.append(torch.get_num_threads())
            return super().training_step(batch)

    before = torch.get_num_threads()
    fit(Counting(replace(CONFIG, epochs=1, threads=before + 1)), PlanePoints(), tmp_path, device="cpu")
    assert set(seen) == {before + 1}
    assert torch.get_num_threads() == before


def test_nothing_is_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    fit(LineLearner(), PlanePoints(), tmp_path, seed=3, device="cpu")
    assert capfd.readouterr() == ("", "")


def test_ctrl_c_raises_keyboard_interrupt_and_the_run_can_be_resumed(tmp_path: Path) -> None:
    def interrupt(_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit(LineLearner(), PlanePoints(), tmp_path, seed=3, device="cpu", on_progress=interrupt)
    assert trained(tmp_path)[1] == [1, 2, 3, 4]


def test_a_missing_device_is_named(tmp_path: Path) -> None:
    for device in ("quantum", "mps:9", "vulkan"):
        with pytest.raises(InputError, match=f"--device: '{device}' is not available here") as raised:
            fit(LineLearner(), PlanePoints(), tmp_path, device=device)
        assert len(str(raised.value)) < 400, "one short line instead of all of torch's message"
