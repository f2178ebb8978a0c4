"""Training the networks of a workspace."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from kinmo.config import Config, load_config
from kinmo.errors import InputError, expecting
from kinmo.learning.training import Progress, remove_checkpoints
from kinmo.learning.weights import Weights, load_weights, pick_device
from kinmo.pipeline.dataset import Dataset, open_dataset
from kinmo.pipeline.journal import seconds_per_unit, timed
from kinmo.pipeline.model_files import CONFIG, HEADER, METRICS, WEIGHTS, model_folder
from kinmo.pipeline.models import CONTINUED, GROUPS, TRAINERS
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.splits import Split
from kinmo.store import IndexEntry
from kinmo.typed_tables import to_table
from kinmo.workers import Crashed, map_unordered, may_be_cut_off, tell
from kinmo.workspace import StageRecord, Workspace, remove_leftovers, write_text_atomically

SECONDS_PER_SHAPE = {"gnn_fine": 0.004, "gnn_coarse": 0.004, "axis": 0.02, "ranking": 0.02, "gnn_contact": 0.004}
"""Of an epoch on one CPU core with the configuration `small`, until the journal knows better."""


@dataclass(frozen=True)
class Task:
    """One network to be trained on the shapes of `training`, chosen by those of `validation`."""

    model: str
    category: str | None
    training: tuple[IndexEntry, ...]
    validation: tuple[IndexEntry, ...]
    inputs: dict[str, Any]
    start: Path | None = None

    @property
    def name(self) -> str:
        return f"{self.model} ({self.category})" if self.category else self.model

    @property
    def stage(self) -> str:
        return f"train-{self.model}-{self.category}" if self.category else f"train-{self.model}"


@dataclass(frozen=True)
class Train:
    """Train the networks of `group` (`models.GROUPS`), on all categories or on one.

    Those that can (`models.CONTINUED`) go on from the trained ones of the workspace `start` where it is given. On a CPU as many
    are trained at once as `workers` and the configuration's threads allow; what comes out does not depend on it.
    """

    group: str
    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None

    def plan(self) -> Plan:
        config = self._config()
        tasks = list(self._tasks(open_dataset(self.workspace, self.category), config))
        pending = [task for task in tasks if not self.workspace.is_current(task.stage, task.inputs)]
        steps = tuple(
            f"train {task.name} on {len(task.training)} shapes for {self._epochs(task, config)} epochs, "
            f"choose by {len(task.validation)}"
            for task in pending
        )
        alone = [self._seconds(task, config) for task in pending]
        return Plan(steps, max([sum(alone) / max(self._workers(pending, config), 1), *alone], default=0.0))

    def run(self, observer: Observer) -> Outcome:
        config = self._config()
        dataset = open_dataset(self.workspace, self.category)
        with self.workspace.locked():
            remove_leftovers(self.workspace.models)
            tasks = list(self._tasks(dataset, config))  # whatever cannot be trained is said before anything is
            pending = [task for task in tasks if not self.workspace.is_current(task.stage, task.inputs)]
            for task in tasks:
                if task not in pending:
                    observer.note(f"{task.name}: trained already")
                    remove_checkpoints(self._folder(task))
            self._train_all(pending, config, observer)
            write_text_atomically(self.workspace.models / CONFIG, json.dumps(to_table(config), indent=1) + "\n")
        results = {task.name: _result(self._folder(task)) for task in tasks}
        lines = [
            f"{name}: {result['epochs']} epochs, kept {result['kept']}, error {result['error']:.4f}"
            for name, result in results.items()
        ]
        return Outcome(self.workspace.models, results, "\n".join(lines))

    def _config(self) -> Config:
        """Raises InputError for several devices: each would run the command anew, and find the workspace locked."""
        config = load_config(self.config)
        for section in ("gnn", "axis", "ranking"):
            if getattr(config, section).training.devices > 1:
                raise InputError(self.config, "kinmo train uses one device, expected 1", f"{section}.training.devices")
        return config

    def _tasks(self, dataset: Dataset, config: Config) -> Iterator[Task]:
        if self.start is not None and not CONTINUED.keys() & set(GROUPS[self.group]):
            able = ", ".join(name for name, models in GROUPS.items() if CONTINUED.keys() & set(models))
            raise InputError("--from", f"{self.group} goes on from nothing, expected it with one of {able}")
        for model in GROUPS[self.group]:
            start = self._start_of(model)
            section = getattr(config, TRAINERS[model][0])
            categories = dataset.categories() if getattr(section, "per_category", False) else (None,)
            for category in categories:
                training, validation = (
                    tuple(e for e in dataset.labelled[split] if category in (None, e.category))
                    for split in (Split.TRAIN, Split.VALIDATION)
                )
                if not (training and validation):
                    if category is not None:
                        continue
                    problem = f"{len(training)} labelled shapes to train on and {len(validation)} to choose by: both are needed"
                    raise InputError(self.workspace.prepared, problem)
                data = {"training": dataset.fingerprint(training), "validation": dataset.fingerprint(validation)}
                inputs = {"model": model, "config": to_table(section), "seed": self.seed, "data": data}
                if start is not None:
                    inputs["start"] = start.sha256
                yield Task(model, category, training, validation, inputs, None if start is None else start.path)

    def _start_of(self, model: str) -> Weights | None:
        """The weights that a model is to go on from. Raises InputError if they were never trained, or cannot be read."""
        if self.start is None or model not in CONTINUED:
            return None
        weights = model_folder(self.start, model) / WEIGHTS
        if not weights.exists():
            raise InputError(
                weights, "expected the weights to go on from: run kinmo train all in that workspace first", "--from"
            )
        return load_weights(weights, CONTINUED[model][0])

    def _train_all(self, tasks: list[Task], config: Config, observer: Observer) -> None:
        """Side by side where each says how many threads it takes; those that take longest first."""

        def on_progress(told: tuple[str, Progress]) -> None:
            name, progress = told
            shown = [f"{key} {value:.3f}" for key, value in progress.metrics.items() if key.endswith(("loss", "/error"))]
            observer.progress(f"training {name}", progress.epoch, progress.epochs, " ".join(shown))

        workers = self._workers(tasks, config)
        if workers > 1:
            tasks = sorted(tasks, key=lambda task: -self._seconds(task, config))
        for task, answer in map_unordered(partial(self._train_one, config), tasks, workers, on_progress):
            if isinstance(answer, Crashed):
                raise ChildProcessError(f"the process that trained {task.name} died: too little memory?")

    def _workers(self, tasks: list[Task], config: Config) -> int:
        threads: list[int] = [self._section(task, config).training.threads for task in tasks]
        if not tasks or 0 in threads or pick_device(self.device) != "cpu":
            return 1
        return min(len(tasks), self.workers // max(threads))

    def _train_one(self, config: Config, task: Task) -> None:
        """Train one network. Progress is told (`workers.tell`) as the task's name and a `Progress`."""
        may_be_cut_off()  # what is on the disk is whole at any moment
        dataset, section = open_dataset(self.workspace, self.category), self._section(task, config)
        training, validation = dataset.load(task.training), dataset.load(task.validation)
        folder = self._folder(task)
        self.workspace.forget(task.stage)
        trainer = TRAINERS[task.model][1] if task.start is None else CONTINUED[task.model][1](task.start)
        with timed(self.workspace, task.stage) as watch:
            result = trainer(
                training,
                validation,
                section,
                folder,
                seed=self.seed,
                device=self.device,
                fingerprint=json.dumps(task.inputs["data"]),
                on_progress=lambda progress: tell((task.name, progress)),
            )
            watch.amount = len(result.history) * len(task.training)
            watch.what = f"{task.name} on {len(task.training)} shapes for {len(result.history)} epochs"
        outputs = tuple(str((folder / name).relative_to(self.workspace.path)) for name in (WEIGHTS, HEADER, METRICS))
        self.workspace.write_record(task.stage, StageRecord(task.inputs, outputs))
        remove_checkpoints(folder)

    def _folder(self, task: Task) -> Path:
        return model_folder(self.workspace, task.model, task.category)

    def _section(self, task: Task, config: Config) -> Any:
        return getattr(config, TRAINERS[task.model][0])

    def _epochs(self, task: Task, config: Config) -> int:
        section = self._section(task, config)
        return int((section.training if task.start is None else section.continued.training).epochs)

    def _seconds(self, task: Task, config: Config) -> float:
        """About how long a network takes alone."""
        a_shape = seconds_per_unit(self.workspace, task.stage, SECONDS_PER_SHAPE[task.model])
        return len(task.training) * self._epochs(task, config) * a_shape


def _result(folder: Path) -> dict[str, Any]:
    with expecting("one entry an epoch", folder / METRICS):
        errors = [row["validation/error"] for row in json.loads((folder / METRICS).read_text(encoding="utf-8"))]
    with expecting("what weights are for", folder / HEADER):
        header = json.loads((folder / HEADER).read_text(encoding="utf-8"))
        digest, error = header["sha256"], header["facts"]["error"]
        kept = min(range(len(errors)), key=lambda epoch: abs(errors[epoch] - error))
    return {"weights": str(folder / WEIGHTS), "sha256": digest, "epochs": len(errors), "kept": kept, "error": error}
