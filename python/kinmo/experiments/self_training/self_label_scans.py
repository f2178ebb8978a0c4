"""The stage that labels scans of unlabelled objects with supervised networks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.cache import Cache, cache_key
from kinmo.dataset.jobs import Failure
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.self_training.self_labels import self_labelled
from kinmo.io.atomic_files import remove_leftovers
from kinmo.learning.model_folder import networks_digest
from kinmo.pipeline.network_jobs import network_runner
from kinmo.pipeline.scans.scan_dataset import ScanDataset, open_scan_dataset, scans_fingerprint
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.pipeline.scans.train_scans import self_labels_folder
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.files.scan_file import FORMAT, ScanFile, ScanProvenance, open_scans, write_scans

SECONDS_PER_FRAME = 0.03
"""First estimate, for one CPU core."""
PREFIX = "self-label-"


@dataclass(frozen=True)
class SelfLabelScans:
    """Label the scans of the unlabelled objects of a category with its supervised networks.

    Attributes:
        workspace: the workspace.
        category: the category.
        confidence: least share of each part's points that must agree on its pose.
        seed: seed of the networks.
        device: where networks run.
        workers: number of processes.
    """

    workspace: Workspace
    category: str
    confidence: float
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        """Nothing, if the labels are up to date."""
        dataset = open_scan_dataset(self.workspace, self.category)
        self._files(dataset)
        if self._run(dataset).weights(self.workspace) and self._is_current(dataset):
            return Plan((), 0.0)
        return self._labelling(dataset)

    def guess(self) -> Plan:
        """Estimate for labelling all present scans."""
        return self._labelling(open_scan_dataset(self.workspace, self.category))

    def _labelling(self, dataset: ScanDataset) -> Plan:
        frames = sum(file.frames for file in self._files(dataset))
        alone = SECONDS_PER_FRAME / self.workers
        each = seconds_per_unit(self.workspace, self._stage(dataset), alone, prefix=PREFIX)
        return Plan((f"label {counted(frames, 'scan')} of {self.category} by supervised networks",), frames * each)

    def run(self, observer: Observer) -> Outcome:
        """Label the scans."""
        with self.workspace.locked():
            dataset = open_scan_dataset(self.workspace, self.category)
            folder = self_labels_folder(self.workspace, dataset.category, self.seed)
            if self._is_current(dataset):
                observer.note(f"{dataset.category}: scans are already labelled")
                return Outcome(folder)
            weights = self._run(dataset).weights(self.workspace)
            if weights is None:
                problem = f"no supervised networks for scans of {self.category}: run kinmo train ancsh --setting supervised"
                raise InputError(self.workspace.models, problem)
            files = self._files(dataset)
            inputs, stage = self._inputs(dataset), self._stage(dataset)
            self.workspace.forget(stage)
            remove_leftovers(folder)
            cache = Cache(folder)
            jobs = [SelfLabelJob(file.path, cache_key(inputs=inputs, object=file.id)) for file in files]
            pending = [job for job in jobs if not cache.is_current(job.scans.stem, job.key)]
            for path in folder.glob("*.safetensors"):
                if path.name not in {job.scans.name for job in jobs if job not in pending}:
                    path.unlink()
            frames = {file.path: file.frames for file in files}
            labeller = SelfLabeller(folder, weights, inputs["weights"], self.device, self.confidence, self.seed)
            with timed(self.workspace, stage) as watch:
                labelled = network_runner(self.workers, self.device).run(labeller, pending)
                for done, (job, answer) in enumerate(labelled, start=1 + len(files) - len(pending)):
                    if isinstance(answer, Failure):
                        raise InputError(job.scans, f"cannot be labelled: {answer.reason}")
                    cache.store(job.scans.stem, job.key, [folder / job.scans.name] if answer else [])
                    observer.progress("labelling scans", done, len(files), job.scans.stem)
                watch.amount = sum(frames[job.scans] for job in pending)
                watch.what = f"{counted(watch.amount, 'scan')} of {dataset.category}"
            outputs = sorted(folder.glob("*.safetensors"))
            self.workspace.record(stage, inputs, outputs)
        return Outcome(folder, {"objects": len(outputs), "of": len(files)})

    def _files(self, dataset: ScanDataset) -> Sequence[ScanFile]:
        """Scans to label. Raises InputError if there are none."""
        if not dataset.files["unlabelled"]:
            problem = f"no scans of unlabelled objects of {dataset.category}: run kinmo render --unlabelled first"
            raise InputError(self.workspace.scans, problem)
        return dataset.files["unlabelled"]

    def _stage(self, dataset: ScanDataset) -> str:
        return f"{PREFIX}{dataset.category}-{self.seed}"

    def _run(self, dataset: ScanDataset) -> ScanRun:
        return ScanRun(dataset.category, "supervised", self.seed)

    def _inputs(self, dataset: ScanDataset) -> dict[str, Any]:
        weights = self._run(dataset).weights(self.workspace)
        return {
            "data": scans_fingerprint(dataset.files["unlabelled"]),
            "weights": networks_digest(weights or ()),
            "confidence": self.confidence,
            "format": FORMAT,
        }

    def _is_current(self, dataset: ScanDataset) -> bool:
        return self.workspace.is_current(self._stage(dataset), self._inputs(dataset))


@dataclass(frozen=True)
class SelfLabelJob:
    """Scans of one object to label; `key` is the cache key of the labels."""

    scans: Path
    key: str


@dataclass(frozen=True)
class SelfLabeller:
    """Labels scans with the networks of some `weights` (their hash is `digest`) into `folder`, in any process."""

    folder: Path
    weights: tuple[Path, Path]
    digest: str
    device: str
    confidence: float
    seed: int

    def __call__(self, job: SelfLabelJob) -> bool:
        """Write labelled scans. Returns False if the networks are sure of no frame."""
        network, file = _networks(self.weights, self.digest, self.device), open_scans(job.scans)
        points = file.read("points")
        predictions, estimates = network.find(list(points), [1.0] * len(points), seed=self.seed)
        made = self_labelled((file.id, file.category), points, predictions, estimates, network.structure, self.confidence)
        if made is None:
            return False
        provenance = ScanProvenance(job.key, "unlabelled", file.provenance.layout)
        write_scans(self.folder / file.path.name, *made, provenance)
        return True


@lru_cache(maxsize=1)
def _networks(weights: tuple[Path, Path], digest: str, device: str) -> Ancsh:
    """Networks, read once per process as long as they stay the same."""
    return Ancsh.load(*weights, device=device)
