"""Training of several networks: how many at once, what the journal counts, and when networks are replaced."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from trained_workspace import Recorder

from kinmo.config import TrainingConfig
from kinmo.core.errors import InputError
from kinmo.dataset.journal import runs
from kinmo.dataset.workspace import Workspace
from kinmo.learning import weights
from kinmo.learning.model_folder import HEADER, METRICS, WEIGHTS
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.pipeline.network_training import (
    MALLOC_SETTINGS,
    MALLOC_VARIABLE,
    OUTPUTS,
    NetworkTrainer,
    TrainingTask,
    Workload,
)

EPOCHS, UNITS = 5, 7
SCHEDULE = TrainingConfig(epochs=EPOCHS, learning_rate=1e-3, weight_decay=0.0, decay_epochs=0, threads=1)
WORK = Workload(SCHEDULE, UNITS, 0.1)
FACTS = {METRICS: [{"validation/error": 0.5}], HEADER: {"sha256": "0", "facts": {"error": 0.5}}}


def fit(made_of: str | None, done_before: int, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
    """Train for five epochs, some of which an interrupted run has done before.

    The weights state what they are made of, or else the settings of the process's malloc.
    """
    for epoch in range(done_before, EPOCHS):
        on_progress(Progress(epoch + 1, EPOCHS, {}))
    folder.mkdir(parents=True, exist_ok=True)
    for name in OUTPUTS:
        (folder / name).write_text(json.dumps(FACTS.get(name)), encoding="utf-8")
    (folder / WEIGHTS).write_text(made_of or os.environ.get(MALLOC_VARIABLE, "nothing"), encoding="utf-8")
    return FitResult(0, 0.0, ({},) * EPOCHS)


def fail(error: Exception, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
    raise error


def example(folder: Path, name: str = "a network", made_of: str | None = "shapes", done_before: int = 0) -> TrainingTask:
    """A network in a group of its own."""
    inputs = {"made of": made_of, "done before": done_before}
    how = partial(fit, made_of, done_before)
    return TrainingTask(name, f"train-{name}", folder, name, inputs, WORK, ("1 shape", "1"), how)


@pytest.mark.parametrize(("done_before", "amounts"), [(0, [EPOCHS * UNITS]), (3, [2 * UNITS]), (EPOCHS, [])])
def test_the_journal_counts_the_epochs_of_this_run_alone(tmp_path: Path, done_before: int, amounts: list[int]) -> None:
    workspace = Workspace(tmp_path)
    NetworkTrainer(workspace, "cpu", 1).run([example(tmp_path / "models" / "it", done_before=done_before)], Recorder())
    assert [run.amount for run in runs(workspace)] == amounts


@pytest.mark.parametrize("own", [None, "glibc.malloc.hugetlb=0"])
def test_trainings_side_by_side_keep_their_memory_unless_the_user_sets_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own: str | None
) -> None:
    monkeypatch.delenv(MALLOC_VARIABLE, raising=False)
    if own is not None:
        monkeypatch.setenv(MALLOC_VARIABLE, own)
    names = ("one", "other")
    tasks = [example(tmp_path / "models" / name, name, None) for name in names]
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
    works = [replace(WORK, schedule=replace(SCHEDULE, threads=threads))] * 8
    assert NetworkTrainer(Workspace(tmp_path), device, workers).seconds(works) == pytest.approx(8 / at_once * WORK.seconds)


def test_networks_of_a_group_are_replaced_together(tmp_path: Path) -> None:
    workspace, names = Workspace(tmp_path), ("one", "other")
    tasks, new = (
        [replace(example(workspace.models / name, name, made_of), group="both") for name in names]
        for made_of in ("old shapes", "new shapes")
    )

    def networks() -> dict[str, tuple[str, bool]]:
        return {
            task.name: ((task.folder / WEIGHTS).read_text(encoding="utf-8"), workspace.is_current(task.stage, task.inputs))
            for task in tasks
        }

    NetworkTrainer(workspace, "cpu", 1).run(tasks, Recorder())
    assert networks() == dict.fromkeys(names, ("old shapes", True))
    failing = replace(new[1], fit=partial(fail, InputError("it", "fails")))
    with pytest.raises(InputError, match="fails"):
        NetworkTrainer(workspace, "cpu", 1).run([new[0], failing], Recorder())
    assert networks() == dict.fromkeys(names, ("old shapes", True)), "the other network is not finished"
    assert (workspace.training / "one" / WEIGHTS).read_text(encoding="utf-8") == "new shapes", "nothing is lost"
    shutil.rmtree(workspace.training)
    NetworkTrainer(workspace, "cpu", 1).run(new, Recorder())
    assert networks() == dict.fromkeys(names, ("new shapes", False))
    assert not workspace.training.exists()


def test_an_unforeseen_error_names_the_network(tmp_path: Path) -> None:
    broken = replace(example(tmp_path / "models" / "it"), fit=partial(fail, RuntimeError("loss is nan")))
    with pytest.raises(ChildProcessError, match=r"a network could not be trained: RuntimeError at .*: loss is nan"):
        NetworkTrainer(Workspace(tmp_path), "cpu", 1).run([broken], Recorder())


def test_files_of_a_training_that_is_not_needed_any_more_are_removed(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    task = example(workspace.models / "it")
    NetworkTrainer(workspace, "cpu", 1).run([task], Recorder())
    (workspace.training / "it").mkdir(parents=True)
    recorder = Recorder()
    NetworkTrainer(workspace, "cpu", 1).run([task], recorder)
    assert not workspace.training.exists()
    assert recorder.notes == ["a network: already trained"]


def test_an_unfinished_training_for_a_category_stays_when_that_for_all_is_finished(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    checkpoint = workspace.training / "it" / "Pliers" / "last.ckpt"
    checkpoint.parent.mkdir(parents=True)
    checkpoint.write_bytes(b"a checkpoint")
    for _ in range(2):  # trained, and already trained
        NetworkTrainer(workspace, "cpu", 1).run([example(workspace.models / "it")], Recorder())
        assert [path for path in workspace.training.rglob("*") if path.is_file()] == [checkpoint]
