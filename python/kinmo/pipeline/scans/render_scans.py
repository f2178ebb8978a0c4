"""Scans of the shapes of a workspace: of those with joints, by them, of those with pseudo labels, by these."""

from __future__ import annotations

import os
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.config import ScansConfig, SensorConfig, load_config
from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.names import name_on_disk
from kinmo.core.typed_tables import to_table
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.shape_dataset import Dataset, open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workers import Crashed, map_unordered, or_crashed
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import remove_leftovers, write_text_atomically
from kinmo.io.readers import Found, Layout
from kinmo.pipeline.label_decisions import LABELS, folder_name
from kinmo.pipeline.scans.refusal import refusal_path
from kinmo.pipeline.scans.render_jobs import VARIED, Job, Rendering, by_object, count_objects_of, frames_of, variants_of
from kinmo.pipeline.scans.render_summary import in_words, summary
from kinmo.pipeline.scans.scan_dataset import (
    LABELLED,
    PAPER_CATEGORIES,
    scanned_categories,
    scans_of,
    unfinished,
    usual_structure,
)
from kinmo.scans.articulated_object import Structure
from kinmo.scans.joint_states import opening
from kinmo.scans.scan_file import FORMAT, ROLES, Role, ScanFile, open_scans

STAGE = "render"
WITH_LABELS: tuple[Role, ...] = ("hidden", "pseudo")
"""Roles of other shapes whose joints are known, in some way."""
SECONDS_PER_FRAME = 0.012
"""On one core, until the journal knows better."""
USED = 0.4
"""Of shapes to be labelled, so many get labels that are accepted and have the joints that most have (bench/BENCHMARK.md, Pseudo
labels: .38, .37, .48, .29 and .55 in five families).
"""
WAITING = "{} with pseudo labels: without scans of {}, which could not be made, it is not known how far hinges open"


