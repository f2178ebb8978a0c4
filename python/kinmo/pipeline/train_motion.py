"""Training the networks that see whole shapes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.config import Config
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit
from kinmo.dataset.shape_dataset import Dataset, open_dataset
from kinmo.dataset.splits import Split, kept_to_choose_by
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import remove_leftovers, write_text_atomically
from kinmo.learning.model_folder import CONFIG, WEIGHTS, ModelFolder
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.learning.weights import Weights, load_weights
from kinmo.methods import METHOD_MODELS
from kinmo.pipeline.motion_models import CONTINUED, GROUPS, TRAINERS
from kinmo.pipeline.network_training import Fitter, Work, config_to_train_by, trained

SECONDS_PER_SHAPE = {"gnn_fine": 0.004, "gnn_coarse": 0.004, "axis": 0.02, "ranking": 0.02, "gnn_contact": 0.004}
"""Of an epoch on one CPU core with the configuration `small`, until the journal knows better."""
SECTIONS = ("gnn", "axis", "ranking")
"""Of the configuration, that networks of whole shapes are trained by."""
TRAINED_ON = (Split.TRAIN, Split.VALIDATION)


@dataclass(frozen=True)
class ShapeFitting:
    """One network to be trained on some shapes, and chosen by others."""

    workspace: Workspace
    model: str
    category: str | None
    training: tuple[IndexEntry, ...]
    validation: tuple[IndexEntry, ...]
    section: Any
    inputs: dict[str, Any]
    seed: int
    device: str
    start: Path | None = None

    @property
    def name(self) -> str:
        return f"{self.model} ({self.category})" if self.category else self.model

    @property
    def stage(self) -> str:
        return f"train-{self.model}-{self.category}" if self.category else f"train-{self.model}"

    @property
    def folder(self) -> Path:
        return ModelFolder(self.workspace.motion.models).folder(self.model, self.category)

    @property
    def work(self) -> Work:
        schedule = (self.section if self.start is None else self.section.continued).training
        each = seconds_per_unit(self.workspace, self.stage, SECONDS_PER_SHAPE[self.model])
        return Work(schedule, len(self.training), each)

    @property
    def together(self) -> str:
        return "motion"

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        dataset = open_dataset(self.workspace, self.category)
        trainer = TRAINERS[self.model][1] if self.start is None else CONTINUED[self.model][1](self.start)
        return trainer(
            dataset.load(self.training),
            dataset.load(self.validation),
            self.section,
            folder,
            seed=self.seed,
            device=self.device,
            fingerprint=digest(self.inputs),
            on_progress=on_progress,
        )


@dataclass(frozen=True)
class Part:
    """The labelled shapes of a category that has networks of its own, or of all that share one."""

    category: str | None
    training: tuple[IndexEntry, ...]
    validation: tuple[IndexEntry, ...]

    @property
    def is_enough(self) -> bool:
        return bool(self.training and self.validation)

    def __str__(self) -> str:
        own = f" of {self.category}" if self.category else ""
        return f"{len(self.training)} labelled shapes{own} to train on and {len(self.validation)} to choose by"


@dataclass(frozen=True)
class Train:
    """Train the networks of `group` (`models.GROUPS`), for all categories or for one, which then has its own.

    Those that can (`models.CONTINUED`) go on from the trained ones of the workspace `start` where it is given.
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
        dataset, config = open_dataset(self.workspace, self.category), config_to_train_by(self.config, SECTIONS)
        fittings = list(self._fittings(dataset, config))
        pending = self._fitter.pending(fittings)
        steps = tuple(
            f"train {each.name} on {counted(len(each.training), 'shape')} for {counted(each.work.schedule.epochs, 'epoch')}, "
            f"choose by {len(each.validation)}"
            for each in fittings
            if each in pending
        )
        left_out = tuple(self._left_out(dataset, config)) if pending else ()
        return Plan(steps + left_out, self._fitter.seconds([each.work for each in pending]))

    def run(self, observer: Observer) -> Outcome:
        config = config_to_train_by(self.config, SECTIONS)
        dataset = open_dataset(self.workspace, self.category)
        with self.workspace.locked():
            remove_leftovers(self.workspace.models)
            remove_leftovers(self.workspace.training)
            fittings = list(self._fittings(dataset, config))  # whatever cannot be trained is said before anything is
            for text in self._left_out(dataset, config):
                observer.note(text)
            self._fitter.run(fittings, observer)
            for text in self._own(fittings):
                observer.note(text)
            write_text_atomically(self.workspace.models / CONFIG, json.dumps(to_table(config), indent=1) + "\n")
        return trained(self.workspace, fittings)

    @property
    def _fitter(self) -> Fitter:
        return Fitter(self.workspace, self.device, self.workers)

    def _fittings(self, dataset: Dataset, config: Config) -> Iterator[ShapeFitting]:
        if self.start is not None and not CONTINUED.keys() & set(GROUPS[self.group]):
            is_method = self.group in METHOD_MODELS
            others = (name for name, models in GROUPS.items() if CONTINUED.keys() & set(models))
            able = " or ".join(name for name in others if (name in METHOD_MODELS) is is_method)
            raise InputError("--from", f"{self.group} cannot start from trained weights; use it with {able}")
        for model in GROUPS[self.group]:
            section = getattr(config, TRAINERS[model][0])
            start = self._start_of(model, section)
            parts = _parts(dataset, section)
            if not any(part.is_enough for part in parts):
                raise InputError(self.workspace.prepared, "; ".join(map(str, parts)) + ": both are needed")
            for part in filter(lambda part: part.is_enough, parts):
                training, validation = part.training, part.validation
                data = {"training": dataset.fingerprint(training), "validation": dataset.fingerprint(validation)}
                inputs = {"model": model, "config": to_table(section), "seed": self.seed, "data": data}
                if start is not None:
                    inputs["start"] = start.sha256
                yield ShapeFitting(
                    self.workspace,
                    model,
                    part.category,
                    training,
                    validation,
                    section,
                    inputs,
                    self.seed,
                    self.device,
                    None if start is None else start.path,
                )

    def _left_out(self, dataset: Dataset, config: Config) -> Iterator[str]:
        """Which categories get no networks of their own, and why."""
        for model in GROUPS[self.group]:
            for part in _parts(dataset, getattr(config, TRAINERS[model][0])):
                if not part.is_enough:
                    yield f"no {model} ({part.category}): {part}, both are needed"

    def _own(self, fittings: Sequence[ShapeFitting]) -> Iterator[str]:
        """Which categories have networks of their own from another training, and so none of those that all share."""
        for shared in (fitting for fitting in fittings if fitting.category is None):
            own = sorted(path.parent.name for path in shared.folder.glob(f"*/{WEIGHTS}"))
            if own:
                yield f"{shared.model}: {', '.join(own)} go by networks of their own, in {shared.folder}"

    def _start_of(self, model: str, section: Any) -> Weights | None:
        """The weights that a model is to go on from."""
        if self.start is None or model not in CONTINUED:
            return None
        return weights_to_start_from(self.start, self.workspace, model, section)


