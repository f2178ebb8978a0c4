"""Training the networks that see scans."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kinmo.config import AncshConfig, AncshNetworkName, Config
from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.self_training.self_training_stage import SelfLabel, self_labels
from kinmo.io.atomic_files import remove_leftovers
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.pipeline.network_training import Fitter, Work, config_to_train_by, trained
from kinmo.pipeline.scans.scan_dataset import ScanDataset, open_scan_dataset, scanned_categories, training_data
from kinmo.pipeline.scans.scan_networks import NETWORKS, Cell
from kinmo.pipeline.scans.training_settings import SUPPLEMENTS, Setting
from kinmo.scans.ancsh.ancsh_training import train_ancsh
from kinmo.scans.scan_file import ScanFile, count_objects, open_scans

SECONDS_PER_FRAME = 0.010
"""On one CPU core with the configuration `small`, until the journal knows better."""


@dataclass(frozen=True)
class ScanFitting:
    """One network to be trained on some scans, and validated on others, of so many `objects` each; of the first so many are
    `labelled`.
    """

    workspace: Workspace
    cell: Cell
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
        return f"{self.network} ({self.cell.title(self.workspace)})"

    @property
    def stage(self) -> str:
        return self.cell.stage(self.network)

    @property
    def folder(self) -> Path:
        return self.cell.folder(self.workspace, self.network)

    @property
    def work(self) -> Work:
        return _work(self.workspace, self.section, self.network, self.stage)

    @property
    def together(self) -> str:
        return self.cell.key

    def fit(self, folder: Path, on_progress: Callable[[Progress], None]) -> FitResult:
        return train_ancsh(
            [open_scans(path) for path in self.training],
            [open_scans(path) for path in self.validation],
            self.section,
            folder,
            which=self.network,
            labelled=self.labelled,
            seed=self.cell.seed,
            device=self.device,
            fingerprint=digest(self.inputs),
            on_progress=on_progress,
        )


@dataclass(frozen=True)
class TrainAncsh:
    """Train both networks of a category, or of all that there are scans of, in a setting.

    In the setting `semi` those of `supervised` come first, which then label the scans of unlabelled objects.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    setting: Setting = "semi-weakly"
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        config = self._config
        steps: list[str] = []
        seconds = 0.0
        for stage in self._before(config):
            plan = stage.plan()
            steps += plan.steps
            seconds += plan.seconds
        if steps:  # what they leave decides what is trained on
            training = self._training(self._categories())
            return Plan((*steps, *training.steps), seconds + training.seconds)
        fittings = list(self._fittings(config))
        pending = self._fitter.pending(fittings)
        steps += [
            f"train {each.name} on scans of {counted(each.objects[0], 'object')} "
            f"for {counted(each.work.schedule.epochs, 'epoch')}, validate on {each.objects[1]}"
            for each in fittings
            if each in pending
        ]
        return Plan(tuple(steps), seconds + self._fitter.seconds([each.work for each in pending]))

    def guess(self) -> Plan:
        """Training them whatever scans there will be; `semi` after those that label, if there are none yet."""
        categories = self._categories()
        training = self._training(categories)
        teachers = [Cell(category, "supervised", self.seed) for category in categories if self.setting == "semi"]
        untaught = sum(cell.weights(self.workspace) is None for cell in teachers)
        return replace(training, seconds=training.seconds * (1.0 + untaught / len(categories)))

    def _training(self, categories: Sequence[str]) -> Plan:
        """Training all networks of some categories."""
        section = self._config.ancsh
        cells = [Cell(category, self.setting, self.seed) for category in categories]
        steps = tuple(f"train {network} ({cell.title(self.workspace)})" for cell in cells for network in NETWORKS)
        works = [_work(self.workspace, section, network) for network in NETWORKS] * len(cells)
        return Plan(steps, self._fitter.seconds(works))

    def run(self, observer: Observer) -> Outcome:
        config = self._config
        before = tuple(self._before(config))
        for stage in before:
            if isinstance(stage, SelfLabel):  # raises where nothing is to be labelled, before teachers are trained for it
                stage.plan()
        for stage in before:
            stage.run(observer)
        with self.workspace.locked():
            remove_leftovers(self.workspace.models)
            remove_leftovers(self.workspace.training)
            fittings = list(self._fittings(config))
            self._fitter.run(fittings, observer)
        return trained(self.workspace, fittings)

    @property
    def _fitter(self) -> Fitter:
        return Fitter(self.workspace, self.device, self.workers)

    @property
    def _config(self) -> Config:
        return config_to_train_by(self.config, ("ancsh",))

    def _categories(self) -> tuple[str, ...]:
        known = scanned_categories(self.workspace)
        if self.category:  # as it is spelled there, if there are scans of it
            return tuple(name for name in known if same_category(name, self.category)) or (self.category,)
        if not known:
            raise InputError(self.workspace.scans, "no scans: run kinmo render first")
        return known

    def _before(self, config: Config) -> Iterator[TrainAncsh | SelfLabel]:
        """What has to be done first."""
        if self.setting == "semi":
            teachers = TrainAncsh(
                self.workspace, self.config, self.category, "supervised", self.seed, self.device, self.workers
            )
            yield teachers
            for category in self._categories():
                yield SelfLabel(self.workspace, category, config.ancsh.confidence, self.seed, self.device, self.workers)

    def _fittings(self, config: Config) -> Iterator[ScanFitting]:
        for category in self._categories():
            yield from self._of(open_scan_dataset(self.workspace, category), config.ancsh)

    def _of(self, dataset: ScanDataset, section: AncshConfig) -> Iterator[ScanFitting]:
        cell = Cell(dataset.category, self.setting, self.seed)
        beside, validation = dataset.beside(self.setting), dataset.files["validation"]
        if self.setting == "semi":
            beside = tuple(self_labels(self.workspace, dataset.category, self.seed))
        training = dataset.files["train"] + beside
        folder = self.workspace.scans / dataset.category
        for files, role in ((training, "train"), (validation, "validate on")):
            if not files:
                raise InputError(folder, f"expected scans of an object with {dataset.structure.in_words} to {role}")
        needed = SUPPLEMENTS.get(self.setting)
        if needed is not None and not beside:
            problem = f"needs scans of {needed.objects} with {dataset.structure.in_words}, and there are none: {needed.remedy}"
            raise InputError(folder, problem, self.setting)
        data = training_data(dataset, beside)
        objects, labelled = (count_objects(training), count_objects(validation)), count_objects(dataset.files["train"])
        for network in NETWORKS:
            inputs = {"network": network, "config": to_table(section), "seed": self.seed, "data": data}
            paths = _paths(training), _paths(validation)
            yield ScanFitting(self.workspace, cell, network, *paths, objects, labelled, section, inputs, self.device)


def _paths(files: tuple[ScanFile, ...]) -> tuple[Path, ...]:
    return tuple(file.path for file in files)


def _work(workspace: Workspace, section: AncshConfig, network: AncshNetworkName, stage: str = "") -> Work:
    """How much there is to train of a network, which does not depend on how many scans there are."""
    each = seconds_per_unit(workspace, stage, SECONDS_PER_FRAME, kind=f"train-{network}-")
    return Work(section.training, section.batches_per_epoch * section.batch_frames, each)
