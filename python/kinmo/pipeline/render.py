"""Scans of the shapes of a workspace: of those with joints, by them, of those with pseudo labels, by these."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

from kinmo import __version__
from kinmo.categories import same_category
from kinmo.config import ScansConfig, SensorConfig, load_config
from kinmo.errors import InputError
from kinmo.formats import Found, Layout
from kinmo.joint import JointKind
from kinmo.pipeline.dataset import Dataset, open_dataset
from kinmo.pipeline.journal import seconds_per_unit, timed
from kinmo.pipeline.label_decisions import LABELS, folder_name
from kinmo.pipeline.scan_dataset import PAPER_CATEGORIES, ROLES, Role, scans_of
from kinmo.pipeline.scan_jobs import VARIED, Job, Rendering, count_objects_of, frames_of, variants_of
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.scans.scan_file import ScanFile, open_scans
from kinmo.splits import Split
from kinmo.store import IndexEntry
from kinmo.typed_tables import to_table
from kinmo.workers import Crashed, map_unordered
from kinmo.workspace import Workspace, digest, remove_leftovers

STAGE = "render"
SECONDS_PER_FRAME = 0.012
"""On one core, until the journal knows better."""


@dataclass(frozen=True)
class Render:
    """Scan the objects of a category, or of those of the paper's five that there are labelled shapes of.

    Every labelled shape is scanned as its joints move it, and every one with a pseudo label as that says; with `unlabelled`,
    those without joints too, as they stand. Frames that were made from the same files in the same way stay as they are.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    workers: int = 1
    unlabelled: bool = False

    def plan(self) -> Plan:
        config = self._scans()
        pending = [job for job in self._jobs(config) if not job.is_done]
        frames = sum(frames_of(config, job) for job in pending)
        each = seconds_per_unit(self.workspace, STAGE, SECONDS_PER_FRAME / self.workers)
        what = ", ".join(sorted({job.category for job in pending}))
        steps = (f"scan {count_objects_of(pending)} objects ({what}), {frames} frames",) if pending else ()
        return Plan(steps, frames * each)

    def run(self, observer: Observer) -> Outcome:
        config = self._scans()
        with self.workspace.locked():
            for folder in (self.workspace.scans, self.workspace.own_scans):
                remove_leftovers(folder)
            jobs = list(self._jobs(config))
            self._remove_stale(jobs)
            pending = [job for job in jobs if not job.is_done]
            if jobs and not pending:
                observer.note("scanned already")
            crashed: list[Job] = []
            with timed(self.workspace, STAGE) as watch:
                for done, (job, problem) in enumerate(
                    map_unordered(Rendering(config, self.seed), pending, self.workers), start=1
                ):
                    if isinstance(problem, Crashed):
                        crashed.append(job)
                    observer.progress("scanning objects and variants", done, len(pending), job.found.id)
                watch.amount = sum(frames_of(config, job) for job in pending)
                watch.what = f"{count_objects_of(pending)} objects"
            files = [open_scans(job.path) for job in jobs if job.path.exists()]
            refused = {job.found.id: job.refusal for job in jobs if job.refusal is not None}
            refused |= {
                job.found.id: f"{job.found.path}: the process that scanned it died (too little memory?)" for job in crashed
            }
        data = {"categories": summary(files), "refused": refused}
        return Outcome(self.workspace.scans, data, _text(data), failed=len(crashed))

    def _scans(self) -> ScansConfig:
        """The configuration, of which only the sensor counts that there is."""
        config = load_config(self.config).scans
        return replace(config, sensor=config.rough if self.workspace.is_rough else config.sensor, rough=SensorConfig())

    def _jobs(self, config: ScansConfig) -> Iterator[Job]:
        """Raises InputError where there is no labelled shape of the categories."""
        for job in self._objects(config):
            for variant in range(variants_of(config) if job.role in VARIED else 1):
                name = f"{job.path.stem}.{variant}.safetensors" if variant else job.path.name
                yield replace(job, path=job.path.with_name(name), variant=variant)

    def _objects(self, config: ScansConfig) -> Iterator[Job]:
        whole = open_dataset(Workspace(self.workspace.root), self.category)
        own = open_dataset(self.workspace, self.category)
        way = {"scans": to_table(config), "seed": self.seed, "kinmo": __version__}
        roles: dict[Role, Sequence[IndexEntry]] = {split.value: whole.labelled[split] for split in Split}
        roles["hidden"] = whole.hidden
        labelled = {role: _chosen(entries, self.category) for role, entries in roles.items()}
        if not labelled["train"]:
            wanted = self.category or f"one of {', '.join(PAPER_CATEGORIES)}"
            problem = f"expected labelled shapes of {wanted} to train on; --category names another"
            raise InputError(self.workspace.prepared, problem)
        if self.unlabelled:
            labelled["unlabelled"] = _chosen(own.unlabelled, self.category)
        for role, entries in labelled.items():
            for entry in entries:
                found = Found(Path(entry.source), Layout(entry.layout), entry.id)
                made_from = digest([whole.fingerprint([entry]), way, role])
                yield _job(self.workspace, found, entry.category, role, entry.layout, made_from)
        yield from self._pseudo_jobs(own, {entry.category for entry in labelled["train"]}, way)

    def _pseudo_jobs(self, own: Dataset, categories: set[str], way: dict[str, Any]) -> Iterator[Job]:
        turns = {category: _turns(own, category) for category in categories}
        for entry in own.unlabelled:
            folder = self.workspace.pseudo / folder_name(entry)
            label = folder / LABELS
            if entry.category in categories and label.exists():
                own_turns = turns[entry.category]
                made_from = digest([own.fingerprint([entry]), zlib.crc32(label.read_bytes()), way, own_turns])
                found = Found(folder, Layout.PARTNET_MOBILITY, entry.id)
                job = _job(self.workspace, found, entry.category, "pseudo", entry.layout, made_from)
                yield replace(job, turns=own_turns)

    def _remove_stale(self, jobs: Sequence[Job]) -> None:
        """Remove scans, of the categories at hand, of objects that are no longer there or have another role."""
        wanted = {path for job in jobs for path in job.files}
        kept = () if self.unlabelled else ("unlabelled",)
        for category in {job.category for job in jobs}:
            for role in (role for role in ROLES if role not in kept):
                for path in scans_of(self.workspace, category, role).glob("*.*"):
                    if path not in wanted:
                        path.unlink()


