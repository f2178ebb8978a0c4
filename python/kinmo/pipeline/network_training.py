"""Training of several networks side by side; each is trained once for the same inputs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from kinmo.config import TrainingConfig
from kinmo.core.errors import expecting
from kinmo.core.wording import counted
from kinmo.dataset.jobs import Failure, LocalRunner, allow_kill, report
from kinmo.dataset.journal import timed
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import remove_leftovers, write_bytes_atomically
from kinmo.learning.model_folder import HEADER, METRICS, METRICS_TABLE, WEIGHTS
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.learning.weights import processes_on

OUTPUTS = (WEIGHTS, HEADER, METRICS, METRICS_TABLE)  # files of a finished training
MALLOC_VARIABLE = "GLIBC_TUNABLES"  # environment variable with the settings of glibc's malloc
MALLOC_SETTINGS = "glibc.malloc.hugetlb=1:glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=1073741824"
"""glibc's malloc uses large pages, and keeps up to 1 GiB of freed blocks below 32 MiB for the next step."""


@dataclass(frozen=True)
class Workload:
    """Amount of training: each epoch of the `schedule` processes `units` that take `seconds_per_unit` each."""

    schedule: TrainingConfig
    units: int
    seconds_per_unit: float

    @property
    def seconds(self) -> float:
        """Estimated duration without other trainings beside it."""
        return self.schedule.epochs * self.units * self.seconds_per_unit


@dataclass(frozen=True, eq=False)
class TrainingTask:
    """One network to train.

    A finished network is put into its `folder` when all tasks of the same `group` are finished; until then the networks of an
    earlier training stay in use.
    """

    name: str  # for people
    stage: str  # name of the training's record in the workspace
    folder: Path  # of the trained network, below the workspace's `models`
    group: str
    inputs: dict[str, Any]  # everything that the network depends on, as plain data
    work: Workload
    data: tuple[str, str]  # what it is trained on and validated on, in words
    fit: Callable[[Path, Callable[[Progress], None]], FitResult]
    """Trains the network in a folder, from the last checkpoint there. It runs in another process."""
    wave: int = 0  # networks of a later wave are trained after those of all earlier ones
    before: Callable[[Observer], None] | None = None  # it can be pickled
    """Makes what the training needs, in this process, after the waves before it."""


