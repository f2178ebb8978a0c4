"""Labels that trained networks give to scans of unlabelled objects: the setting `semi`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workers import Crashed
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.experiments.self_training.self_labels import self_labelled
from kinmo.io.atomic_files import remove_leftovers
from kinmo.learning.model_folder import networks_digest
from kinmo.pipeline.each_shape import each_shape
from kinmo.pipeline.scans.scan_dataset import ScanDataset, fingerprint, open_scan_dataset
from kinmo.pipeline.scans.scan_networks import Cell
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.scan_file import FORMAT, Provenance, ScanFile, is_made_from, open_scans, write_scans

SECONDS_PER_FRAME = 0.03
"""On one core, until the journal knows better."""


@dataclass(frozen=True)
class SelfLabel:
    """Label the scans of the unlabelled objects of a category by its networks of the setting `supervised`."""

    workspace: Workspace
    category: str
    confidence: float
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        dataset = open_scan_dataset(self.workspace, self.category)
        frames = sum(file.frames for file in self._files(dataset))
        if self._cell(dataset).weights(self.workspace) and self._is_current(dataset):
            return Plan((), 0.0)
        alone = SECONDS_PER_FRAME / self.workers
        each = seconds_per_unit(self.workspace, self._stage(dataset), alone, kind="self-label-")
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
            files = self._files(dataset)
            inputs, stage = self._inputs(dataset), self._stage(dataset)
            self.workspace.forget(stage)
            remove_leftovers(folder)
            folder.mkdir(parents=True, exist_ok=True)
            jobs = {folder / file.path.name: Job(file.path, digest([inputs, file.id])) for file in files}
            for path in folder.glob("*.safetensors"):
                if path not in jobs or not is_made_from(path, jobs[path].made_from):
                    path.unlink()
            frames = {file.path: file.frames for file in files}
            pending = [job for path, job in jobs.items() if not path.exists()]
            labelling = Labelling(folder, weights, inputs["weights"], self.device, self.confidence, self.seed)
            with timed(self.workspace, stage) as watch:
                labelled = each_shape(labelling, pending, self.workers, self.device)
                for done, (job, answer) in enumerate(labelled, start=1 + len(files) - len(pending)):
                    if isinstance(answer, Crashed):
                        raise InputError(job.scans, f"cannot be labelled: {answer.why}")
                    observer.progress("labelling scans", done, len(files), job.scans.stem)
                watch.amount = sum(frames[job.scans] for job in pending)
                watch.what = f"{counted(watch.amount, 'scan')} of {dataset.category}"
            outputs = tuple(str(path.relative_to(self.workspace.path)) for path in sorted(folder.glob("*.safetensors")))
            self.workspace.write_record(stage, StageRecord(inputs, outputs))
        return Outcome(folder, {"objects": len(outputs), "of": len(files)})

    def _files(self, dataset: ScanDataset) -> Sequence[ScanFile]:
        """Those to label. Raises InputError if there are none."""
        if not dataset.files["unlabelled"]:
            problem = f"no scans of unlabelled objects of {dataset.category}: run kinmo render --unlabelled first"
            raise InputError(self.workspace.own_scans, problem)
        return dataset.files["unlabelled"]

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
            "format": FORMAT,
        }

    def _is_current(self, dataset: ScanDataset) -> bool:
        return self.workspace.is_current(self._stage(dataset), self._inputs(dataset))


@dataclass(frozen=True)
class Job:
    """The `scans` of one object to label; `made_from` is a hash of all that their labels depend on."""

    scans: Path
    made_from: str


@dataclass(frozen=True)
class Labelling:
    """Labels scans of objects by networks with these `weights`, of that `digest`, into `folder`, in whatever process."""

    folder: Path
    weights: tuple[Path, Path]
    digest: str
    device: str
    confidence: float
    seed: int

    def __call__(self, job: Job) -> None:
        network, file = _networks(self.weights, self.digest, self.device), open_scans(job.scans)
        points = file.read("points")
        answers, estimates = network.find(list(points), [1.0] * len(points), seed=self.seed)
        made = self_labelled((file.id, file.category), points, answers, estimates, network.structure, self.confidence)
        if made is not None:
            provenance = Provenance(job.made_from, "unlabelled", file.provenance.layout)
            write_scans(self.folder / file.path.name, *made, provenance)


@lru_cache(maxsize=1)
def _networks(weights: tuple[Path, Path], digest: str, device: str) -> Ancsh:
    """Read once a process, as long as they are the same."""
    return Ancsh.load(*weights, device=device)


def self_labels_folder(workspace: Workspace, category: str, seed: int) -> Path:
    """Where the scans that networks of a seed labelled lie."""
    return workspace.own_scans / category / f"semi-{seed}"


def self_labels(workspace: Workspace, category: str, seed: int) -> list[ScanFile]:
    """Those scans."""
    return [open_scans(path) for path in sorted(self_labels_folder(workspace, category, seed).glob("*.safetensors"))]
