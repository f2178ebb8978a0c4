"""The stage that labels scans of unlabelled objects with supervised networks."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

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
from kinmo.pipeline.scans.scan_dataset import COMPLETE, open_scan_dataset, scans_fingerprint
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.pipeline.scans.train_scans import self_labels_folder
from kinmo.scans.ancsh.ancsh_predictor import AncshPredictor
from kinmo.scans.files.scan_file import FORMAT, ScanProvenance, open_scans, write_scans

SECONDS_PER_FRAME = 0.03  # first estimate, for one CPU core
PREFIX = "self-label-"  # beginning of the names of all such stages in the journal


@dataclass(frozen=True)
class SelfLabelScans:
    """Label the scans of the unlabelled objects of a category with its supervised networks of a seed.

    The labels are complete once the cache of their folder has a result `COMPLETE`. At least the share `confidence` of each
    part's points must agree on its pose.
    """

    workspace: Workspace
    category: str
    confidence: float
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        """Nothing, if the labels are up to date."""
        labels = _Labels(self)
        return Plan((), 0.0) if labels.are_current else self._labelling(labels)

    def guess(self) -> Plan:
        """Estimate for labelling all present scans."""
        return self._labelling(_Labels(self))

    def _labelling(self, labels: _Labels) -> Plan:
        frames = sum(file.frames for file in labels.files)
        each = seconds_per_unit(self.workspace, labels.stage, SECONDS_PER_FRAME / self.workers, prefix=PREFIX)
        return Plan((f"label {counted(frames, 'scan')} of {labels.category} by supervised networks",), frames * each)

    def run(self, observer: Observer) -> Outcome:
        """Label the scans that are not up to date."""
        with self.workspace.locked():
            labels = _Labels(self)
            if labels.are_current:
                observer.note(f"{labels.category}: scans are already labelled")
            else:
                self._label(labels, observer)
        return Outcome(labels.folder, {"objects": len(list(labels.folder.glob("*.safetensors"))), "of": len(labels.files)})

    def _label(self, labels: _Labels, observer: Observer) -> None:
        if labels.weights is None:
            problem = f"no supervised networks for scans of {self.category}: run kinmo train ancsh --setting supervised"
            raise InputError(self.workspace.models, problem)
        cache = Cache(labels.folder)
        cache.forget(COMPLETE)
        remove_leftovers(cache.folder)
        jobs = [SelfLabelJob(file.path, cache_key(scans=file.provenance.key, **labels.settings)) for file in labels.files]
        pending = [job for job in jobs if not cache.is_current(job.name, job.key)]
        kept = {job.name for job in jobs if job not in pending}
        cache.forget(*(name for name in cache if name not in kept))
        for path in cache.folder.glob("*.safetensors"):
            if path.stem not in kept:
                path.unlink()
        frames = {file.path: file.frames for file in labels.files}
        digest = networks_digest(labels.weights)
        labeller = SelfLabeller(cache.folder, labels.weights, digest, self.device, self.confidence, self.seed)
        labelling = closing(network_runner(self.workers, self.device).run(labeller, pending))
        with timed(self.workspace, labels.stage) as watch, labelling as labelled:
            for done, (job, is_sure) in enumerate(labelled, start=1 + len(kept)):
                if isinstance(is_sure, Failure):
                    raise InputError(job.scans, f"cannot be labelled: {is_sure.reason}")
                cache.store(job.name, job.key, [cache.folder / job.scans.name] if is_sure else [])
                observer.progress("labelling scans", done, len(jobs), job.name)
            watch.amount = sum(frames[job.scans] for job in pending)
            watch.what = f"{counted(watch.amount, 'scan')} of {labels.category}"
        cache.store(COMPLETE, labels.key, sorted(cache.folder.glob("*.safetensors")))


class _Labels:
    """Labels of the present scans of unlabelled objects by the present supervised networks. Raises InputError without scans."""

    def __init__(self, stage: SelfLabelScans) -> None:
        dataset = open_scan_dataset(stage.workspace, stage.category)
        self.category, self.files = dataset.category, dataset.files["unlabelled"]
        if not self.files:
            problem = f"no scans of unlabelled objects of {self.category}: run kinmo render --unlabelled first"
            raise InputError(stage.workspace.scans, problem)
        self.stage = f"{PREFIX}{self.category}-{stage.seed}"
        self.folder = self_labels_folder(stage.workspace, self.category, stage.seed)
        self.weights = ScanRun(self.category, "supervised", stage.seed).weights(stage.workspace)
        weights = networks_digest(self.weights or ())  # without supervised networks nothing was made with them
        self.settings = {"weights": weights, "confidence": stage.confidence, "seed": stage.seed, "format": FORMAT}
        self.key = cache_key(scans=scans_fingerprint(self.files), **self.settings)

    @property
    def are_current(self) -> bool:
        return Cache(self.folder).is_current(COMPLETE, self.key)


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
    """Labels scans with both networks, whose hash is `digest`, in any process. `seed` is that of the pose fitting."""

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
