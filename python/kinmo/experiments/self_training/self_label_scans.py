"""The stage that labels scans of unlabelled objects with supervised networks."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
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
from kinmo.experiments.self_training.self_labels import self_label
from kinmo.io.atomic_files import remove_leftovers
from kinmo.learning.model_folder import networks_digest
from kinmo.pipeline.network_jobs import network_runner
from kinmo.pipeline.scans.scan_dataset import COMPLETE, ScanDataset, open_scan_dataset, scans_fingerprint
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.pipeline.scans.train_scans import self_labels_folder
from kinmo.scans.ancsh.ancsh_predictor import AncshPredictor
from kinmo.scans.files.scan_file import FORMAT, ScanFile, ScanProvenance, open_scans, write_scans

SECONDS_PER_FRAME = 0.03
"""First estimate, for one CPU core."""
PREFIX = "self-label-"
"""Beginning of the names of all such stages in the journal."""


@dataclass(frozen=True)
class SelfLabelScans:
    """Label the scans of the unlabelled objects of a category with its supervised networks.

    The labels are complete once the cache of their folder has a result `COMPLETE`.

    Attributes:
        workspace: The workspace.
        category: The category.
        confidence: Least share of each part's points that must agree on its pose.
        seed: Seed of the networks.
        device: Where networks run.
        workers: Number of processes.
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
        return Plan((), 0.0) if self._is_current(dataset) else self._labelling(dataset)

    def guess(self) -> Plan:
        """Estimate for labelling all present scans."""
        return self._labelling(open_scan_dataset(self.workspace, self.category))

    def _labelling(self, dataset: ScanDataset) -> Plan:
        frames = sum(file.frames for file in self._files(dataset))
        alone = SECONDS_PER_FRAME / self.workers
        each = seconds_per_unit(self.workspace, self._stage(dataset), alone, prefix=PREFIX)
        return Plan((f"label {counted(frames, 'scan')} of {dataset.category} by supervised networks",), frames * each)

    def run(self, observer: Observer) -> Outcome:
        """Label the scans that are not up to date."""
        with self.workspace.locked():
            dataset = open_scan_dataset(self.workspace, self.category)
            files, folder = self._files(dataset), self._folder(dataset)
            if self._is_current(dataset):
                observer.note(f"{dataset.category}: scans are already labelled")
            else:
                self._label(dataset, observer)
        return Outcome(folder, {"objects": len(list(folder.glob("*.safetensors"))), "of": len(files)})

    def _label(self, dataset: ScanDataset, observer: Observer) -> None:
        weights = self._run(dataset).weights(self.workspace)
        if weights is None:
            problem = f"no supervised networks for scans of {self.category}: run kinmo train ancsh --setting supervised"
            raise InputError(self.workspace.models, problem)
        files, settings, cache = self._files(dataset), self._settings(dataset), Cache(self._folder(dataset))
        cache.forget(COMPLETE)
        remove_leftovers(cache.folder)
        jobs = [SelfLabelJob(file.path, cache_key(scans=file.provenance.key, **settings)) for file in files]
        pending = [job for job in jobs if not cache.is_current(job.name, job.key)]
        kept = {job.name for job in jobs if job not in pending}
        cache.forget(*(name for name in cache if name not in kept))
        for path in cache.folder.glob("*.safetensors"):
            if path.stem not in kept:
                path.unlink()
        frames = {file.path: file.frames for file in files}
        labeller = SelfLabeller(cache.folder, weights, networks_digest(weights), self.device, self.confidence, self.seed)
        labelling = closing(network_runner(self.workers, self.device).run(labeller, pending))
        with timed(self.workspace, self._stage(dataset)) as watch, labelling as labelled:
            for done, (job, is_sure) in enumerate(labelled, start=1 + len(kept)):
                if isinstance(is_sure, Failure):
                    raise InputError(job.scans, f"cannot be labelled: {is_sure.reason}")
                cache.store(job.name, job.key, [cache.folder / job.scans.name] if is_sure else [])
                observer.progress("labelling scans", done, len(files), job.name)
            watch.amount = sum(frames[job.scans] for job in pending)
            watch.what = f"{counted(watch.amount, 'scan')} of {dataset.category}"
        cache.store(COMPLETE, self._key(dataset), sorted(cache.folder.glob("*.safetensors")))

    def _files(self, dataset: ScanDataset) -> Sequence[ScanFile]:
        """Scans to label. Raises InputError if there are none."""
        if not dataset.files["unlabelled"]:
            problem = f"no scans of unlabelled objects of {dataset.category}: run kinmo render --unlabelled first"
            raise InputError(self.workspace.scans, problem)
        return dataset.files["unlabelled"]

    def _folder(self, dataset: ScanDataset) -> Path:
        return self_labels_folder(self.workspace, dataset.category, self.seed)

    def _stage(self, dataset: ScanDataset) -> str:
        return f"{PREFIX}{dataset.category}-{self.seed}"

    def _run(self, dataset: ScanDataset) -> ScanRun:
        return ScanRun(dataset.category, "supervised", self.seed)

    def _settings(self, dataset: ScanDataset) -> dict[str, Any]:
        """Everything but the scans that labels depend on. Without supervised networks nothing was made with them."""
        weights = self._run(dataset).weights(self.workspace) or ()
        return {"weights": networks_digest(weights), "confidence": self.confidence, "seed": self.seed, "format": FORMAT}

    def _key(self, dataset: ScanDataset) -> str:
        """Cache key of all labels together."""
        return cache_key(scans=scans_fingerprint(dataset.files["unlabelled"]), **self._settings(dataset))

    def _is_current(self, dataset: ScanDataset) -> bool:
        return Cache(self._folder(dataset)).is_current(COMPLETE, self._key(dataset))


@dataclass(frozen=True)
class SelfLabelJob:
    """Scans of one object to label; `key` is the cache key of the labels."""

    scans: Path
    key: str

    @property
    def name(self) -> str:
        """Name of the labels in the cache of their folder."""
        return self.scans.stem


@dataclass(frozen=True)
class SelfLabeller:
    """Labels scans with networks, in any process.

    Attributes:
        folder: Folder of the labelled scans.
        weights: Weights of both networks.
        digest: Hash of the networks.
        device: Where networks run.
        confidence: Least share of each part's points that must agree on its pose.
        seed: Seed of the pose fitting.
    """

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
        predictions, estimates = network.predict(list(points), [1.0] * len(points), seed=self.seed)
        labelled = self_label(
            file.id, file.category, points, predictions, estimates, structure=network.structure, confidence=self.confidence
        )
        if labelled is None:
            return False
        provenance = ScanProvenance(job.key, "unlabelled", file.provenance.layout)
        write_scans(self.folder / job.scans.name, *labelled, provenance)
        return True


@lru_cache(maxsize=1)
def _networks(weights: tuple[Path, Path], digest: str, device: str) -> AncshPredictor:
    """Networks, read once per process as long as they stay the same."""
    return AncshPredictor.load(*weights, device=device)