@dataclass(frozen=True)
class NetworkTrainer:
    """Trains networks, as many at once as `workers`, their threads and the device allow.

    The results do not depend on the number of networks that are trained at once.
    """

    workspace: Workspace
    device: str
    workers: int

    def plan(self, tasks: Sequence[TrainingTask]) -> Plan:
        """List the networks that were not trained from the same inputs."""
        pending = self._pending(tasks)
        steps = tuple(
            f"train {task.name} on {task.data[0]} for {counted(task.work.schedule.epochs, 'epoch')}, validate on {task.data[1]}"
            for task in pending
        )
        return Plan(steps, self.seconds([task.work for task in pending]))

    def seconds(self, works: Sequence[Workload]) -> float:
        """Estimated duration of all training."""
        alone = [work.seconds for work in works]
        return max([sum(alone) / max(self._processes(works), 1), *alone], default=0.0)

    def run(self, tasks: Sequence[TrainingTask], observer: Observer) -> Outcome:
        """Train the pending networks, the longest trainings first. The caller holds the lock of the workspace.

        The outcome has the epochs of each network, the epoch that was kept, and its validation error.
        """
        for folder in (self.workspace.models, self.workspace.training):
            remove_leftovers(folder)
        pending = self._pending(tasks)
        for task in tasks:
            if task not in pending:
                observer.note(f"{task.name}: already trained")
                self._clear(task)

        def on_progress(message: tuple[str, Progress]) -> None:
            name, progress = message
            shown = [f"{key} {value:.3f}" for key, value in progress.metrics.items() if key.endswith(("loss", "/error"))]
            observer.progress(f"training {name}", progress.epoch, progress.epochs, " ".join(shown))

        unfinished = list(pending)
        for wave in sorted({task.wave for task in pending}):
            tasks_of_wave = [task for task in pending if task.wave == wave]
            for task in tasks_of_wave:
                if task.before is not None:
                    task.before(observer)
            processes = self._processes([task.work for task in tasks_of_wave])
            if processes > 1:
                tasks_of_wave = sorted(tasks_of_wave, key=lambda task: -task.work.seconds)
            runner = LocalRunner(processes, threads=0)
            running = closing(runner.run(partial(_fit, self), tasks_of_wave, on_progress))  # no job outlives the lock
            with _memory_kept(), running as finished:
                for task, answer in finished:
                    if isinstance(answer, Failure):
                        raise ChildProcessError(f"{task.name} could not be trained: {answer.reason}")
                    unfinished.remove(task)
                    if not any(other.group == task.group for other in unfinished):
                        for other in (other for other in pending if other.group == task.group):
                            self._put_in_place(other)
        results = {task.name: _result(task.folder) for task in tasks}
        lines = [
            f"{name}: {counted(result['epochs'], 'epoch')}, kept epoch {result['kept']}, validation error {result['error']:.4f}"
            for name, result in results.items()
        ]
        return Outcome(self.workspace.models, results, "\n".join(lines))

    def _pending(self, tasks: Sequence[TrainingTask]) -> list[TrainingTask]:
        return [task for task in tasks if not self.workspace.is_current(task.stage, task.inputs)]

    def training_folder(self, task: TrainingTask) -> Path:
        """Folder of a network during its training."""
        return self.workspace.training / task.folder.relative_to(self.workspace.models)

    def weights_of(self, task: TrainingTask) -> Path:
        """Weights of a network that is trained: in the folder of its training, until it is put in place."""
        made = self.training_folder(task) / WEIGHTS
        return made if made.exists() else task.folder / WEIGHTS

    def _put_in_place(self, task: TrainingTask) -> None:
        """Replace the earlier network by a finished one. The files of the training stay until this is recorded."""
        made = self.training_folder(task)
        self.workspace.forget(task.stage)
        for name in OUTPUTS:
            write_bytes_atomically(task.folder / name, (made / name).read_bytes())
        self.workspace.record(task.stage, task.inputs, [task.folder / name for name in (WEIGHTS, HEADER, METRICS)])
        self._clear(task)

    def _clear(self, task: TrainingTask) -> None:
        """Remove the files of a training, but not the trainings for single categories in folders below it."""
        made = self.training_folder(task)
        for path in made.glob("*"):
            if not path.is_dir():
                path.unlink()
        with suppress(OSError):  # not empty, or absent
            os.removedirs(made)

    def _processes(self, works: Sequence[Workload]) -> int:
        threads = [work.schedule.threads for work in works]
        if not works or 0 in threads:
            return 1
        return min(len(works), processes_on(self.device, self.workers // max(threads)))


@contextmanager
def _memory_kept() -> Iterator[None]:
    """Let processes that start in the block keep freed memory. Otherwise they spend a tenth of their time on getting it anew.

    glibc reads the variable when a process starts; other C libraries ignore it.
    """
    known = os.environ.get(MALLOC_VARIABLE)
    os.environ.setdefault(MALLOC_VARIABLE, MALLOC_SETTINGS)
    try:
        yield
    finally:
        if known is None:
            del os.environ[MALLOC_VARIABLE]


def _fit(trainer: NetworkTrainer, task: TrainingTask) -> None:
    """Train one network, and send its name and its progress to the owner."""
    allow_kill()  # files are whole at any moment
    epochs: list[int] = []  # an interrupted run has counted its own epochs

    def on_progress(progress: Progress) -> None:
        epochs.append(progress.epoch)
        report((task.name, progress))

    with timed(trainer.workspace, task.stage) as watch:
        task.fit(trainer.training_folder(task), on_progress)
        watch.amount = len(epochs) * task.work.units
        watch.what = f"{task.name} for {counted(len(epochs), 'epoch')}"


def fit_on_files(
    trainer: Callable[..., FitResult],
    read: Callable[[Path], Any],
    files: Sequence[Sequence[Path]],
    section: Any,
    options: Mapping[str, Any],
    folder: Path,
    on_progress: Callable[[Progress], None],
) -> FitResult:
    """Train a network in a folder, on what is read from training and validation files."""
    training, validation = ([read(path) for path in paths] for paths in files)
    return trainer(training, validation, section, folder, **options, on_progress=on_progress)


def _result(folder: Path) -> dict[str, Any]:
    with expecting("one entry per epoch", folder / METRICS):
        errors = [row["validation/error"] for row in json.loads((folder / METRICS).read_text(encoding="utf-8"))]
    with expecting("a header of weights", folder / HEADER):
        header = json.loads((folder / HEADER).read_text(encoding="utf-8"))
        digest, error = header["sha256"], header["facts"]["error"]
        kept = min(range(len(errors)), key=lambda epoch: abs(errors[epoch] - error))
    return {"weights": str(folder / WEIGHTS), "sha256": digest, "epochs": len(errors), "kept": kept, "error": error}