def _turns(dataset: Dataset, category: str) -> tuple[float, ...]:
    """How wide the hinges of the labelled shapes of a category open that are trained on."""
    entries = [entry for entry in dataset.labelled[Split.TRAIN] if entry.category == category]
    shapes = (dataset.store.load(entry) for entry in entries)
    joints = (body.joint for shape in shapes if shape.mobility for _, body in shape.mobility.movable())
    limits = [(joint.lower, joint.upper) for joint in joints if joint is not None and joint.kind is JointKind.REVOLUTE]
    return tuple(upper - lower for lower, upper in limits if lower is not None and upper is not None)


def _job(workspace: Workspace, found: Found, category: str, role: Role, layout: str, made_from: str) -> Job:
    name = f"{quote(found.id, safe=' ')}-{layout}.safetensors"
    return Job(found, category, role, layout, scans_of(workspace, category, role) / name, made_from)


def _chosen(entries: Sequence[IndexEntry], category: str | None) -> list[IndexEntry]:
    wanted = PAPER_CATEGORIES if category is None else (category,)
    return [entry for entry in entries if any(same_category(entry.category, name) for name in wanted)]


def summary(files: Sequence[ScanFile]) -> dict[str, Any]:
    """By category: objects and frames by role, structures, and frames refused by reason."""
    found: dict[str, Any] = {}
    for category in sorted({file.category for file in files}):
        own = [file for file in files if file.category == category]
        moving = [file for file in own if file.provenance["role"] != "unlabelled"]
        found[category] = {
            "objects": _objects_by((str(file.provenance["role"]), file) for file in own),
            "frames": sum(file.frames for file in own),
            "structures": _objects_by((str(file.structure), file) for file in moving),
            "refused": dict(sum((Counter(file.refused) for file in own), Counter())),
        }
    return found


def _objects_by(files: Iterable[tuple[str, ScanFile]]) -> dict[str, int]:
    """How many objects there are scans of, by what stands before the files."""
    return dict(Counter(name for name, _ in {(name, file.object): None for name, file in files}))


def _text(data: dict[str, Any]) -> str:
    lines = []
    for category, found in data["categories"].items():
        objects = ", ".join(f"{count} {role}" for role, count in found["objects"].items())
        lines.append(f"{category}: {found['frames']} frames of {objects} objects; {sum(found['refused'].values())} refused")
        lines += [f"    {count:5} {structure}" for structure, count in found["structures"].items()]
    lines += [f"left out  {reason}" for reason in data["refused"].values()]
    return "\n".join(lines)
