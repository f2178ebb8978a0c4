"""Networks that are trained side by side, each once for the same inputs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from kinmo.config import Config, TrainingConfig, load_config
from kinmo.core.errors import InputError, expecting
from kinmo.core.wording import counted
from kinmo.dataset.journal import timed
from kinmo.dataset.stage import Observer, Outcome
from kinmo.dataset.workers import Crashed, map_unordered, may_be_cut_off, tell
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.io.atomic_files import write_bytes_atomically
from kinmo.learning.model_folder import HEADER, METRICS, METRICS_TABLE, WEIGHTS
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.learning.weights import processes_on

OUTPUTS = (WEIGHTS, HEADER, METRICS, METRICS_TABLE)
"""What a training leaves."""
TUNABLES = "GLIBC_TUNABLES"
KEPT = "glibc.malloc.hugetlb=1:glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=1073741824"
"""Of glibc's malloc: large pages; blocks below 32 MiB, the most that it takes, from memory that is kept; up to 1 GiB of it."""


@dataclass(frozen=True)
class Work:
    """How much there is to train: an epoch goes through so many `units`, in the journal's unit of the stage."""

    schedule: TrainingConfig
    units: int
    seconds_per_unit: float

    @property
    def seconds(self) -> float:
        """About how long it takes alone."""
        return self.schedule.epochs * self.units * self.seconds_per_unit


class Fitting(Protocol):
    """One network to be trained: what it is called, the record of its training, and how it is done.

    It goes into its `folder` in the workspace's `models` once all that have the same `together` are trained: until then those
    that were there answer.
    """

    @property
    def name(self) -> str: ...

    @property
    def stage(self) -> str: ...

    @property
    def folder(self) -> Path: ...

    @property
    def together(self) -> str: ...

    @property
    def inputs(self) -> dict[str, Any]: ...

    @property
    def work(self) -> Work: ...

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        """Train it into a folder, going on from what was begun there. Runs in another process."""


