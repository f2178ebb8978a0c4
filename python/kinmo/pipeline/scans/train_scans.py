"""The stage `train ancsh`: it trains the networks that find parts and joints in scans."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.config import AncshConfig, AncshNetworkName, load_config
from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.core.wording import counted
from kinmo.dataset.cache import Cache
from kinmo.dataset.journal import seconds_per_unit
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import remove_leftovers
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.network_training import NetworkTrainer, Workload, training_outcome
from kinmo.pipeline.scans.scan_dataset import COMPLETE, ScanDataset, open_scan_dataset, scanned_categories, training_data
from kinmo.pipeline.scans.scan_networks import NETWORKS, ScanRun
from kinmo.pipeline.scans.training_settings import EXTRA_LABELS, Setting
from kinmo.scans.ancsh.ancsh_training import train_ancsh
from kinmo.scans.files.scan_file import ScanFile, count_objects, open_scans

SECONDS_PER_FRAME = 0.010
"""First estimate, for one CPU core and the configuration `small`."""


def self_labels_folder(workspace: Workspace, category: str, seed: int) -> Path:
    """Folder of scans that supervised networks labelled (`experiments.self_training`)."""
    return workspace.scans / category / f"self-labels-{seed}"


def self_labels(workspace: Workspace, category: str, seed: int) -> tuple[ScanFile, ...]:
    """Scans that supervised networks labelled; none until all are labelled."""
    folder = self_labels_folder(workspace, category, seed)
    return tuple(map(open_scans, sorted(folder.glob("*.safetensors")))) if COMPLETE in Cache(folder) else ()


@dataclass(frozen=True)
class ScanTrainingTask:
    """One network to train on some scans and to validate on others (see `TrainingTask`).

    Attributes:
        workspace: The workspace.
        run: Category, labels and seed.
        network: `ancsh` (all heads) or `npcs` (parts and part coordinates).
        training: Files of scans; the first `labelled` objects are those with true labels.
        validation: Files of scans.
        objects: Numbers of objects for training and for validation.
        labelled: Number of labelled training objects.
        section: Section of the configuration.
        inputs: Everything that the network depends on.
        device: Where the network is trained.
    """

    workspace: Workspace
    run: ScanRun
    network: AncshNetworkName
    training: tuple[Path, ...]
    validation: tuple[Path, ...]
    objects: tuple[int, int]
    labelled: int
    section: AncshConfig
    inputs: dict[str, Any]
    device: str

    @property
    def name(self) -> str:
        """Name for people."""
        return f"{self.network} ({self.run})"

    @property
    def stage(self) -> str:
        """Name of the training's record."""
        return self.run.stage(self.network)

    @property
    def folder(self) -> Path:
        """Folder of the trained network."""
        return self.run.folder(self.workspace, self.network)

    @property
    def group(self) -> str:
        """Name shared by both networks of a run."""
        return self.run.key

    @property
    def work(self) -> Workload:
        """Amount of training."""
        return _work(self.workspace, self.section, self.network, self.stage)

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        """Train the network in a folder."""
        return train_ancsh(
            [open_scans(path) for path in self.training],
            [open_scans(path) for path in self.validation],
            self.section,
            folder,
            which=self.network,
            labelled=self.labelled,
            seed=self.run.seed,
            device=self.device,
            fingerprint=digest(self.inputs),
            on_progress=on_progress,
        )


@dataclass(frozen=True)
class TrainScans:
    """Train both networks of a category, or of every scanned category.

    Attributes:
        workspace: The workspace.
        config: Name or path of the configuration.
        category: The category; None for all scanned ones.
        setting: Labels besides those of the labelled shapes.
        method: The method whose pseudo labels are used, in the setting `semi-weakly`.
        seed: Seed of everything random.
        device: Where networks are trained.
        workers: Number of processes.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    setting: Setting = "semi-weakly"
    method: str = DEFAULT_METHOD
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        """List the networks that are not trained yet."""
        tasks = list(self._tasks())
        pending = self._trainer.pending(tasks)
        steps = tuple(
            f"train {task.name} on scans of {counted(task.objects[0], 'object')} "
            f"for {counted(task.work.schedule.epochs, 'epoch')}, validate on {task.objects[1]}"
            for task in tasks
            if task in pending
        )
        return Plan(steps, self._trainer.seconds([task.work for task in pending]))

    def guess(self) -> Plan:
        """Estimate for training all networks, whatever scans there will be."""
        section = load_config(self.config).ancsh
        runs = [self._run(category) for category in self._categories()]
        steps = tuple(f"train {network} ({run})" for run in runs for network in NETWORKS)
        works = [_work(self.workspace, section, network) for network in NETWORKS] * len(runs)
        return Plan(steps, self._trainer.seconds(works))

    def run(self, observer: Observer) -> Outcome:
        """Train the networks that are not trained yet."""
        with self.workspace.locked():
            remove_leftovers(self.workspace.models)
            remove_leftovers(self.workspace.training)
            tasks = list(self._tasks())
            self._trainer.run(tasks, observer)
        return training_outcome(self.workspace, tasks)

    @property
    def _trainer(self) -> NetworkTrainer:
        return NetworkTrainer(self.workspace, self.device, self.workers)

    def _run(self, category: str) -> ScanRun:
        return ScanRun(category, self.setting, self.seed, self.method)

    def _categories(self) -> tuple[str, ...]:
        known = scanned_categories(self.workspace)
        if self.category:  # in the spelling of the scans, if there are any
            return tuple(name for name in known if same_category(name, self.category)) or (self.category,)
        if not known:
            raise InputError(self.workspace.scans, "no scans: run kinmo render first")
        return known

    def _tasks(self) -> Iterator[ScanTrainingTask]:
        section = load_config(self.config).ancsh
        for category in self._categories():
            yield from self._tasks_of(open_scan_dataset(self.workspace, category, self.method), section)

    def _tasks_of(self, dataset: ScanDataset, section: AncshConfig) -> Iterator[ScanTrainingTask]:
        run = self._run(dataset.category)
        extra, validation = dataset.extra(self.setting), dataset.files["validation"]
        if self.setting == "self-training":
            extra = self_labels(self.workspace, dataset.category, self.seed)
        training = dataset.files["train"] + extra
        place = self.workspace.scans / dataset.category
        for files, role in ((training, "train"), (validation, "validate on")):
            if not files:
                raise InputError(place, f"expected scans of an object with {dataset.structure.in_words} to {role}")
        needed = EXTRA_LABELS.get(self.setting)
        if needed is not None and not extra:
            problem = f"needs scans of {needed.objects} with {dataset.structure.in_words}; there are none: {needed.remedy}"
            raise InputError(place, problem, self.setting)
        data = training_data(dataset, extra)
        objects, labelled = (count_objects(training), count_objects(validation)), count_objects(dataset.files["train"])
        for network in NETWORKS:
            inputs = {"network": network, "config": to_table(section), "seed": self.seed, "data": data}
            paths = _paths(training), _paths(validation)
            yield ScanTrainingTask(self.workspace, run, network, *paths, objects, labelled, section, inputs, self.device)


def _paths(files: Sequence[ScanFile]) -> tuple[Path, ...]:
    return tuple(file.path for file in files)


def _work(workspace: Workspace, section: AncshConfig, network: AncshNetworkName, stage: str = "") -> Workload:
    """Amount of training of a network, which does not depend on the number of scans."""
    each = seconds_per_unit(workspace, stage, SECONDS_PER_FRAME, prefix=f"train-{network}-")
    return Workload(section.training, section.batches_per_epoch * section.batch_frames, each)
