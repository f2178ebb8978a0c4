"""What is told and kept of networks that are trained."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from whole_road import Listener

from kinmo.config import TrainingConfig
from kinmo.learning.training import FitResult, Progress
from kinmo.pipeline.fitting import KEPT, TUNABLES, Fitter, Work
from kinmo.pipeline.journal import runs
from kinmo.workspace import Workspace

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

    def fit(self, on_progress: Callable[[Progress], None]) -> FitResult:
        for epoch in range(self.done_before, EPOCHS):
            on_progress(Progress(epoch + 1, EPOCHS, {}))
        return FitResult(0, 0.0, ({},) * EPOCHS)


@pytest.mark.parametrize(("done_before", "amounts"), [(0, [EPOCHS * UNITS]), (3, [2 * UNITS]), (EPOCHS, [])])
def test_the_journal_counts_the_epochs_that_the_time_went_into(tmp_path: Path, done_before: int, amounts: list[int]) -> None:
    workspace = Workspace(tmp_path)
    Fitter(workspace, "cpu", 1).run([GoesOn(tmp_path / "models" / "it", done_before)], Listener())
    assert [run.amount for run in runs(workspace)] == amounts


@dataclass(frozen=True)
class Tells(GoesOn):
    """A training that tells what memory its process was told to keep."""

    def fit(self, on_progress: Callable[[Progress], None]) -> FitResult:
        self.folder.mkdir(parents=True)
        (self.folder / "told").write_text(os.environ.get(TUNABLES, "nothing"), encoding="utf-8")
        return FitResult(0, 0.0, ())


@pytest.mark.parametrize("own", [None, "glibc.malloc.hugetlb=0"])
def test_trainings_side_by_side_keep_their_memory_unless_it_is_said_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own: str | None
) -> None:
    monkeypatch.delenv(TUNABLES, raising=False)
    if own is not None:
        monkeypatch.setenv(TUNABLES, own)
    names = ("one", "other")
    fittings = [replace(Tells(tmp_path / "models" / name, 0), name=name, stage=f"train-{name}") for name in names]
    Fitter(Workspace(tmp_path), "cpu", 2).run(fittings, Listener())
    told = {(tmp_path / "models" / name / "told").read_text(encoding="utf-8") for name in names}
    assert told == {own or KEPT}
    assert os.environ.get(TUNABLES) == own, "of those processes alone"
