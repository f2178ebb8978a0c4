"""Networks for scans: where each pair lies, and what it was trained on. Nothing here needs torch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from kinmo.config import AncshNetworkName
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import WEIGHTS
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.scans.training_settings import SETTINGS, Setting

NETWORKS: tuple[AncshNetworkName, ...] = ("ancsh", "npcs")
MODEL = "ancsh"  # folder of all networks for scans, below the workspace's `models`


@dataclass(frozen=True, order=True)
class ScanRun:
    """One pair of networks for scans: the category, the labels and the seed that they were trained with."""

    category: str
    setting: Setting
    seed: int
    method: str = DEFAULT_METHOD  # whose pseudo labels they learn from, in the setting `semi-weakly`

    def __str__(self) -> str:
        labels = "" if self.setting != "semi-weakly" or self.method == DEFAULT_METHOD else f", labels by {self.method}"
        return f"{self.category}, {self.setting}, seed {self.seed}{labels}"

    @property
    def labels(self) -> str:
        """Name of the labels in paths."""
        return f"{self.setting}-{self.method}" if self.setting == "semi-weakly" else self.setting

    @property
    def key(self) -> str:
        """Name of the run in records."""
        return f"{self.category}-{self.labels}-{self.seed}"

    def folder(self, workspace: Workspace, network: AncshNetworkName) -> Path:
        """Folder of one of the two networks."""
        return workspace.models / MODEL / self.category / self.labels / str(self.seed) / network

    def stage(self, network: AncshNetworkName) -> str:
        """Name of the training's record for one of the two networks."""
        return f"train-{network}-{self.key}"

    def weights(self, workspace: Workspace) -> tuple[Path, Path] | None:
        """Weights of both networks; None unless both are trained, on the same scans with the same settings."""
        ancsh, npcs = (self.folder(workspace, network) / WEIGHTS for network in NETWORKS)
        inputs = [workspace.inputs_of(self.stage(network)) for network in NETWORKS]
        trained = [found | {"network": None} for found in inputs if found is not None]
        return (ancsh, npcs) if len(trained) == len(NETWORKS) and trained[0] == trained[1] else None

    def was_trained_on(self, workspace: Workspace, data: Mapping[str, str]) -> bool:
        """True if both networks were trained on these scans (`scan_dataset.training_data`)."""
        inputs = [workspace.inputs_of(self.stage(network)) for network in NETWORKS]
        return all(found is not None and found.get("data") == data for found in inputs)


def trained_runs(workspace: Workspace) -> list[ScanRun]:
    """All runs whose networks are trained."""
    return [run for run in _runs_in(workspace.models) if run.weights(workspace)]


def unfinished_runs(workspace: Workspace) -> list[ScanRun]:
    """All runs whose training was begun, perhaps anew, and is not finished."""
    return _runs_in(workspace.training)


def _runs_in(models: Path) -> list[ScanRun]:
    found = []
    for folder in sorted((models / MODEL).glob("*/*/*")):
        category, labels, seed = folder.parts[-3:]
        for setting in SETTINGS:
            method = labels.removeprefix(f"{setting}-") if setting == "semi-weakly" else DEFAULT_METHOD
            run = ScanRun(category, setting, int(seed) if seed.isdecimal() else -1, method)
            if run.seed >= 0 and run.labels == labels:
                found.append(run)
    return found