@dataclass(frozen=True)
class Fitter:
    """Trains what is not trained yet, as many at once as `workers`, the networks' threads and the device allow.

    What comes out does not depend on how many are trained at once. Small networks leave most of a GPU to others.
    """

    workspace: Workspace
    device: str
    workers: int

    def pending(self, fittings: Sequence[Fitting]) -> list[Fitting]:
        """Those that were not trained from the same inputs."""
        return [each for each in fittings if not self.workspace.is_current(each.stage, each.inputs)]

    def seconds(self, works: Sequence[Work]) -> float:
        """About how long all of it takes."""
        alone = [each.seconds for each in works]
        return max([sum(alone) / max(self._at_once(works), 1), *alone], default=0.0)

    def run(self, fittings: Sequence[Fitting], observer: Observer) -> None:
        """Train those that are pending, the ones that take longest first."""
        pending = self.pending(fittings)
        for each in fittings:
            if each not in pending:
                observer.note(f"{each.name}: trained already")
                self._clear(each)

        def on_progress(told: tuple[str, Progress]) -> None:
            name, progress = told
            shown = [f"{key} {value:.3f}" for key, value in progress.metrics.items() if key.endswith(("loss", "/error"))]
            observer.progress(f"training {name}", progress.epoch, progress.epochs, " ".join(shown))

        at_once = self._at_once([each.work for each in pending])
        if at_once > 1:
            pending = sorted(pending, key=lambda each: -each.work.seconds)
        done: set[str] = set()
        with _memory_kept():
            for each, answer in map_unordered(partial(_fit, self), pending, at_once, on_progress):
                if isinstance(answer, Crashed):
                    raise ChildProcessError(f"the process that trained {each.name} died: too little memory?")
                done.add(each.name)
                own = [other for other in pending if other.together == each.together]
                if all(other.name in done for other in own):
                    for other in own:
                        self._put_in_place(other)

    def place_of(self, fitting: Fitting) -> Path:
        """Where a network is while it is trained."""
        return self.workspace.training / fitting.folder.relative_to(self.workspace.models)

    def _put_in_place(self, fitting: Fitting) -> None:
        """Let a network that is trained take the place of the one before. What is to be copied stays until all is recorded."""
        made = self.place_of(fitting)
        self.workspace.forget(fitting.stage)
        for name in OUTPUTS:
            write_bytes_atomically(fitting.folder / name, (made / name).read_bytes())
        outputs = tuple(str((fitting.folder / name).relative_to(self.workspace.path)) for name in (WEIGHTS, HEADER, METRICS))
        self.workspace.write_record(fitting.stage, StageRecord(fitting.inputs, outputs))
        self._clear(fitting)

    def _clear(self, fitting: Fitting) -> None:
        """Drop what only an unfinished training needs, several times as large as the weights.

        Trainings of single categories lie below that of all, and stay.
        """
        made = self.place_of(fitting)
        for path in made.glob("*"):
            if not path.is_dir():
                path.unlink()
        with suppress(OSError):  # not empty, or not there
            os.removedirs(made)

    def _at_once(self, works: Sequence[Work]) -> int:
        threads = [each.schedule.threads for each in works]
        if not works or 0 in threads:
            return 1
        return min(len(works), processes_on(self.device, self.workers // max(threads)))


@contextmanager
def _memory_kept() -> Iterator[None]:
    """Processes that start in the block keep the memory that a step frees, for the next one, and in large pages: to be given it
    anew each time takes them a tenth of their time. (glibc reads this when a process starts; others pass over it.)
    """
    known = os.environ.get(TUNABLES)
    os.environ.setdefault(TUNABLES, KEPT)
    try:
        yield
    finally:
        if known is None:
            del os.environ[TUNABLES]


def config_to_train_by(name: str, sections: Sequence[str]) -> Config:
    """The configuration of that name or path.

    Raises InputError if one of the `sections` is for several devices: each would run the command anew, and find the workspace
    locked.
    """
    config = load_config(name)
    for section in sections:
        if getattr(config, section).training.devices > 1:
            raise InputError(name, "kinmo train uses one device, expected 1", f"{section}.training.devices")
    return config


def _fit(fitter: Fitter, fitting: Fitting) -> None:
    """Train one network. Progress is told (`workers.tell`) as its name and a `Progress`."""
    may_be_cut_off()  # what is on the disk is whole at any moment
    epochs: list[int] = []  # those before it was cut off have had their time

    def on_progress(progress: Progress) -> None:
        epochs.append(progress.epoch)
        tell((fitting.name, progress))

    with timed(fitter.workspace, fitting.stage) as watch:
        fitting.fit(fitter.place_of(fitting), on_progress)
        watch.amount = len(epochs) * fitting.work.units
        watch.what = f"{fitting.name} for {counted(len(epochs), 'epoch')}"


def trained(workspace: Workspace, fittings: Sequence[Fitting]) -> Outcome:
    """What came of trainings that are done."""
    results = {each.name: result_of(each.folder) for each in fittings}
    lines = [
        f"{name}: {result['epochs']} epochs, kept {result['kept']}, error {result['error']:.4f}"
        for name, result in results.items()
    ]
    return Outcome(workspace.models, results, "\n".join(lines))


def result_of(folder: Path) -> dict[str, Any]:
    """What a training left in its folder, as plain data."""
    with expecting("one entry an epoch", folder / METRICS):
        errors = [row["validation/error"] for row in json.loads((folder / METRICS).read_text(encoding="utf-8"))]
    with expecting("what weights are for", folder / HEADER):
        header = json.loads((folder / HEADER).read_text(encoding="utf-8"))
        digest, error = header["sha256"], header["facts"]["error"]
        kept = min(range(len(errors)), key=lambda epoch: abs(errors[epoch] - error))
    return {"weights": str(folder / WEIGHTS), "sha256": digest, "epochs": len(errors), "kept": kept, "error": error}
