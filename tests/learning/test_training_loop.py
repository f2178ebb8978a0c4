from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from kinmo.config import TrainingConfig
from kinmo.core.errors import InputError
from kinmo.learning.training_loop import MONITOR, Learner, fit

CONFIG = TrainingConfig(epochs=5, learning_rate=0.05, decay_epochs=2)


class Line(Learner):
    def __init__(self, config: TrainingConfig = CONFIG) -> None:
        super().__init__(config)
        torch.manual_seed(0)
        self.layers = nn.Sequential(nn.Linear(2, 8), nn.Dropout(0.3), nn.ReLU(), nn.Linear(8, 1))

    def training_step(self, batch: Tensor, index: int) -> Tensor:
        return (self.layers(batch[:, :2]) - batch[:, 2:]).square().mean()

    def validation_step(self, batch: Tensor, index: int) -> None:
        self.log(MONITOR, (self.layers(batch[:, :2]) - batch[:, 2:]).abs().mean())


class Points:
    """Random points of a plane; `fail_at` is the (epoch, batch) at which reading them fails."""

    def __init__(self, fail_at: tuple[int, int] | None = None) -> None:
        self.fail_at = fail_at
        self.epochs_seen: list[int] = []

    @property
    def epochs(self) -> list[int]:
        return list(dict.fromkeys(self.epochs_seen))

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[Tensor]:
        self.epochs_seen.append(epoch)
        for index in range(4):
            if (epoch, index) == self.fail_at:
                raise RuntimeError("power cut")
            points = torch.from_numpy(rng.normal(size=(16, 3)).astype(np.float32))
            points[:, 2] = points[:, 0] - 2 * points[:, 1]
            yield points

    def validation_batches(self) -> list[Tensor]:
        return list(Points().training_batches(0, np.random.default_rng(99)))


def on_two_processes(folder: Path) -> None:
    """What Lightning runs once a process: train, and write down what came out."""
    config = replace(CONFIG, devices=2, epochs=2)
    module = Line(config)
    result = fit(module, Points(), folder / "run", seed=3, device="cpu")
    said = [result.best_epoch, result.best_error, *(p.detach().tolist() for p in module.parameters())]
    (folder / f"{os.environ['LOCAL_RANK']}.json").write_text(json.dumps(said))


def end_state(folder: Path, config: TrainingConfig = CONFIG, seed: int = 3) -> tuple[list[Tensor], Points]:
    module, data = Line(config), Points()
    fit(module, data, folder, seed=seed, device="cpu")
    return [p.detach().clone() for p in module.parameters()], data


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> list[Tensor]:
    return end_state(tmp_path_factory.mktemp("undisturbed"))[0]


@pytest.mark.parametrize("moment", [(0, 2), (1, 0), (3, 3)])
def test_a_run_that_was_cut_off_ends_as_one_that_was_not(tmp_path: Path, undisturbed: list[Tensor], moment) -> None:
    with pytest.raises(RuntimeError, match="power cut"):
        fit(Line(), Points(moment), tmp_path / "cut", seed=3, device="cpu")
    again, data = end_state(tmp_path / "cut")
    assert data.epochs == list(range(moment[0], CONFIG.epochs)), "finished epochs are not run again"
    assert all(torch.equal(a, b) for a, b in zip(again, undisturbed, strict=True))
    end_state(tmp_path / "whole")
    files = [
        {path.name: path.read_bytes() for path in (tmp_path / name).iterdir() if path.suffix != ".ckpt"}
        for name in ("cut", "whole")
    ]
    assert files[0] == files[1]


AVERAGED = replace(CONFIG, average=0.9)


def test_averaged_weights_are_validated_and_kept_and_survive_a_cut(tmp_path: Path, undisturbed: list[Tensor]) -> None:
    averaged, _ = end_state(tmp_path / "whole", AVERAGED)
    assert not all(torch.equal(a, b) for a, b in zip(averaged, undisturbed, strict=True))
    with pytest.raises(RuntimeError, match="power cut"):
        fit(Line(AVERAGED), Points((2, 1)), tmp_path / "cut", seed=3, device="cpu")
    again, data = end_state(tmp_path / "cut", AVERAGED)
    assert data.epochs == [2, 3, 4]
    assert all(torch.equal(a, b) for a, b in zip(again, averaged, strict=True))


def test_gradients_can_be_clipped_in_mixed_precision(tmp_path: Path) -> None:
    config = replace(CONFIG, precision="bf16-mixed", gradient_clip=1e-9)
    history = fit(Line(config), Points(), tmp_path, device="cpu").history
    assert len(history) == config.epochs


