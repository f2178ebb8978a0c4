"""What networks that see scans are judged on, and whether they were. Nothing here needs torch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.learning.model_folder import networks_digest
from kinmo.pipeline.scans.scan_dataset import fingerprint, open_scan_dataset
from kinmo.pipeline.scans.scan_networks import Cell, Protocol, scores_path
from kinmo.scans.scan_file import ScanFile


class NothingToJudgeBy(InputError):
    """No test object has the structure that networks know."""


@dataclass(frozen=True)
class JudgedScans:
    """The test scans of a cell's category, or those by the rough sensor."""

    workspace: Workspace
    cell: Cell
    on_rough: bool = False

    @property
    def kind(self) -> str:
        """What the names of all such stages begin with."""
        return f"eval-{'rough-' if self.on_rough else ''}scans-"

    @property
    def stage(self) -> str:
        return self.kind + self.cell.key

    def files(self) -> tuple[ScanFile, ...]:
        """Raises NothingToJudgeBy if there are none, InputError if it cannot be told, or rough ones are of other objects."""
        scanned = Workspace(self.workspace.root, is_rough=self.on_rough)
        dataset = open_scan_dataset(scanned, self.cell.category)
        folder = scanned.scans / self.cell.category
        if self.on_rough:
            clean = open_scan_dataset(Workspace(self.workspace.root), self.cell.category)
            if dataset.structure != clean.structure:
                known = clean.structure.in_words
                raise InputError(folder, f"expected scans of {known}, as the others are: run kinmo table sensors again")
        if not dataset.files["test"]:
            raise NothingToJudgeBy(folder, f"expected scans of a test object with {dataset.structure.in_words}")
        return dataset.files["test"]

    def inputs(self) -> dict[str, Any]:
        """What the judgement depends on."""
        return {"test": fingerprint(self.files()), "weights": networks_digest(self.cell.weights(self.workspace) or ())}

    def scores(self, protocol: Protocol) -> Path:
        """Where the errors are written, by a protocol."""
        return scores_path(self.workspace, self.cell, self.on_rough, protocol)

    def leave_out(self, reason: str) -> None:
        """Keep why there is no such judgement, for as long as the prepared shapes are those that there are now."""
        with self.workspace.locked():
            self.workspace.write_record(self._absence, StageRecord({"shapes": self._shapes(), "reason": reason}))

    def reason(self) -> str | None:
        """Why there is no such judgement, if that was told of the prepared shapes that there are now."""
        record = self.workspace.record(self._absence)
        is_known = record is not None and record.inputs.get("shapes") == self._shapes()
        return str(record.inputs["reason"]) if record is not None and is_known else None

    @property
    def _absence(self) -> str:
        return f"no-{self.stage}"

    def _shapes(self) -> str:
        store = PreparedStore(self.workspace.prepared)
        return digest([[entry.layout, entry.id, entry.geometry_hash, entry.is_held_back] for entry in store.entries])

    def held(self) -> dict[str, Any] | None:
        """What the judgement was made from, if there is one, and nothing that it depends on has changed or gone."""
        if self.cell.weights(self.workspace) is None or self.workspace.record(self.stage) is None:
            return None
        try:
            inputs = self.inputs()
        except InputError:
            return None
        return inputs if self.workspace.is_current(self.stage, inputs) else None