def weights_to_start_from(start: Workspace, workspace: Workspace, model: str, section: Any) -> Weights:
    """Those of a model, one of `CONTINUED`, to go on from in `workspace` with a section of the configuration.

    Raises InputError if they were never trained, cannot be read, have other sizes, or are those that would be replaced.
    """
    if start.root.resolve() == workspace.root.resolve():
        raise InputError("--from", f"{start.root} is the workspace itself: expected another one, whose networks stay")
    weights = ModelFolder(start.motion.models).folder(model) / WEIGHTS
    if not weights.exists():
        problem = "expected the weights to go on from: run kinmo train motion in that workspace first"
        raise InputError(weights, problem, "--from")
    kind, _, sizes = CONTINUED[model]
    found = load_weights(weights, kind)
    for size in sizes:
        known, wanted = found.config.get(size), getattr(section, size)
        if known != wanted:
            problem = f"trained with {model}.{size} = {known}, expected {wanted}, as the configuration has it"
            raise InputError(weights, problem, "--from")
    return found


def _parts(dataset: Dataset, section: Any) -> list[Part]:
    """A part for each category, where each has networks of its own, or one for all that there are."""
    labelled = dataset.labelled
    if getattr(section, "per_category", False):
        return [
            Part(category, *(tuple(e for e in labelled[split] if e.category == category) for split in TRAINED_ON))
            for category in dataset.categories()
        ]
    return [Part(dataset.category, *_with_some_to_choose_by(*(tuple(labelled[split]) for split in TRAINED_ON)))]


def _with_some_to_choose_by(
    training: tuple[IndexEntry, ...], validation: tuple[IndexEntry, ...]
) -> tuple[tuple[IndexEntry, ...], tuple[IndexEntry, ...]]:
    """The same; of few shapes, none of which is a validation shape, some to train on are kept for that."""
    if validation or len(training) < 2:
        return training, validation
    kept = kept_to_choose_by({entry.id for entry in training})
    return tuple(e for e in training if e.id not in kept), tuple(e for e in training if e.id in kept)
