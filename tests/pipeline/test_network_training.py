"""Training of several networks: how many at once, what the journal counts, and when networks are replaced."""

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
from kinmo.pipeline.network_training import MALLOC_SETTINGS, MALLOC_VARIABLE, OUTPUTS, NetworkTrainer, Workload

EPOCHS, UNITS = 5, 7


@dataclass(frozen=True)
class ExampleTask:
    """A training of five epochs, some of which an interrupted run has done before."""

    folder: Path
    done_before: int
    name: str = "a network"
    stage: str = "train-it"

    @property
    def inputs(self) -> dict[str, Any]:
        return {"done before": self.done_before}

    @property
    def work(self) -> Workload:
        schedule = TrainingConfig(epochs=EPOCHS, learning_rate=1e-3, weight_decay=0.0, decay_epochs=0, threads=1)
        return Workload(schedule, UNITS, 0.1)

    @property
    def group(self) -> str:
        return self.name

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        for epoch in range(self.done_before, EPOCHS):
            on_progress(Progress(epoch + 1, EPOCHS, {}))
        folder.mkdir(parents=True, exist_ok=True)
        for name in OUTPUTS:
            (folder / name).write_text(f"{name} of {self.name}", encoding="utf-8")
        return FitResult(0, 0.0, ({},) * EPOCHS)


@pytest.mark.parametrize(("done_before", "amounts"), [(0, [EPOCHS * UNITS]), (3, [2 * UNITS]), (EPOCHS, [])])
def test_the_journal_counts_the_epochs_of_this_run_alone(tmp_path: Path, done_before: int, amounts: list[int]) -> None:
    workspace = Workspace(tmp_path)
    NetworkTrainer(workspace, "cpu", 1).run([ExampleTask(tmp_path / "models" / "it", done_before)], Recorder())
    assert [run.amount for run in runs(workspace)] == amounts


@dataclass(frozen=True)
class MallocTask(ExampleTask):
    """A training that writes the settings of its process's malloc in place of weights."""

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        result = super().fit(folder, on_progress)
        (folder / WEIGHTS).write_text(os.environ.get(MALLOC_VARIABLE, "nothing"), encoding="utf-8")
        return result


@pytest.mark.parametrize("own", [None, "glibc.malloc.hugetlb=0"])
def test_trainings_side_by_side_keep_their_memory_unless_the_user_sets_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own: str | None
) -> None:
    monkeypatch.delenv(MALLOC_VARIABLE, raising=False)
    if own is not None:
        monkeypatch.setenv(MALLOC_VARIABLE, own)
    names = ("one", "other")
    tasks = [replace(MallocTask(tmp_path / "models" / name, 0), name=name, stage=f"train-{name}") for name in names]
    NetworkTrainer(Workspace(tmp_path), "cpu", 2).run(tasks, Recorder())
    found = {(tmp_path / "models" / name / WEIGHTS).read_text(encoding="utf-8") for name in names}
    assert found == {own or MALLOC_SETTINGS}
    assert os.environ.get(MALLOC_VARIABLE) == own, "only the workers have the settings"


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
def test_workers_threads_and_device_limit_the_networks_trained_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, device: str, threads: int, workers: int, at_once: int
) -> None:
    monkeypatch.setattr(weights, "pick_device", lambda name: name)
    work = ExampleTask(tmp_path, 0).work
    works = [replace(work, schedule=replace(work.schedule, threads=threads))] * 8
    assert NetworkTrainer(Workspace(tmp_path), device, workers).seconds(works) == pytest.approx(8 / at_once * work.seconds)


@dataclass(frozen=True)
class GroupedTask(ExampleTask):
    """A training in a group with another; it may fail."""

    shapes: str = "old shapes"
    fails: bool = False

    @property
    def inputs(self) -> dict[str, Any]:
        return {"shapes": self.shapes}

    @property
    def group(self) -> str:
        return "both"

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        if self.fails:
            raise InputError(folder, "fails")
        result = super().fit(folder, on_progress)
        (folder / WEIGHTS).write_text(self.shapes, encoding="utf-8")
        return result


def test_networks_of_a_group_are_replaced_together(tmp_path: Path) -> None:
    workspace, names = Workspace(tmp_path), ("one", "other")
    tasks = [GroupedTask(workspace.models / name, 0, name, f"train-{name}") for name in names]

    def networks() -> dict[str, tuple[str, bool]]:
        return {
            task.name: ((task.folder / WEIGHTS).read_text(encoding="utf-8"), workspace.is_current(task.stage, task.inputs))
            for task in tasks
        }

    NetworkTrainer(workspace, "cpu", 1).run(tasks, Recorder())
    assert networks() == dict.fromkeys(names, ("old shapes", True))
    new = [replace(task, shapes="new shapes") for task in tasks]
    with pytest.raises(InputError, match="fails"):
        NetworkTrainer(workspace, "cpu", 1).run([new[0], replace(new[1], fails=True)], Recorder())
    assert networks() == dict.fromkeys(names, ("old shapes", True)), "the other network is not finished"
    assert (workspace.training / "one" / WEIGHTS).read_text(encoding="utf-8") == "new shapes", "nothing is lost"
    shutil.rmtree(workspace.training)
    NetworkTrainer(workspace, "cpu", 1).run(new, Recorder())
    assert networks() == dict.fromkeys(names, ("new shapes", False))
    assert not workspace.training.exists()


def test_an_unforeseen_error_names_the_network(tmp_path: Path) -> None:
    class Broken(ExampleTask):
        def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
            raise RuntimeError("loss is nan")

    with pytest.raises(ChildProcessError, match=r"a network could not be trained: RuntimeError at .*: loss is nan"):
        NetworkTrainer(Workspace(tmp_path), "cpu", 1).run([Broken(tmp_path / "models" / "it", 0)], Recorder())


def test_files_of_a_training_that_is_not_needed_any_more_are_removed(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    task = ExampleTask(workspace.models / "it", 0)
    NetworkTrainer(workspace, "cpu", 1).run([task], Recorder())
    (workspace.training / "it").mkdir(parents=True)
    recorder = Recorder()
    NetworkTrainer(workspace, "cpu", 1).run([task], recorder)
    assert not workspace.training.exists()
    assert recorder.notes == ["a network: already trained"]


def test_an_unfinished_training_for_a_category_stays_when_that_for_all_is_finished(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    checkpoint = workspace.training / "it" / "Laptop" / "last.ckpt"
    checkpoint.parent.mkdir(parents=True)
    checkpoint.write_bytes(b"a checkpoint")
    for _ in range(2):  # trained, and already trained
        NetworkTrainer(workspace, "cpu", 1).run([ExampleTask(workspace.models / "it", 0)], Recorder())
        assert [path for path in workspace.training.rglob("*") if path.is_file()] == [checkpoint]
