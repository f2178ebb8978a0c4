"""Where the networks that see scans lie. Nothing here needs torch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from kinmo.config import AncshNetworkName
from kinmo.dataset.workspace import DEFAULT_METHOD, Workspace
from kinmo.learning.model_folder import WEIGHTS
from kinmo.methods import METHOD_MODELS
from kinmo.pipeline.scans.training_settings import Setting

NETWORKS: tuple[AncshNetworkName, ...] = ("ancsh", "npcs")


@dataclass(frozen=True, order=True)
class Cell:
    """What a pair of networks was trained for, on and with."""

    category: str
    setting: Setting
    seed: int

    def __str__(self) -> str:
        return f"{self.category}, {self.setting}, seed {self.seed}"

    def title(self, workspace: Workspace) -> str:
        """What it is, in words, with the method whose pseudo labels the workspace has unless that is the default."""
        return str(self) if workspace.method == DEFAULT_METHOD else f"{self}, labels by {workspace.method}"

    @property
    def key(self) -> str:
        """For names of records."""
        return f"{self.category}-{self.setting}-{self.seed}"

    def folder(self, workspace: Workspace, network: AncshNetworkName) -> Path:
        """That of one of the two networks."""
        return workspace.models / "ancsh" / self.category / self.setting / str(self.seed) / network

    def stage(self, network: AncshNetworkName) -> str:
        """What the record of the training of one of the two is called."""
        return f"train-{network}-{self.key}"

    def weights(self, workspace: Workspace) -> tuple[Path, Path] | None:
        """The weights of both networks, once they are trained, on the same scans in the same way."""
        ancsh, npcs = (self.folder(workspace, network) / WEIGHTS for network in NETWORKS)
        records = [workspace.record(self.stage(network)) for network in NETWORKS]
        trained = [dict(record.inputs) | {"network": None} for record in records if record is not None]
        are_of_one_kind = len(trained) == len(NETWORKS) and trained[0] == trained[1]
        return (ancsh, npcs) if are_of_one_kind and ancsh.exists() and npcs.exists() else None

    def has_seen(self, workspace: Workspace, data: Mapping[str, str]) -> bool:
        """Whether the networks were trained on these scans (`kinmo.pipeline.scans.scan_dataset.training_data`)."""
        records = (workspace.record(self.stage(network)) for network in NETWORKS)
        return all(record is not None and record.inputs.get("data") == data for record in records)


def trained_cells(workspace: Workspace) -> list[Cell]:
    """Those whose networks are there."""
    return [cell for cell in _cells_in(workspace.models) if cell.weights(workspace)]


def unfinished_by_all_methods(workspace: Workspace) -> list[tuple[Workspace, Cell]]:
    """Those whose networks were begun to be trained, perhaps anew, and are not trained to the end, with their workspace."""
    return [(place, cell) for place in map(workspace.by, METHOD_MODELS) for cell in _cells_in(place.training)]


def _cells_in(models: Path) -> list[Cell]:
    folders = (folder.parts[-3:] for folder in sorted((models / "ancsh").glob("*/*/*")))
    return [
        Cell(category, setting, int(seed))  # type: ignore[arg-type]
        for category, setting, seed in folders
        if seed.isdecimal()
    ]


def trained_by_all_methods(workspace: Workspace) -> list[tuple[Workspace, Cell]]:
    """Those whose networks are there, with the workspace in which they are: the given one, or that of another method."""
    return [(place, cell) for place in map(workspace.by, METHOD_MODELS) for cell in trained_cells(place)]


Protocol = Literal["kinmo", "ancsh"]
"""How errors are measured: rightly, or as ANCSH's public code does, faults included."""
PROTOCOLS: tuple[Protocol, ...] = ("kinmo", "ancsh")


def pictures_path(workspace: Workspace, cell: Cell) -> Path:
    """Where pictures of a cell on test scans are written; there are none of rough ones."""
    return _judged(workspace, on_rough=False) / "pictures" / f"{cell.key}.jsonl"


def scores_path(workspace: Workspace, cell: Cell, on_rough: bool, protocol: Protocol = "kinmo") -> Path:
    """Where the errors of a cell on test scans, or on rough ones, are written."""
    return _judged(workspace, on_rough) / protocol / f"{cell.key}.jsonl"


def _judged(workspace: Workspace, on_rough: bool) -> Path:
    return workspace.evaluation / ("rough-scans" if on_rough else "scans")