def test_an_average_over_nearly_all_steps_lags_behind(tmp_path: Path) -> None:
    errors = {
        average: fit(Line(replace(CONFIG, average=average)), Points(), tmp_path / str(average), device="cpu").history
        for average in (0.0, 1e-6, 0.9999)
    }
    last = {average: history[1][MONITOR] for average, history in errors.items()}
    assert last[1e-6] == pytest.approx(last[0.0], rel=1e-3)
    assert last[0.9999] > last[0.0]


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_a_cut_checkpoint_gives_way_to_the_previous_one(tmp_path: Path, undisturbed: list[Tensor], share: float) -> None:
    with pytest.raises(RuntimeError):
        fit(Line(), Points((3, 1)), tmp_path, seed=3, device="cpu")
    last = tmp_path / "last.ckpt"
    whole = last.read_bytes()
    last.write_bytes(whole[: int(len(whole) * share)])
    again, data = end_state(tmp_path)
    assert data.epochs == [2, 3, 4]
    assert all(torch.equal(a, b) for a, b in zip(again, undisturbed, strict=True))


def test_a_finished_run_is_not_run_again(tmp_path: Path, undisturbed: list[Tensor]) -> None:
    end_state(tmp_path)
    again, data = end_state(tmp_path)
    assert data.epochs == []
    assert all(torch.equal(a, b) for a, b in zip(again, undisturbed, strict=True))


def test_another_seed_or_configuration_starts_afresh(tmp_path: Path) -> None:
    end_state(tmp_path)
    assert end_state(tmp_path, seed=4)[1].epochs == [0, 1, 2, 3, 4]
    assert end_state(tmp_path, replace(CONFIG, epochs=2), seed=4)[1].epochs == [0, 1]


def test_the_best_epoch_is_kept_and_every_epoch_is_logged(tmp_path: Path) -> None:
    module, seen = Line(), []
    result = fit(module, Points(), tmp_path, seed=3, device="cpu", on_progress=seen.append)
    errors = [row[MONITOR] for row in json.loads((tmp_path / "metrics.json").read_text())]
    assert len(errors) == len(seen) == CONFIG.epochs
    assert result.best_error == min(errors) == errors[result.best_epoch]
    assert len((tmp_path / "metrics.csv").read_text().splitlines()) == CONFIG.epochs + 1
    with torch.no_grad():
        found = np.mean([(module.layers(b[:, :2]) - b[:, 2:]).abs().mean().item() for b in Points().validation_batches()])
    assert found == pytest.approx(result.best_error, rel=1e-5)


def test_the_last_epoch_is_kept_where_that_is_asked_for(tmp_path: Path) -> None:
    result = fit(Line(replace(CONFIG, keep="last")), Points(), tmp_path, seed=3, device="cpu")
    assert result.best_epoch == CONFIG.epochs - 1
    assert result.best_error == result.history[-1][MONITOR]


def test_an_error_that_is_no_number_ends_the_training_and_says_when(tmp_path: Path) -> None:
    class Poisoned(Points):
        def validation_batches(self) -> list[Tensor]:
            return [torch.full((4, 3), torch.nan)]

    with pytest.raises(InputError, match="after epoch 1 the error is nan"):
        fit(Line(), Poisoned(), tmp_path, device="cpu")
    assert not (tmp_path / "best.pt").exists()


def test_threads_are_taken_for_the_training_alone(tmp_path: Path) -> None:
    seen: list[int] = []

    class Counting(Line):
        def training_step(self, batch: Tensor, index: int) -> Tensor:
            seen.append(torch.get_num_threads())
            return super().training_step(batch, index)

    before = torch.get_num_threads()
    fit(Counting(replace(CONFIG, epochs=1, threads=before + 1)), Points(), tmp_path, device="cpu")
    assert set(seen) == {before + 1}
    assert torch.get_num_threads() == before


def test_nothing_is_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    fit(Line(), Points(), tmp_path, seed=3, device="cpu")
    assert capfd.readouterr() == ("", "")


def test_an_interrupt_stays_an_interrupt(tmp_path: Path) -> None:
    def interrupt(_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit(Line(), Points(), tmp_path, seed=3, device="cpu", on_progress=interrupt)
    assert end_state(tmp_path)[1].epochs == [1, 2, 3, 4]


def test_a_device_that_is_not_there_is_named(tmp_path: Path) -> None:
    for device in ("quantum", "mps:9", "vulkan"):
        with pytest.raises(InputError, match=f"--device: '{device}' is not available here") as told:
            fit(Line(), Points(), tmp_path, device=device)
        assert len(str(told.value)) < 400, "not all that torch has to say"


def test_processes_that_train_together_agree(tmp_path: Path) -> None:
    here = Path(__file__)
    script = tmp_path / "script.py"
    script.write_text(
        f"import sys\nfrom pathlib import Path\nsys.path.insert(0, {str(here.parent)!r})\n"
        f"from {here.stem} import on_two_processes\nif __name__ == '__main__':\n    on_two_processes(Path({str(tmp_path)!r}))\n"
    )
    env = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run([sys.executable, str(script)], check=True, capture_output=True, timeout=300, env=env)
    one, other = (json.loads((tmp_path / f"{rank}.json").read_text()) for rank in (0, 1))
    assert one == other
