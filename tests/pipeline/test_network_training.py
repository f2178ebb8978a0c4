"""What is told and kept of networks that are trained."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from trained_workspace import Recorder

from kinmo.config import TrainingConfig
from kinmo.core.errors import InputError
from kinmo.dataset.journal import runs
from kinmo.dataset.workspace import Workspace
from kinmo.learning import weights
from kinmo.learning.model_folder import WEIGHTS
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.pipeline.network_training import KEPT, OUTPUTS, TUNABLES, Fitter, Work

EPOCHS, UNITS = 5, 7


@dataclass(frozen=True)
class GoesOn:
    """A training of five epochs, of which an earlier one has done the first."""

    folder: Path
    done_before: int
    name: str = "a network"
    stage: str = "train-it"

    @property
    def inputs(self) -> dict[str, Any]:
        return {"done before": self.done_before}

    @property
    def work(self) -> Work:
        return Work(TrainingConfig(epochs=EPOCHS, learning_rate=1e-3, weight_decay=0.0, decay_epochs=0, threads=1), UNITS, 0.1)

    @property
    def together(self) -> str:
        return self.name

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        for epoch in range(self.done_before, EPOCHS):
            on_progress(Progress(epoch + 1, EPOCHS, {}))
        folder.mkdir(parents=True, exist_ok=True)
        for name in OUTPUTS:
            (folder / name).write_text(f"{name} of {self.name}", encoding="utf-8")
        return FitResult(0, 0.0, ({},) * EPOCHS)


@pytest.mark.parametrize(("done_before", "amounts"), [(0, [EPOCHS * UNITS]), (3, [2 * UNITS]), (EPOCHS, [])])
def test_the_journal_counts_the_epochs_that_the_time_went_into(tmp_path: Path, done_before: int, amounts: list[int]) -> None:
    workspace = Workspace(tmp_path)
    Fitter(workspace, "cpu", 1).run([GoesOn(tmp_path / "models" / "it", done_before)], Recorder())
    assert [run.amount for run in runs(workspace)] == amounts


@dataclass(frozen=True)
class Tells(GoesOn):
    """A training whose weights tell what memory its process was told to keep."""

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        result = super().fit(folder, on_progress)
        (folder / WEIGHTS).write_text(os.environ.get(TUNABLES, "nothing"), encoding="utf-8")
        return result


@pytest.mark.parametrize("own", [None, "glibc.malloc.hugetlb=0"])
def test_trainings_side_by_side_keep_their_memory_unless_it_is_said_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own: str | None
) -> None:
    monkeypatch.delenv(TUNABLES, raising=False)
    if own is not None:
        monkeypatch.setenv(TUNABLES, own)
    names = ("one", "other")
    fittings = [replace(Tells(tmp_path / "models" / name, 0), name=name, stage=f"train-{name}") for name in names]
    Fitter(Workspace(tmp_path), "cpu", 2).run(fittings, Recorder())
    told = {(tmp_path / "models" / name / WEIGHTS).read_text(encoding="utf-8") for name in names}
    assert told == {own or KEPT}
    assert os.environ.get(TUNABLES) == own, "of those processes alone"


@pytest.mark.parametrize(
    ("device", "threads", "workers", "at_once"),
    [
        ("cpu", 1, 16, 8),
        ("cpu", 1, 2, 2),
        ("cpu", 4, 10, 2),
        ("cpu", 0, 16, 1),
        ("cuda", 1, 16, 4),
        ("cuda", 1, 1, 1),
        ("cuda", 0, 16, 1),
    ],
)
def test_as_many_networks_are_trained_at_once_as_workers_threads_and_the_device_allow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, device: str, threads: int, workers: int, at_once: int
) -> None:
    monkeypatch.setattr(weights, "pick_device", lambda name: name)
    work = GoesOn(tmp_path, 0).work
    works = [replace(work, schedule=replace(work.schedule, threads=threads))] * 8
    assert Fitter(Workspace(tmp_path), device, workers).seconds(works) == pytest.approx(8 / at_once * work.seconds)


@dataclass(frozen=True)
class OneOfTwo(GoesOn):
    """A training that answers together with another, and fails if it is told to."""

    inputs_of: str = "old shapes"
    fails: bool = False

    @property
    def inputs(self) -> dict[str, Any]:
        return {"shapes": self.inputs_of}

    @property
    def together(self) -> str:
        return "both"

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        if self.fails:
            raise InputError(folder, "fails")
        result = super().fit(folder, on_progress)
        (folder / WEIGHTS).write_text(self.inputs_of, encoding="utf-8")
        return result


def test_networks_that_answer_together_take_the_place_of_those_before_together(tmp_path: Path) -> None:
    workspace, names = Workspace(tmp_path), ("one", "other")
    two = [OneOfTwo(workspace.models / name, 0, name, f"train-{name}") for name in names]

    def known() -> dict[str, tuple[str, bool]]:
        return {
            each.name: ((each.folder / WEIGHTS).read_text(encoding="utf-8"), workspace.is_current(each.stage, each.inputs))
            for each in two
        }

    Fitter(workspace, "cpu", 1).run(two, Recorder())
    assert known() == dict.fromkeys(names, ("old shapes", True))
    anew = [replace(each, inputs_of="new shapes") for each in two]
    with pytest.raises(InputError, match="fails"):
        Fitter(workspace, "cpu", 1).run([anew[0], replace(anew[1], fails=True)], Recorder())
    assert known() == dict.fromkeys(names, ("old shapes", True)), "while the others are not done"
    assert (workspace.training / "one" / WEIGHTS).read_text(encoding="utf-8") == "new shapes", "nothing is lost"
    shutil.rmtree(workspace.training)
    Fitter(workspace, "cpu", 1).run(anew, Recorder())
    assert known() == dict.fromkeys(names, ("new shapes", False))
    assert not workspace.training.exists()


def test_what_was_begun_and_is_not_wanted_any_more_goes(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    fitting = GoesOn(workspace.models / "it", 0)
    Fitter(workspace, "cpu", 1).run([fitting], Recorder())
    (workspace.training / "it").mkdir(parents=True)
    Fitter(workspace, "cpu", 1).run([fitting], Recorder())
    assert not workspace.training.exists()


def test_what_was_begun_of_a_category_stays_when_what_lies_above_it_is_done(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    begun = workspace.training / "it" / "Laptop" / "last.ckpt"
    begun.parent.mkdir(parents=True)
    begun.write_bytes(b"a checkpoint")
    for _ in range(2):  # trained, and trained already
        Fitter(workspace, "cpu", 1).run([GoesOn(workspace.models / "it", 0)], Recorder())
        assert [path for path in workspace.training.rglob("*") if path.is_file()] == [begun]
