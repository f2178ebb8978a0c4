"""The stage `train ancsh`: it trains the networks that find parts and joints in scans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

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
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.network_training import NetworkTrainer, TrainingTask, Workload, fit_on_files
from kinmo.pipeline.scans.scan_dataset import COMPLETE, ScanDataset, open_scan_dataset, scanned_categories, training_data
from kinmo.pipeline.scans.scan_networks import NETWORKS, ScanRun
from kinmo.pipeline.scans.training_settings import EXTRA_LABELS, Setting
from kinmo.scans.ancsh.ancsh_training import train_ancsh
from kinmo.scans.files.scan_file import ScanFile, count_objects, open_scans

SECONDS_PER_FRAME = 0.010  # first estimate, for one CPU core and the configuration `small`


def self_labels_folder(workspace: Workspace, category: str, seed: int) -> Path:
    """Folder of scans that supervised networks labelled (`experiments.self_training`)."""
    return workspace.scans / category / f"self-labels-{seed}"


def self_labels(workspace: Workspace, category: str, seed: int) -> tuple[ScanFile, ...]:
    """Scans that supervised networks labelled; none until all are labelled."""
    folder = self_labels_folder(workspace, category, seed)
    return tuple(map(open_scans, sorted(folder.glob("*.safetensors")))) if COMPLETE in Cache(folder) else ()


@dataclass(frozen=True)
class TrainScans:
    """Train both networks of a category, or of every scanned category."""

    workspace: Workspace
    config: str
    category: str | None = None
    setting: Setting = "semi-weakly"  # labels besides those of the labelled shapes
    method: str = DEFAULT_METHOD  # whose pseudo labels are used, in the setting `semi-weakly`
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        """List the networks that are not trained yet."""
        return self._trainer.plan(list(self._tasks()))

    def guess(self) -> Plan:
        """Estimate for training all networks, whatever scans there will be."""
        section = load_config(self.config).ancsh
        runs = [ScanRun(category, self.setting, self.seed, self.method) for category in self._categories()]
        steps = tuple(f"train {network} ({run})" for run in runs for network in NETWORKS)
        works = [_work(self.workspace, section, network) for network in NETWORKS] * len(runs)
        return Plan(steps, self._trainer.seconds(works))

    def run(self, observer: Observer) -> Outcome:
        """Train the networks that are not trained yet."""
        with self.workspace.locked():
            return self._trainer.run(list(self._tasks()), observer)

    @property
    def _trainer(self) -> NetworkTrainer:
        return NetworkTrainer(self.workspace, self.device, self.workers)

    def _categories(self) -> tuple[str, ...]:
        known = scanned_categories(self.workspace)
        if self.category:  # in the spelling of the scans, if there are any
            return tuple(name for name in known if same_category(name, self.category)) or (self.category,)
        if not known:
            raise InputError(self.workspace.scans, "no scans: run kinmo render first")
        return known

    def _tasks(self) -> Iterator[TrainingTask]:
        section = load_config(self.config).ancsh
        for category in self._categories():
            yield from self._tasks_of(open_scan_dataset(self.workspace, category, self.method), section)

    def _tasks_of(self, dataset: ScanDataset, section: AncshConfig) -> Iterator[TrainingTask]:
        run = ScanRun(dataset.category, self.setting, self.seed, self.method)
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
        paths = [[file.path for file in scans] for scans in (training, validation)]
        for network in NETWORKS:
            inputs = {"network": network, "config": to_table(section), "seed": self.seed, "data": data}
            trainer = partial(train_ancsh, which=network, labelled=count_objects(dataset.files["train"]))
            options = {"seed": self.seed, "device": self.device, "fingerprint": digest(inputs)}
            yield TrainingTask(
                f"{network} ({run})",
                run.stage(network),
                run.folder(self.workspace, network),
                run.key,
                inputs,
                _work(self.workspace, section, network, run.stage(network)),
                (f"scans of {counted(count_objects(training), 'object')}", str(count_objects(validation))),
                partial(fit_on_files, trainer, open_scans, paths, section, options),
            )


def _work(workspace: Workspace, section: AncshConfig, network: AncshNetworkName, stage: str = "") -> Workload:
    """Amount of training of a network, which does not depend on the number of scans."""
    each = seconds_per_unit(workspace, stage, SECONDS_PER_FRAME, prefix=f"train-{network}-")
    return Workload(section.training, section.batches_per_epoch * section.batch_frames, each)
