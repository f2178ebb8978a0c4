"""The stage `train motion`: it trains the networks that predict joints of shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from kinmo.config import Config, RankingConfig, load_config
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit
from kinmo.dataset.shape_dataset import ShapeDataset, fingerprint, open_dataset
from kinmo.dataset.splits import Split, validation_from_training
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry, read_prepared
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import write_json_atomically
from kinmo.learning.model_folder import CONFIG, WEIGHTS, ModelFolder
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.learning.weights import Weights, load_weights
from kinmo.methods import METHOD_MODELS
from kinmo.methods.kinmo.limits.travel_examples import read_examples
from kinmo.pipeline.motion_models import CONTINUED, GROUPS, TRAINERS, Trainer
from kinmo.pipeline.network_training import NetworkTrainer, TrainingTask, Workload, fit_on_files
from kinmo.pipeline.training_forms import TrainingForms

SECONDS_PER_SHAPE = {
    "gnn_fine": 0.004,
    "gnn_coarse": 0.004,
    "axis": 0.02,
    "grouping": 0.06,
    "ranking": 0.1,
    "limits": 0.001,
    "gnn_contact": 0.004,
}
"""First estimates for one epoch on one CPU core with the configuration `small`."""


@dataclass(frozen=True)
class TrainMotion:
    """Train the motion networks of a group, a key of `motion_models.GROUPS`."""

    group: str
    workspace: Workspace
    config: str
    category: str | None = None  # train networks for it alone, which then predict it; None for all categories
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None  # continue from its networks, where a model can (`motion_models.CONTINUED`)

    def plan(self) -> Plan:
        """List the networks that are not trained yet."""
        dataset, config = open_dataset(self.workspace, self.category), load_config(self.config)
        return self._trainer.plan(list(self._tasks(dataset, config)))

    def run(self, observer: Observer) -> Outcome:
        """Train the networks that are not trained yet."""
        config = load_config(self.config)
        dataset = open_dataset(self.workspace, self.category)
        with self.workspace.locked():
            outcome = self._trainer.run(list(self._tasks(dataset, config)), observer)
            for model in GROUPS[self.group] if dataset.category is None else ():
                folder = ModelFolder(self.workspace.models).folder(model)
                if own := sorted(path.parent.name for path in folder.glob(f"*/{WEIGHTS}")):
                    observer.note(f"{model}: {', '.join(own)} have networks of their own in {folder}")
            write_json_atomically(self.workspace.models / CONFIG, to_table(config))
        return outcome

    @property
    def _trainer(self) -> NetworkTrainer:
        return NetworkTrainer(self.workspace, self.device, self.workers)

    def _tasks(self, dataset: ShapeDataset, config: Config) -> Iterator[TrainingTask]:
        able = [name for name, models in GROUPS.items() if CONTINUED.keys() & set(models)]
        if self.start is not None and self.group not in able:
            others = " or ".join(name for name in able if (name in METHOD_MODELS) is (self.group in METHOD_MODELS))
            raise InputError("--from", f"{self.group} cannot start from trained weights; use it with {others}")
        training, validation = _training_and_validation(dataset)
        if not training or not validation:
            of = f" of {dataset.category}" if dataset.category else ""
            found = f"found {len(training)} labelled shapes{of} for training and {len(validation)} for validation"
            raise InputError(self.workspace.prepared, f"{found}, expected both: prepare more shapes")
        data = {"training": fingerprint(training), "validation": fingerprint(validation)}
        forms, trainer = TrainingForms(self.workspace, self.workers), self._trainer
        grouping: TrainingTask | None = None
        for model in GROUPS[self.group]:
            section = getattr(config, TRAINERS[model][0])
            inputs = {"model": model, "config": to_table(section), "seed": self.seed, "data": data}
            train, schedule = TRAINERS[model][1], section.training
            if self.start is not None and model in CONTINUED:
                start = weights_to_start_from(self.start, self.workspace, model, section)
                inputs["start"] = start.sha256
                train = partial(train, initial=start.path)
                schedule = section.continued.training if model == "ranking" else section.continued
            if model == "ranking" and grouping is not None:
                inputs["grouping"] = digest(grouping.inputs)
            stage = f"train-{model}-{dataset.category}" if dataset.category else f"train-{model}"
            each = seconds_per_unit(self.workspace, stage, SECONDS_PER_SHAPE[model])
            options = {"seed": self.seed, "device": self.device, "fingerprint": digest(inputs)}
            paths = [[self.workspace.prepared / entry.file for entry in entries] for entries in (training, validation)]
            task = TrainingTask(
                f"{model} ({dataset.category})" if dataset.category else model,
                stage,
                ModelFolder(self.workspace.models).folder(model, dataset.category),
                "motion",
                inputs,
                Workload(schedule, len(training), each),
                (counted(len(training), "shape"), str(len(validation))),
                partial(fit_on_files, train, read_prepared, paths, section, options),
            )
            if model in ("grouping", "limits"):
                read, files = (read_prepared, forms.files) if model == "grouping" else (read_examples, forms.files_of_limits)
                fit = partial(_fit_on_forms, train, read, files, (training, validation), section, options)
                task = replace(task, fit=fit, before=partial(forms.prepare, (*training, *validation)))
                grouping = task if model == "grouping" else grouping
            elif model == "ranking":
                assert grouping is not None, "the grouping networks are trained first"
                needs = _Proposals(forms, trainer, grouping, training, validation)
                fit = partial(_fit_on_proposals, needs, train, section, options)
                task = replace(task, fit=fit, wave=1, before=partial(needs.prepare, section))
            yield task


@dataclass(frozen=True)
class _Proposals:
    """Input of the ranking networks: forms of shapes, with proposals of grouping networks that are trained first."""

    forms: TrainingForms
    trainer: NetworkTrainer
    grouping: TrainingTask
    training: tuple[IndexEntry, ...]
    validation: tuple[IndexEntry, ...]

    @property
    def weights(self) -> Path:
        """Weights of the grouping networks."""
        return self.trainer.weights_of(self.grouping)

    def prepare(self, config: RankingConfig, observer: Observer) -> None:
        """Add the proposals to the forms."""
        entries = (*self.training, *self.validation)
        self.forms.add_proposals(entries, self.weights, config, digest(self.grouping.inputs), observer)


def _fit_on_forms(
    train: Trainer,
    read: Callable[[Path], Any],
    files: Callable[[Sequence[IndexEntry]], list[Path]],
    splits: tuple[tuple[IndexEntry, ...], tuple[IndexEntry, ...]],
    section: Any,
    options: Mapping[str, Any],
    folder: Path,
    on_progress: Callable[[Progress], None],
) -> FitResult:
    """Train a network on the forms of training and validation shapes."""
    return fit_on_files(train, read, [files(entries) for entries in splits], section, options, folder, on_progress)


def _fit_on_proposals(
    data: _Proposals,
    train: Trainer,
    section: Any,
    options: Mapping[str, Any],
    folder: Path,
    on_progress: Callable[[Progress], None],
) -> FitResult:
    """Train the ranking networks on proposals."""
    paths = [data.forms.files_with_proposals(entries) for entries in (data.training, data.validation)]
    options = {**options, "grouping": data.weights}
    return fit_on_files(train, read_prepared, paths, section, options, folder, on_progress)


def weights_to_start_from(start: Workspace, workspace: Workspace, model: str, section: Any) -> Weights:
    """Weights of a model, a key of `CONTINUED`, from which a training in another workspace can continue.

    Raises InputError if the weights are missing, unreadable, of other sizes than in this `section` of the configuration, or in
    the workspace of the training itself.
    """
    if start.path.resolve() == workspace.path.resolve():
        raise InputError("--from", f"{start.path} is the workspace itself: expected another one, whose networks stay")
    weights = ModelFolder(start.models).folder(model) / WEIGHTS
    if not weights.exists():
        problem = "expected the weights to continue from: run kinmo train motion in that workspace first"
        raise InputError(weights, problem, "--from")
    found = load_weights(weights, CONTINUED[model].kind)
    for size in CONTINUED[model].sizes:
        known, wanted = found.config.get(size), getattr(section, size)
        if known != wanted:
            problem = f"trained with {model}.{size} = {known}, expected {wanted} as in the configuration"
            raise InputError(weights, problem, "--from")
    return found


def _training_and_validation(dataset: ShapeDataset) -> tuple[tuple[IndexEntry, ...], tuple[IndexEntry, ...]]:
    """Training and validation shapes; without any of the latter some training shapes become validation shapes."""
    training, validation = dataset.labelled[Split.TRAIN], dataset.labelled[Split.VALIDATION]
    if not validation and len(training) > 1:
        moved = validation_from_training({entry.id for entry in training})
        validation = tuple(entry for entry in training if entry.id in moved)
        training = tuple(entry for entry in training if entry.id not in moved)
    return training, validation
