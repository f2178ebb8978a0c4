"""Scores of networks on test scans: where they are written, and whether they are up to date. Nothing here needs torch."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import networks_digest
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset, scans_fingerprint
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.scans.files.scan_file import ScanFile

Protocol = Literal["kinmo", "ancsh"]
"""Definition of errors: kinmo's, or that of ANCSH's public code, its faults included."""
PROTOCOLS: tuple[Protocol, ...] = ("kinmo", "ancsh")


class NoTestScans(InputError):
    """No test object has the structure that the networks know."""


@dataclass(frozen=True)
class ScanScores:
    """Scores of a run's networks on the test scans of its category, kept in the workspace of the networks."""

    workspace: Workspace
    run: ScanRun
    scanned: Workspace | None = None  # the workspace with the test scans, if it is another one
    title: str = ""  # name of these test scans, if they are those of another workspace

    @property
    def prefix(self) -> str:
        """Beginning of the names of all such stages."""
        return f"evaluate-{self.title}-scans-" if self.title else "evaluate-scans-"

    @property
    def stage(self) -> str:
        """Name of the record."""
        return self.prefix + self.run.key

    def files(self) -> tuple[ScanFile, ...]:
        """The test scans. Raises NoTestScans if there are none, InputError if they are unreadable or have another structure."""
        scanned = self.scanned or self.workspace
        dataset = open_scan_dataset(scanned, self.run.category, self.run.method)
        folder = scanned.scans / self.run.category
        if scanned != self.workspace:
            own = open_scan_dataset(self.workspace, self.run.category, self.run.method)
            if dataset.structure != own.structure:
                problem = f"expected scans of {own.structure.in_words}, like those trained on: render them again"
                raise InputError(folder, problem)
        if not dataset.files["test"]:
            raise NoTestScans(folder, f"expected scans of a test object with {dataset.structure.in_words}")
        return dataset.files["test"]

    def inputs(self) -> dict[str, Any]:
        """Everything that the scores depend on."""
        weights, files = self.run.weights(self.workspace) or (), self.files()
        structure, test = str(files[0].structure), scans_fingerprint(files)
        return {"structure": structure, "test": test, "weights": networks_digest(weights)}

    def current_inputs(self) -> dict[str, Any] | None:
        """Inputs of the scores, if there are any and they are up to date; otherwise None."""
        if self.run.weights(self.workspace) is not None and self.workspace.inputs_of(self.stage) is not None:
            with suppress(InputError):
                if self.workspace.is_current(self.stage, inputs := self.inputs()):
                    return inputs
        return None

    def path(self, protocol: Protocol) -> Path:
        """File of the scores by a protocol."""
        return self._folder / protocol / f"{self.run.key}.jsonl"

    @property
    def pictures(self) -> Path:
        """File of the pictures."""
        return self._folder / "pictures" / f"{self.run.key}.jsonl"

    @property
    def _folder(self) -> Path:
        return self.workspace.evaluation / (f"{self.title}-scans" if self.title else "scans")

    def record_reason(self, reason: str) -> None:
        """Record why there are no scores, for as long as the prepared shapes stay the same."""
        with self.workspace.locked():
            self.workspace.record(f"no-{self.stage}", {"shapes": self._shapes(), "reason": reason})

    def reason(self) -> str | None:
        """The recorded reason why there are no scores; None if there is none for the present shapes."""
        inputs = self.workspace.inputs_of(f"no-{self.stage}")
        return str(inputs["reason"]) if inputs is not None and inputs.get("shapes") == self._shapes() else None

    def _shapes(self) -> str:
        store = PreparedStore(self.workspace.prepared, self.workspace.select)
        return digest([[entry.layout, entry.id, entry.geometry_hash, entry.is_oracle] for entry in store.entries])
