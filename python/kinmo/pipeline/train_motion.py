"""The stage `train motion`: it trains the networks that predict joints of shapes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.config import Config, load_config
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit
from kinmo.dataset.shape_dataset import ShapeDataset, fingerprint, open_dataset
from kinmo.dataset.splits import Split, validation_from_training
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import remove_leftovers, write_text_atomically
from kinmo.learning.model_folder import CONFIG, WEIGHTS, ModelFolder
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.learning.weights import Weights, load_weights
from kinmo.methods import METHOD_MODELS
from kinmo.pipeline.motion_models import CONTINUED, GROUPS, TRAINERS
from kinmo.pipeline.network_training import NetworkTrainer, Workload, training_outcome

SECONDS_PER_SHAPE = {"gnn_fine": 0.004, "gnn_coarse": 0.004, "axis": 0.02, "ranking": 0.02, "gnn_contact": 0.004}
"""First estimates for one epoch on one CPU core with the configuration `small`."""
FITTED_SPLITS = (Split.TRAIN, Split.VALIDATION)


@dataclass(frozen=True)
class MotionTrainingTask:
    """One network to train on some shapes and to validate on others (see `TrainingTask`).

    Attributes:
        workspace: The workspace with shapes and networks.
        model: Name of the model, a key of `TRAINERS`.
        category: The category of all shapes, for a network of its own; None for all categories.
        training: Shapes to train on.
        validation: Shapes to choose the best epoch by.
        section: Section of the configuration.
        inputs: Everything that the network depends on.
        seed: Seed of everything random.
        device: Where the network is trained.
        start: Weights to continue from; None to start anew.
    """

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
    group: str = "motion"

    @property
    def name(self) -> str:
        """Name for people."""
        return f"{self.model} ({self.category})" if self.category else self.model

    @property
    def stage(self) -> str:
        """Name of the training's record."""
        return f"train-{self.model}-{self.category}" if self.category else f"train-{self.model}"

    @property
    def folder(self) -> Path:
        """Folder of the trained network."""
        return ModelFolder(self.workspace.models).folder(self.model, self.category)

    @property
    def work(self) -> Workload:
        """Amount of training."""
        schedule = (self.section if self.start is None else self.section.continued).training
        each = seconds_per_unit(self.workspace, self.stage, SECONDS_PER_SHAPE[self.model])
        return Workload(schedule, len(self.training), each)

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        """Train the network in a folder."""
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
class TrainMotion:
    """Train the motion networks of a group.

    Attributes:
        group: Networks to train, a key of `motion_models.GROUPS`.
        workspace: The workspace.
        config: Name or path of the configuration.
        category: Train networks for this category alone, which is then predicted by them; None for all categories.
        seed: Seed of everything random.
        device: Where networks are trained.
        workers: Number of processes.
        start: Continue from the networks of this workspace, where a model can (`motion_models.CONTINUED`).
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
        """List the networks that are not trained yet."""
        dataset, config = open_dataset(self.workspace, self.category), load_config(self.config)
        tasks = list(self._tasks(dataset, config))
        pending = self._trainer.pending(tasks)
        steps = tuple(
            f"train {task.name} on {counted(len(task.training), 'shape')} for {counted(task.work.schedule.epochs, 'epoch')}, "
            f"validate on {len(task.validation)}"
            for task in tasks
            if task in pending
        )
        return Plan(steps, self._trainer.seconds([task.work for task in pending]))

    def run(self, observer: Observer) -> Outcome:
        """Train the networks that are not trained yet."""
        config = load_config(self.config)
        dataset = open_dataset(self.workspace, self.category)
        with self.workspace.locked():
            remove_leftovers(self.workspace.models)
            remove_leftovers(self.workspace.training)
            tasks = list(self._tasks(dataset, config))  # raises before anything is trained
            self._trainer.run(tasks, observer)
            for text in self._networks_of_categories(tasks):
                observer.note(text)
            write_text_atomically(self.workspace.models / CONFIG, json.dumps(to_table(config), indent=1) + "\n")
        return training_outcome(self.workspace, tasks)

    @property
    def _trainer(self) -> NetworkTrainer:
        return NetworkTrainer(self.workspace, self.device, self.workers)

    def _tasks(self, dataset: ShapeDataset, config: Config) -> Iterator[MotionTrainingTask]:
        if self.start is not None and not CONTINUED.keys() & set(GROUPS[self.group]):
            is_method = self.group in METHOD_MODELS
            others = (name for name, models in GROUPS.items() if CONTINUED.keys() & set(models))
            able = " or ".join(name for name in others if (name in METHOD_MODELS) is is_method)
            raise InputError("--from", f"{self.group} cannot start from trained weights; use it with {able}")
        training, validation = _with_validation(*(tuple(dataset.labelled[split]) for split in FITTED_SPLITS))
        if not training or not validation:
            of = f" of {dataset.category}" if dataset.category else ""
            problem = (
                f"found {len(training)} labelled shapes{of} for training and {len(validation)} for validation, expected both: "
                "prepare more shapes"
            )
            raise InputError(self.workspace.prepared, problem)
        data = {"training": fingerprint(training), "validation": fingerprint(validation)}
        for model in GROUPS[self.group]:
            section = getattr(config, TRAINERS[model][0])
            inputs = {"model": model, "config": to_table(section), "seed": self.seed, "data": data}
            start = None
            if self.start is not None and model in CONTINUED:
                start = weights_to_start_from(self.start, self.workspace, model, section)
                inputs["start"] = start.sha256
            yield MotionTrainingTask(
                self.workspace,
                model,
                dataset.category,
                training,
                validation,
                section,
                inputs,
                self.seed,
                self.device,
                None if start is None else start.path,
            )

    def _networks_of_categories(self, tasks: Sequence[MotionTrainingTask]) -> Iterator[str]:
        """Categories that are predicted by networks of their own, from another training."""
        for shared in (task for task in tasks if task.category is None):
            own = sorted(path.parent.name for path in shared.folder.glob(f"*/{WEIGHTS}"))
            if own:
                yield f"{shared.model}: {', '.join(own)} have networks of their own in {shared.folder}"


def weights_to_start_from(start: Workspace, workspace: Workspace, model: str, section: Any) -> Weights:
    """Weights of a model from which a training in another workspace can continue.

    Args:
        start: The workspace with the weights.
        workspace: The workspace of the training.
        model: A key of `CONTINUED`.
        section: Section of the configuration.

    Raises:
        InputError: The weights are missing, unreadable, of other sizes, or in the workspace of the training itself.
    """
    if start.path.resolve() == workspace.path.resolve():
        raise InputError("--from", f"{start.path} is the workspace itself: expected another one, whose networks stay")
    weights = ModelFolder(start.models).folder(model) / WEIGHTS
    if not weights.exists():
        problem = "expected the weights to continue from: run kinmo train motion in that workspace first"
        raise InputError(weights, problem, "--from")
    kind, _, sizes = CONTINUED[model]
    found = load_weights(weights, kind)
    for size in sizes:
        known, wanted = found.config.get(size), getattr(section, size)
        if known != wanted:
            problem = f"trained with {model}.{size} = {known}, expected {wanted} as in the configuration"
            raise InputError(weights, problem, "--from")
    return found


def _with_validation(
    training: tuple[IndexEntry, ...], validation: tuple[IndexEntry, ...]
) -> tuple[tuple[IndexEntry, ...], tuple[IndexEntry, ...]]:
    """Training and validation shapes; without any of the latter some training shapes become validation shapes."""
    if validation or len(training) < 2:
        return training, validation
    moved = validation_from_training({entry.id for entry in training})
    return tuple(e for e in training if e.id not in moved), tuple(e for e in training if e.id in moved)
