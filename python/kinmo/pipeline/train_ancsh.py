"""Training the networks that see scans."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from kinmo.config import AncshConfig, Config, TrainingConfig, load_config
from kinmo.errors import InputError
from kinmo.learning.ancsh.train import Network, train_ancsh
from kinmo.learning.training import FitResult, Progress
from kinmo.pipeline.fitting import Fitter, result_of
from kinmo.pipeline.journal import seconds_per_unit
from kinmo.pipeline.scan_dataset import ScanDataset, open_scan_dataset, scanned_categories
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.scans.scan_file import ScanFile, open_scans
from kinmo.typed_tables import to_table
from kinmo.workspace import Workspace, remove_leftovers

Setting = Literal["supervised", "semi-weakly"]
"""Trained on the labelled shapes alone, or on those with pseudo labels too (paper, section 4.2)."""
NETWORKS: tuple[Network, ...] = ("ancsh", "npcs")
SECONDS_PER_FRAME = 0.014
"""On one CPU core with the configuration `small`, until the journal knows better."""


@dataclass(frozen=True)
class ScanFitting:
    """One network to be trained on some scans, and chosen by others."""

    workspace: Workspace
    category: str
    setting: Setting
    network: Network
    training: tuple[Path, ...]
    validation: tuple[Path, ...]
    section: AncshConfig
    inputs: dict[str, Any]
    seed: int
    device: str

    @property
    def name(self) -> str:
        return f"{self.network} ({self.category}, {self.setting})"

    @property
    def stage(self) -> str:
        return f"train-{self.network}-{self.category}-{self.setting}"

    @property
    def folder(self) -> Path:
        return ancsh_folder(self.workspace, self.category, self.setting, self.network)

    @property
    def schedule(self) -> TrainingConfig:
        return self.section.training

    @property
    def units(self) -> int:
        return self.section.batches_per_epoch * self.section.batch_frames

    @property
    def seconds(self) -> float:
        return self.units * self.schedule.epochs * seconds_per_unit(self.workspace, self.stage, SECONDS_PER_FRAME)

    def fit(self, on_progress: Callable[[Progress], None]) -> FitResult:
        return train_ancsh(
            [open_scans(path) for path in self.training],
            [open_scans(path) for path in self.validation],
            self.section,
            self.folder,
            which=self.network,
            seed=self.seed,
            device=self.device,
            fingerprint=str(self.inputs["data"]),
            on_progress=on_progress,
        )


@dataclass(frozen=True)
class TrainAncsh:
    """Train both networks of a category, or of all that there are scans of, in a setting."""

    workspace: Workspace
    config: str
    category: str | None = None
    setting: Setting = "semi-weakly"
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        fittings = list(self._fittings(self._config()))
        pending = self._fitter.pending(fittings)
        steps = tuple(
            f"train {each.name} on scans of {len(each.training)} objects for {each.schedule.epochs} epochs, "
            f"choose by {len(each.validation)}"
            for each in fittings
            if each in pending
        )
        return Plan(steps, self._fitter.seconds(pending))

    def run(self, observer: Observer) -> Outcome:
        config = self._config()
        with self.workspace.locked():
            remove_leftovers(self.workspace.models)
            fittings = list(self._fittings(config))
            self._fitter.run(fittings, observer)
        results = {each.name: result_of(each.folder) for each in fittings}
        lines = [
            f"{name}: {found['epochs']} epochs, kept {found['kept']}, error {found['error']:.4f}"
            for name, found in results.items()
        ]
        return Outcome(self.workspace.models, results, "\n".join(lines))

    @property
    def _fitter(self) -> Fitter:
        return Fitter(self.workspace, self.device, self.workers)

    def _config(self) -> Config:
        config = load_config(self.config)
        if config.ancsh.training.devices > 1:
            raise InputError(self.config, "kinmo train uses one device, expected 1", "ancsh.training.devices")
        return config

    def _fittings(self, config: Config) -> Iterator[ScanFitting]:
        categories = (self.category,) if self.category else scanned_categories(self.workspace)
        if not categories:
            raise InputError(self.workspace.scans, "no scans: run kinmo render first")
        for category in categories:
            yield from self._of(open_scan_dataset(self.workspace, category), config.ancsh)

    def _of(self, dataset: ScanDataset, section: AncshConfig) -> Iterator[ScanFitting]:
        training = dataset.files["train"] + (dataset.files["pseudo"] if self.setting == "semi-weakly" else ())
        validation = dataset.files["validation"]
        if not validation:
            raise InputError(self.workspace.scans / dataset.category, f"no object with {dataset.structure} to choose by")
        data = {"training": dataset.fingerprint(training), "validation": dataset.fingerprint(validation)}
        for network in NETWORKS:
            inputs = {"network": network, "config": to_table(section), "seed": self.seed, "data": data}
            yield ScanFitting(
                self.workspace,
                dataset.category,
                self.setting,
                network,
                _paths(training),
                _paths(validation),
                section,
                inputs,
                self.seed,
                self.device,
            )


def ancsh_folder(workspace: Workspace, category: str, setting: Setting, network: Network) -> Path:
    """Where a network lies."""
    return workspace.models / "ancsh" / category / setting / network


def _paths(files: tuple[ScanFile, ...]) -> tuple[Path, ...]:
    return tuple(file.path for file in files)