@dataclass(frozen=True)
class Render:
    """Scan the objects of a category, or of those of the paper's five that there are labelled shapes of.

    Every labelled shape to train on is scanned as its joints move it. With them come the other labelled ones, and those of the
    roles in `beside`: shapes with held back or pseudo labels as these say, if they have the structure that most of the first
    have, as networks know no other; unlabelled ones as they stand. Where the configuration names joints, those to train on are
    scanned only if they have these, too. Frames that were made from the same files in the same way stay as they are, whether
    asked for or not.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    workers: int = 1
    beside: tuple[Role, ...] = WITH_LABELS

    def plan(self) -> Plan:
        config = self._scans()
        return self._scanning(config, self._undone(config))

    def guess(self) -> Plan:
        """With scans by pseudo labels that are yet to be made, of which so many are used as usually are."""
        config = self._scans()
        pending = self._undone(config)
        if "pseudo" in self.beside:
            unlabelled = list(by_object(job for job in self._jobs(config, labelled=False) if job.role == "pseudo"))
            pending += [job for own in unlabelled[: round(USED * len(unlabelled))] for job in own]
        return self._scanning(config, pending)

    def _undone(self, config: ScansConfig) -> list[Job]:
        """Without what has gone: it is tried, and told, each time, but nothing can come of it that others wait for."""
        jobs = (
            job
            for job in _wanting(list(self._jobs(config)), self._structure(config))
            if self._is_asked(job) and not job.is_done
        )
        return [job for job in jobs if os.path.lexists(job.found.path)]

    def _scanning(self, config: ScansConfig, jobs: Sequence[Job]) -> Plan:
        frames = sum(frames_of(config, job) for job in jobs)
        each = seconds_per_unit(self.workspace, STAGE, SECONDS_PER_FRAME / self.workers)
        what = ", ".join(sorted({job.category for job in jobs}))
        if jobs:
            step = f"scan {counted(count_objects_of(jobs), 'object')} ({what}), {counted(frames, 'frame')}"
            return Plan((step,), frames * each)
        stopped = [category for category in scanned_categories(self.workspace) if self._was_stopped(category)]
        return Plan(tuple(f"look through the scans of {category}, which was stopped" for category in stopped), 0.0)

    def _was_stopped(self, category: str) -> bool:
        return _is_wanted(category, self.category) and any(mark.exists() for mark in self._marks(category))

    def _marks(self, category: str) -> list[Path]:
        """That scans of what is asked for are being made, or were not made to the end."""
        return [unfinished(self.workspace, category, role) for role in (*LABELLED, *self.beside)]

    def run(self, observer: Observer) -> Outcome:
        config = self._scans()
        open_dataset(Workspace(self.workspace.root), self.category)  # raises where there is nothing to scan, and makes nothing
        with self.workspace.locked():
            for folder in (self.workspace.scans, self.workspace.own_scans):
                remove_leftovers(folder)
            structure = self._structure(config)
            every = _wanting(list(self._jobs(config)), structure)
            jobs = [job for job in every if self._is_asked(job)]
            pending = [job for job in jobs if not job.is_done]
            if jobs and not pending:
                observer.note("scanned already")
            begun = {job.category for job in pending}  # of all their roles: which of these are done, those to train on decide
            for mark in {unfinished(self.workspace, job.category, job.role) for job in jobs if job.category in begun}:
                write_text_atomically(mark, "kinmo render makes the scans beside this, or was stopped: run it again\n")
            failed: list[tuple[Job, str]] = []
            total = count_objects_of(pending)
            with timed(self.workspace, STAGE) as watch:
                for done, (own, problem) in enumerate(self._scanned(config, jobs, structure), start=1):
                    if isinstance(problem, Crashed):
                        problem = f"{own[0].found.path}: cannot be scanned: {problem.why}"
                    if problem is not None:
                        observer.problem(f"left out: {problem}")
                        failed.append((own[0], problem))
                        _remove(path for job in own for path in job.files)  # of earlier ways: nothing may take them for these
                    observer.progress("scanning objects", done, max(done, total), own[0].found.id)
                watch.amount = sum(frames_of(config, job) for job in pending)
                watch.what = counted(count_objects_of(pending), "object")
            self._remove_stale(_wanting(every, structure))
            _remove(chain.from_iterable(self._marks(category) for category in {job.category for job in every}))
            files = [open_scans(job.path) for job in jobs if job.path.exists()]
            refusals = [(job, refusal) for job in jobs if (refusal := job.refusal) is not None]
            refused = [(job, refusal.reason) for job, refusal in refusals if refusal.structure is None]
        unwanted = [(job.category, refusal.structure) for job, refusal in refusals if refusal.structure and not job.variant]
        left_out: dict[Role, dict[str, str]] = {}  # ids may be in several roles
        for job, reason in refused + failed:
            left_out.setdefault(job.role, {})[job.found.id] = reason
        data = {"categories": summary(files, unwanted), "refused": left_out}
        seen = {file.category for file in files if file.provenance.role == "train" and file.frames}
        bare = sorted({job.category for job in jobs if job.role == "train"} - seen)
        for each in bare:
            observer.problem(f"{each}: no frame of an object to train on")
        text = in_words(data)
        return Outcome(self.workspace.scans, data, text, failed=len(failed) + len(bare))

    def _is_asked(self, job: Job) -> bool:
        return job.role in (*LABELLED, *self.beside)

    def _scanned(
        self, config: ScansConfig, jobs: Sequence[Job], structure: Structure | None
    ) -> Iterator[tuple[tuple[Job, ...], Crashed | str | None]]:
        """The jobs of one object after another, of those that are not done, and what kept it from being scanned; what keeps
        several of them is told once.

        Objects to train on come first, as they decide which structure others must have; pseudo-labelled ones last, as those
        with true labels show how far hinges open.
        """
        scan_all = partial(or_crashed, Rendering(config, self.seed))
        yield from map_unordered(scan_all, _pending(job for job in jobs if job.role == "train"), self.workers)
        jobs = _wanting(jobs, structure)
        yield from map_unordered(scan_all, _pending(job for job in jobs if job.role not in ("train", "pseudo")), self.workers)
        # without the scans of one of these they would have other openings, and keep them
        guessed = [job for job in jobs if job.role == "pseudo" and not job.is_done]
        likes = dict.fromkeys(job.like for job in guessed)
        unseen = {like: [path for path in like if not path.exists() and not _is_refused(path)] for like in likes}
        for like, missing in unseen.items():
            if missing:
                waiting = tuple(job for job in guessed if job.like == like)
                yield waiting, WAITING.format(counted(count_objects_of(waiting), "object"), missing[0].stem)
        openings = {like: _openings(like) for like, missing in unseen.items() if not missing}
        guessed = [replace(job, openings=openings[job.like]) for job in guessed if job.like in openings]
        yield from map_unordered(scan_all, by_object(guessed), self.workers)

    def _scans(self) -> ScansConfig:
        """The configuration, of which only the sensor counts that there is."""
        config = load_config(self.config).scans
        return replace(config, sensor=config.rough if self.workspace.is_rough else config.sensor, rough=SensorConfig())

    def _structure(self, config: ScansConfig) -> Structure | None:
        """The one that the configuration names; None if it leaves that to the labelled shapes."""
        try:
            return Structure.of(config.joints) if config.joints else None
        except ValueError as error:
            raise InputError(self.config, str(error), "scans.joints") from None

    def _jobs(self, config: ScansConfig, labelled: bool = True) -> Iterator[Job]:
        """Raises InputError where there is no labelled shape of the categories.

        Shapes with pseudo labels are among them; or if these are not `labelled`, those that may get such labels.
        """
        for job in self._objects(config, labelled):
            for variant in range(variants_of(config) if job.role in VARIED else 1):
                name = f"{job.path.stem}.{variant}.safetensors" if variant else job.path.name
                yield replace(job, path=job.path.with_name(name), variant=variant)

    def _objects(self, config: ScansConfig, has_labels: bool) -> Iterator[Job]:
        whole = open_dataset(Workspace(self.workspace.root), self.category)
        own = open_dataset(self.workspace, self.category)
        way = {"scans": to_table(config), "seed": self.seed, "kinmo": __version__, "format": FORMAT}
        roles: dict[Role, Sequence[IndexEntry]] = {split.value: whole.labelled[split] for split in Split}
        roles["hidden"] = whole.hidden
        labelled = {role: _chosen(entries, self.category) for role, entries in roles.items()}
        if not labelled["train"]:
            wanted = self.category or f"one of {', '.join(PAPER_CATEGORIES)}"
            problem = f"expected labelled shapes of {wanted} to train on; --category names another"
            raise InputError(self.workspace.prepared, problem)
        labelled["unlabelled"] = _chosen(own.unlabelled, self.category)
        counted = {entry.id for entry in own.labelled[Split.TRAIN]}
        examples: dict[str, list[Job]] = {}
        for role, entries in labelled.items():
            for entry in entries:
                found = Found(Path(entry.source), Layout(entry.layout), entry.id)
                made_from = digest([whole.fingerprint([entry]), way, role])
                job = _job(self.workspace, found, entry.category, role, entry.layout, made_from)
                if role == "train":
                    examples.setdefault(entry.category, []).extend([job] if entry.id in counted else [])
                yield job
        yield from self._pseudo_jobs(own, examples, way, has_labels)

    def _pseudo_jobs(
        self, own: Dataset, examples: Mapping[str, Sequence[Job]], way: dict[str, Any], has_labels: bool
    ) -> Iterator[Job]:
        """Of the categories of `examples`, the labelled objects that are trained on."""
        for entry in own.unlabelled:
            folder = self.workspace.pseudo / folder_name(entry)
            label = folder / LABELS
            if entry.category in examples and label.exists() == has_labels:
                known = examples[entry.category]
                seen = [job.made_from for job in known]
                content = zlib.crc32(label.read_bytes()) if has_labels else None
                made_from = digest([own.fingerprint([entry]), content, way, seen])
                found = Found(folder, Layout.PARTNET_MOBILITY, entry.id)
                job = _job(self.workspace, found, entry.category, "pseudo", entry.layout, made_from)
                yield replace(job, like=tuple(job.path for job in known))

    def _remove_stale(self, jobs: Collection[Job]) -> None:
        """Remove what stands in the folders of the categories at hand and is not of a job that is done."""
        current = {path for job in jobs if job.is_done for path in job.files}
        for category in {job.category for job in jobs}:
            for role in ROLES:
                _remove(path for path in scans_of(self.workspace, category, role).glob("*.*") if path not in current)


def _remove(paths: Iterable[Path]) -> None:
    for path in paths:
        path.unlink(missing_ok=True)


def _is_refused(scans: Path) -> bool:
    return refusal_path(scans).exists()


def _pending(jobs: Iterable[Job]) -> Iterator[tuple[Job, ...]]:
    """Those that are not done, by object."""
    return by_object(job for job in jobs if not job.is_done)


def _wanting(jobs: Sequence[Job], structure: Structure | None) -> list[Job]:
    """The same, wanted only if they have the `structure`, or if there is none, that which the scans to train on show, as far as
    there are any.

    Those scans themselves, where they tell it, and those of unlabelled objects, which have none, are wanted in any case.
    """
    if structure is not None:
        return [job if job.role == "unlabelled" else replace(job, wanted=structure) for job in jobs]
    scanned: dict[str, list[ScanFile]] = {}
    for job in jobs:
        if job.role == "train" and job.is_done and job.path.exists():
            scanned.setdefault(job.category, []).append(open_scans(job.path))
    structures = {category: usual_structure(files) for category, files in scanned.items()}
    return [job if job.role in ("train", "unlabelled") else replace(job, wanted=structures.get(job.category)) for job in jobs]


def _openings(scanned: Iterable[Path]) -> tuple[float, ...]:
    """How far from closed the hinges open, as far as that is known, of the objects that there are scans of."""
    files = (open_scans(path) for path in scanned if path.exists())
    return tuple(filter(None, (opening(joint) for file in files for joint in file.joints)))


def _job(workspace: Workspace, found: Found, category: str, role: Role, layout: str, made_from: str) -> Job:
    name = f"{name_on_disk(found.id)}-{layout}.safetensors"
    return Job(found, category, role, layout, scans_of(workspace, category, role) / name, made_from)


def _chosen(entries: Sequence[IndexEntry], category: str | None) -> list[IndexEntry]:
    return [entry for entry in entries if _is_wanted(entry.category, category)]


def _is_wanted(category: str, wanted: str | None) -> bool:
    """Whether scans of a category are asked for; None stands for those of the paper."""
    return any(same_category(category, name) for name in (PAPER_CATEGORIES if wanted is None else (wanted,)))
