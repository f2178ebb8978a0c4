"""Training the networks of a workspace."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from kinmo.config import Config, load_config
from kinmo.errors import InputError, expecting
from kinmo.learning.training import Progress, remove_checkpoints
from kinmo.pipeline.dataset import Dataset, open_dataset
from kinmo.pipeline.journal import seconds_per_unit, timed
from kinmo.pipeline.model_files import CONFIG, HEADER, METRICS, WEIGHTS, model_folder
from kinmo.pipeline.models import CONTINUED, GROUPS, TRAINERS
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.splits import Split
from kinmo.store import IndexEntry
from kinmo.typed_tables import to_table
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

    Those that can (`models.CONTINUED`) go on from the trained ones of the workspace `start` where it is given.
    """

    group: str
    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    device: str = "auto"
    start: Workspace | None = None

    def plan(self) -> Plan:
        config = self._config()
        steps, seconds = [], 0.0
        for task in self._tasks(open_dataset(self.workspace, self.category), config):
            if not self.workspace.is_current(task.stage, task.inputs):
                section = getattr(config, TRAINERS[task.model][0])
                epochs = (section.training if task.start is None else section.continued.training).epochs
                shapes = len(task.training)
                steps.append(f"train {task.name} on {shapes} shapes for {epochs} epochs, choose by {len(task.validation)}")
                seconds += shapes * epochs * seconds_per_unit(self.workspace, task.stage, SECONDS_PER_SHAPE[task.model])
        return Plan(tuple(steps), seconds)

    def run(self, observer: Observer) -> Outcome:
        config = self._config()
        dataset = open_dataset(self.workspace, self.category)
        with self.workspace.locked():
            remove_leftovers(self.workspace.models)
            tasks = list(self._tasks(dataset, config))  # whatever cannot be trained is said before anything is
            results = [self._train(task, dataset, config, observer) for task in tasks]
            write_text_atomically(self.workspace.models / CONFIG, json.dumps(to_table(config), indent=1) + "\n")
        lines = [
            f"{name}: {result['epochs']} epochs, best {result['best']}, error {result['error']:.4f}" for name, result in results
        ]
        return Outcome(self.workspace.models, dict(results), "\n".join(lines))

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
                    inputs["start"] = sha256(start.read_bytes()).hexdigest()
                yield Task(model, category, training, validation, inputs, start)

    def _start_of(self, model: str) -> Path | None:
        """The weights that a model is to go on from. Raises InputError if they were never trained."""
        if self.start is None or model not in CONTINUED:
            return None
        weights = model_folder(self.start, model) / WEIGHTS
        if not weights.exists():
            raise InputError(
                weights, "expected the weights to go on from: run kinmo train all in that workspace first", "--from"
            )
        return weights

    def _train(self, task: Task, dataset: Dataset, config: Config, observer: Observer) -> tuple[str, dict[str, Any]]:
        folder = model_folder(self.workspace, task.model, task.category)
        if self.workspace.is_current(task.stage, task.inputs):
            observer.note(f"{task.name}: trained already")
            remove_checkpoints(folder)
            return task.name, _result(folder)
        training, validation = dataset.load(task.training), dataset.load(task.validation)
        self.workspace.forget(task.stage)
        section, trainer = TRAINERS[task.model]
        if task.start is not None:
            trainer = CONTINUED[task.model](task.start)

        def on_progress(progress: Progress) -> None:
            shown = " ".join(
                f"{name} {value:.3f}" for name, value in progress.metrics.items() if name.endswith(("loss", "/error"))
            )
            observer.progress(f"training {task.name}", progress.epoch, progress.epochs, shown)

        with timed(self.workspace, task.stage) as watch:
            result = trainer(
                training,
                validation,
                getattr(config, section),
                folder,
                seed=self.seed,
                device=self.device,
                fingerprint=json.dumps(task.inputs["data"]),
                on_progress=on_progress,
            )
            watch.amount = len(result.history) * len(task.training)
            watch.what = f"{task.name} on {len(task.training)} shapes for {len(result.history)} epochs"
        outputs = tuple(str((folder / name).relative_to(self.workspace.path)) for name in (WEIGHTS, HEADER, METRICS))
        self.workspace.write_record(task.stage, StageRecord(task.inputs, outputs))
        remove_checkpoints(folder)
        return task.name, _result(folder)


def _result(folder: Path) -> dict[str, Any]:
    with expecting("one entry an epoch", folder / METRICS):
        errors = [row["validation/error"] for row in json.loads((folder / METRICS).read_text(encoding="utf-8"))]
        best = min(range(len(errors)), key=errors.__getitem__)
    with expecting("what weights are for", folder / HEADER):
        digest = json.loads((folder / HEADER).read_text(encoding="utf-8"))["sha256"]
    return {"weights": str(folder / WEIGHTS), "sha256": digest, "epochs": len(errors), "best": best, "error": errors[best]}
