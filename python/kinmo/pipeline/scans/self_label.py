"""Labels that trained networks give to scans of unlabelled objects: the setting `semi`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from kinmo import __version__
from kinmo.errors import InputError
from kinmo.learning.ancsh.predict import Ancsh
from kinmo.pipeline.journal import seconds_per_unit, timed
from kinmo.pipeline.model_files import networks_digest
from kinmo.pipeline.scans.dataset import ScanDataset, fingerprint, open_scan_dataset
from kinmo.pipeline.scans.networks import Cell
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.scans.scan_file import Provenance, ScanFile, is_made_from, open_scans, write_scans
from kinmo.scans.self_label import self_labelled
from kinmo.wording import counted
from kinmo.workspace import StageRecord, Workspace, digest, remove_leftovers

SECONDS_PER_FRAME = 0.1


@dataclass(frozen=True)
class SelfLabel:
    """Label the scans of the unlabelled objects of a category by its networks of the setting `supervised`."""

    workspace: Workspace
    category: str
    confidence: float
    seed: int = 0
    device: str = "auto"

    def plan(self) -> Plan:
        dataset = open_scan_dataset(self.workspace, self.category)
        frames = sum(file.frames for file in dataset.files["unlabelled"])
        if self._cell(dataset).weights(self.workspace) and self._is_current(dataset):
            return Plan((), 0.0)
        each = seconds_per_unit(self.workspace, self._stage(dataset), SECONDS_PER_FRAME, kind="self-label-")
        return Plan((f"label {counted(frames, 'scan')} of {self.category} by what networks say",), frames * each)

    def run(self, observer: Observer) -> Outcome:
        with self.workspace.locked():
            dataset = open_scan_dataset(self.workspace, self.category)
            folder = self_labels_folder(self.workspace, dataset.category, self.seed)
            if self._is_current(dataset):
                observer.note(f"{dataset.category}: scans are labelled already")
                return Outcome(folder)
            weights = self._cell(dataset).weights(self.workspace)
            if weights is None:
                raise InputError(self.workspace.models, f"no networks to label scans of {self.category} by")
            files = dataset.files["unlabelled"]
            if not files:
                problem = f"no scans of unlabelled objects of {dataset.category}: run kinmo render --unlabelled first"
                raise InputError(self.workspace.own_scans, problem)
            inputs, stage = self._inputs(dataset), self._stage(dataset)
            self.workspace.forget(stage)
            remove_leftovers(folder)
            made_from = {_own_path(folder, file): digest([inputs, file.id]) for file in files}
            for path in folder.glob("*.safetensors"):
                if path not in made_from or not is_made_from(path, made_from[path]):
                    path.unlink()
            pending = [file for file in files if not _own_path(folder, file).exists()]
            network = Ancsh.load(*weights, device=self.device)
            with timed(self.workspace, stage) as watch:
                for done, file in enumerate(pending, start=1 + len(files) - len(pending)):
                    path = _own_path(folder, file)
                    self._label(file, network, path, made_from[path])
                    observer.progress("labelling scans", done, len(files), file.id)
                watch.amount = sum(file.frames for file in pending)
                watch.what = f"{counted(watch.amount, 'scan')} of {dataset.category}"
            outputs = tuple(str(path.relative_to(self.workspace.path)) for path in sorted(folder.glob("*.safetensors")))
            self.workspace.write_record(stage, StageRecord(inputs, outputs))
        return Outcome(folder, {"objects": len(outputs), "of": len(files)})

    def _label(self, file: ScanFile, network: Ancsh, path: Path, made_from: str) -> None:
        points = file.read("points")
        answers, estimates = network.find(list(points), [1.0] * len(points), seed=self.seed)
        made = self_labelled((file.id, file.category), points, answers, estimates, network.structure, self.confidence)
        if made is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_scans(path, *made, Provenance(made_from, "unlabelled", file.provenance.layout))

    def _stage(self, dataset: ScanDataset) -> str:
        return f"self-label-{dataset.category}-{self.seed}"

    def _cell(self, dataset: ScanDataset) -> Cell:
        return Cell(dataset.category, "supervised", self.seed)

    def _inputs(self, dataset: ScanDataset) -> dict[str, Any]:
        weights = self._cell(dataset).weights(self.workspace)
        return {
            "data": fingerprint(dataset.files["unlabelled"]),
            "weights": networks_digest(weights or ()),
            "confidence": self.confidence,
            "kinmo": __version__,
        }

    def _is_current(self, dataset: ScanDataset) -> bool:
        return self.workspace.is_current(self._stage(dataset), self._inputs(dataset))


def _own_path(folder: Path, file: ScanFile) -> Path:
    return folder / f"{quote(file.path.stem, safe=' ')}.safetensors"


def self_labels_folder(workspace: Workspace, category: str, seed: int) -> Path:
    """Where the scans that networks of a seed labelled lie."""
    return workspace.own_scans / category / f"semi-{seed}"


def self_labels(workspace: Workspace, category: str, seed: int) -> list[ScanFile]:
    """Those scans."""
    return [open_scans(path) for path in sorted(self_labels_folder(workspace, category, seed).glob("*.safetensors"))]
