"""Scans of the labelled shapes of a workspace, and of those with pseudo labels."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

from kinmo import __version__
from kinmo.categories import same_category
from kinmo.config import ScansConfig, load_config
from kinmo.errors import InputError
from kinmo.formats import Found, Layout, discover, read_found
from kinmo.pipeline.dataset import Dataset, open_dataset
from kinmo.pipeline.journal import seconds_per_unit, timed
from kinmo.pipeline.pseudo_label import DECISIONS
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.scans.articulated_object import articulated_object
from kinmo.scans.scan import scan
from kinmo.scans.scan_file import ScanFile, open_scans, write_scans
from kinmo.splits import Split
from kinmo.store import IndexEntry
from kinmo.typed_tables import to_table
from kinmo.workers import Crashed, map_unordered
from kinmo.workspace import Workspace, digest, remove_leftovers

STAGE = "render"
PAPER_CATEGORIES = ("Refrigerator", "Dishwasher", "Table", "Door", "Scissors")
"""Of the paper's Table 2."""
SECONDS_PER_FRAME = 0.012

Labels = Literal["train", "validation", "test", "pseudo"]
"""Where an object's joints come from, and what it is for; those with pseudo labels are for training."""


@dataclass(frozen=True)
class Job:
    """One object to scan into `path`; `made_from` is a hash of all that its frames depend on."""

    found: Found
    category: str
    labels: Labels
    path: Path
    made_from: str


@dataclass(frozen=True)
class Render:
    """Scan the objects of a category, or of those of the paper's five that there are labelled shapes of.

    Frames that were made from the same files in the same way stay as they are.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    workers: int = 1

    def plan(self) -> Plan:
        config = load_config(self.config).scans
        pending = [job for job in self._jobs(config) if not _is_done(job)]
        frames = sum(_frames(config, job.labels) for job in pending)
        each = seconds_per_unit(self.workspace, STAGE, SECONDS_PER_FRAME / self.workers)
        steps = (f"scan {len(pending)} objects, {frames} frames",) if pending else ()
        return Plan(steps, frames * each)

    def run(self, observer: Observer) -> Outcome:
        config = load_config(self.config).scans
        with self.workspace.locked():
            remove_leftovers(self.workspace.scans)
            jobs = list(self._jobs(config))
            self._remove_stale(jobs)
            pending = [job for job in jobs if not _is_done(job)]
            refused = {}
            with timed(self.workspace, STAGE) as watch:
                for done, (job, problem) in enumerate(map_unordered(Rendering(config), pending, self.workers), start=1):
                    if problem:
                        refused[job.found.id] = "its process died" if isinstance(problem, Crashed) else problem
                    observer.progress("scanning objects", done, len(pending), job.found.id)
                watch.amount = sum(_frames(config, job.labels) for job in pending)
                watch.what = f"{len(pending)} objects"
            files = [open_scans(job.path) for job in jobs if job.path.exists()]
        data = {"categories": summary(files), "refused": refused}
        return Outcome(self.workspace.scans, data, _text(data))

    def _jobs(self, config: ScansConfig) -> Iterator[Job]:
        """Raises InputError where there is no labelled shape of the categories."""
        dataset = open_dataset(self.workspace, self.category)
        labelled = {split: _chosen(dataset.labelled[split], self.category) for split in Split}
        if not any(labelled.values()):
            wanted = self.category or f"one of {', '.join(PAPER_CATEGORIES)}"
            raise InputError(self.workspace.prepared, f"expected labelled shapes of {wanted}; --category names another")
        way = {"scans": to_table(config), "seed": self.seed, "kinmo": __version__}
        for split, entries in labelled.items():
            for entry in entries:
                found = Found(Path(entry.source), Layout(entry.layout), entry.id)
                yield self._job(found, entry.category, split.value, digest([dataset.fingerprint([entry]), way]))
        categories = {entry.category for entries in labelled.values() for entry in entries}
        yield from self._pseudo_jobs(dataset, categories, way)

    def _pseudo_jobs(self, dataset: Dataset, categories: set[str], way: dict[str, Any]) -> Iterator[Job]:
        if not self.workspace.pseudo.exists():
            return
        for found in discover(self.workspace.pseudo, skip=(self.workspace.pseudo / DECISIONS,)):
            label = (found.path / "mobility_v2.json").read_bytes()
            category = read_found(found).category
            if category in categories:
                yield self._job(found, category, "pseudo", digest([zlib.crc32(label), way]))

    def _job(self, found: Found, category: str, labels: Labels, made_from: str) -> Job:
        name = f"{quote(found.id, safe=' ')}-{found.layout.value}.safetensors"
        return Job(found, category, labels, self.workspace.scans / category / labels / name, made_from)

    def _remove_stale(self, jobs: Sequence[Job]) -> None:
        """Remove scans, of the categories at hand, of objects that are no longer there or are for something else now."""
        wanted = {job.path for job in jobs}
        for category in {job.category for job in jobs}:
            for path in (self.workspace.scans / category).rglob("*.safetensors"):
                if path not in wanted:
                    path.unlink()


@dataclass(frozen=True)
class Rendering:
    """Scans an object, in whatever process. The answer says why nothing came of it, empty if something did."""

    config: ScansConfig

    def __call__(self, job: Job) -> str:
        try:
            target = articulated_object(read_found(job.found), smallest=self.config.smallest_part)
        except ValueError as error:
            return str(error)
        seed = zlib.crc32(f"{job.found.id} {job.made_from}".encode())
        scans = scan(target, self.config, seed, to_train=job.labels in ("train", "pseudo"))
        job.path.parent.mkdir(parents=True, exist_ok=True)
        write_scans(job.path, target, scans, {"made_from": job.made_from, "labels": job.labels})
        return ""


def summary(files: Sequence[ScanFile]) -> dict[str, Any]:
    """By category: objects and frames by what they are for, structures, and frames refused by reason."""
    found: dict[str, Any] = {}
    for category in sorted({file.category for file in files}):
        own = [file for file in files if file.category == category]
        found[category] = {
            "objects": dict(Counter(file.provenance["labels"] for file in own)),
            "frames": sum(file.frames for file in own),
            "structures": dict(Counter(str(file.structure) for file in own)),
            "refused": dict(sum((Counter(file.refused) for file in own), Counter())),
        }
    return found


def _text(data: dict[str, Any]) -> str:
    lines = []
    for category, found in data["categories"].items():
        objects = ", ".join(f"{count} {labels}" for labels, count in found["objects"].items())
        lines.append(f"{category}: {found['frames']} frames of {objects} objects; {sum(found['refused'].values())} refused")
        lines += [f"    {count:5} {structure}" for structure, count in found["structures"].items()]
    lines += [f"left out  {reason}" for reason in data["refused"].values()]
    return "\n".join(lines)


def _chosen(entries: Sequence[IndexEntry], category: str | None) -> list[IndexEntry]:
    wanted = PAPER_CATEGORIES if category is None else (category,)
    return [entry for entry in entries if any(same_category(entry.category, name) for name in wanted)]


def _frames(config: ScansConfig, labels: Labels) -> int:
    return config.states * config.views if labels in ("train", "pseudo") else config.test_states * config.test_views


def _is_done(job: Job) -> bool:
    try:
        return bool(open_scans(job.path).provenance["made_from"] == job.made_from)
    except (InputError, KeyError):
        return False
