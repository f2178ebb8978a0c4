"""What networks that see scans are judged on, and whether they were. Nothing here needs torch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.errors import InputError
from kinmo.pipeline.ancsh_files import Cell, Protocol, scores_path
from kinmo.pipeline.model_files import networks_digest
from kinmo.pipeline.scan_dataset import fingerprint, open_scan_dataset
from kinmo.scans.scan_file import ScanFile
from kinmo.workspace import Workspace


@dataclass(frozen=True)
class JudgedScans:
    """The test scans of a cell's category, or those by the rough sensor."""

    workspace: Workspace
    cell: Cell
    on_rough: bool = False

    @property
    def stage(self) -> str:
        return f"eval-{'rough-' if self.on_rough else ''}scans-{self.cell.key}"

    def files(self) -> tuple[ScanFile, ...]:
        """Raises InputError if no test object has the structure that the networks know."""
        scanned = Workspace(self.workspace.root, is_rough=self.on_rough)
        dataset = open_scan_dataset(scanned, self.cell.category)
        if not dataset.files["test"]:
            folder = scanned.scans / self.cell.category
            raise InputError(folder, f"expected scans of a test object of {dataset.structure}")
        return dataset.files["test"]

    def inputs(self) -> dict[str, Any]:
        """What the judgement depends on."""
        return {"test": fingerprint(self.files()), "weights": networks_digest(self.cell.weights(self.workspace) or ())}

    def scores(self, protocol: Protocol) -> Path:
        """Where the errors are written, by a protocol."""
        return scores_path(self.workspace, self.cell, self.on_rough, protocol)

    def held(self) -> dict[str, Any] | None:
        """What the judgement was made from, if there is one, and nothing that it depends on has changed or gone."""
        if self.cell.weights(self.workspace) is None or self.workspace.record(self.stage) is None:
            return None
        try:
            inputs = self.inputs()
        except InputError:
            return None
        return inputs if self.workspace.is_current(self.stage, inputs) else None
