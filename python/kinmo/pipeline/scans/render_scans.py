"""The stage `render`: it scans shapes with a virtual depth camera."""

from __future__ import annotations

import os
from collections.abc import Collection, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from zlib import crc32

from kinmo.config import ScansConfig, SensorConfig, load_config
from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.core.names import name_on_disk
from kinmo.core.typed_tables import to_table
from kinmo.core.wording import counted
from kinmo.dataset.cache import Cache, cache_key
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import remove_leftovers
from kinmo.io.discover import ShapeSource
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.pseudo_label_files import LABEL, label_name, labels_folder
from kinmo.pipeline.scans.render_jobs import (
    VARIED_ROLES,
    NotScanned,
    ObjectRenderer,
    RenderJob,
    ScanCaches,
    by_object,
    count_frames,
    count_objects_of,
    count_variants,
    known_openings,
    with_structure,
)
from kinmo.pipeline.scans.render_summary import summarise, summary_text
from kinmo.pipeline.scans.scan_dataset import COMPLETE, LABELLED, PAPER_CATEGORIES, scanned_categories, scans_folder
from kinmo.scans.files.scan_file import FORMAT, ROLES, Role, open_scans
from kinmo.scans.object_structure import Structure

STAGE = "render"
WITH_LABELS: tuple[Role, ...] = ("oracle", "pseudo")  # additional roles of shapes whose joints are known or predicted
SECONDS_PER_FRAME = 0.012  # first estimate, for one CPU core
USED_SHARE = 0.4
"""Share of unlabelled shapes that usually get accepted labels with the usual structure (docs/background, pseudo labels)."""


@dataclass(frozen=True)
class RenderScans:
    """Scan the objects of one category, or of the paper's five categories.

    All labelled training shapes are scanned. Other objects are scanned only if they have the structure that most training
    objects have, since networks know no other. Unlabelled ones are scanned as they stand. Frames that are up to date stay.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    workers: int = 1
    extra: tuple[Role, ...] = WITH_LABELS  # roles to scan besides those of labelled shapes
    method: str = DEFAULT_METHOD  # whose pseudo labels are used
    sensor: SensorConfig | None = None  # in place of the configuration's
    cluster: str | None = None  # address of a Ray cluster that runs the jobs; None for this machine

    def plan(self) -> Plan:
        """Count the frames that are not up to date."""
        config = self._scans_config()
        return self._scanning(config, self._pending(config))

    def guess(self) -> Plan:
        """Estimate with the usual share of shapes that will have pseudo labels."""
        config = self._scans_config()
        pending = self._pending(config)
        if "pseudo" in self.extra:
            unlabelled = list(by_object(job for job in self._jobs(config, labelled=False) if job.role == "pseudo"))
            pending += [job for own in unlabelled[: round(USED_SHARE * len(unlabelled))] for job in own]
        return self._scanning(config, pending)

    def _pending(self, config: ScansConfig) -> list[RenderJob]:
        """Jobs to do, without shapes that are gone: these are reported each time, but no other stage needs to wait for them."""
        caches = ScanCaches()
        jobs = with_structure(list(self._jobs(config)), self._named_structure(config), caches)
        return [job for job in jobs if job.role in self._roles and not caches.is_done(job) and os.path.lexists(job.found.path)]

    def _scanning(self, config: ScansConfig, jobs: Sequence[RenderJob]) -> Plan:
        if jobs:
            frames = sum(count_frames(config, job) for job in jobs)
            each = seconds_per_unit(self.workspace, STAGE, SECONDS_PER_FRAME / self.workers)
            what = ", ".join(sorted({job.category for job in jobs}))
            step = f"scan {counted(count_objects_of(jobs), 'object')} ({what}), {counted(frames, 'frame')}"
            return Plan((step,), frames * each)
        interrupted = [
            category
            for category in scanned_categories(self.workspace)
            if _is_wanted(category, self.category)
            and any(tuple(cache) and COMPLETE not in cache for cache in map(Cache, self._folders(category)))
        ]
        return Plan(tuple(f"check the scans of {category}, which were interrupted" for category in interrupted), 0.0)

    @property
    def _roles(self) -> tuple[Role, ...]:
        return (*LABELLED, *self.extra)

    def _folders(self, category: str) -> list[Path]:
        return [scans_folder(self.workspace, category, role, self.method) for role in self._roles]

    def run(self, observer: Observer) -> Outcome:
        """Scan what is not up to date, and remove scans of shapes that are gone."""
        config = self._scans_config()
        open_dataset(self.workspace, self.category)  # raises before anything is written
        with self.workspace.locked():
            remove_leftovers(self.workspace.scans)
            caches = ScanCaches()
            structure = self._named_structure(config)
            every = with_structure(list(self._jobs(config)), structure, caches)
            jobs = [job for job in every if job.role in self._roles]
            pending = [job for job in jobs if not caches.is_done(job)]
            if jobs and not pending:
                observer.note("already scanned")
            for category in {job.category for job in pending}:  # training scans decide what is scanned in other roles
                for folder in self._folders(category):
                    caches[folder].forget(COMPLETE)
            failed: list[tuple[RenderJob, str]] = []
            total = count_objects_of(pending)
            scanning = closing(self._scan(config, jobs, structure, caches))  # no job outlives the lock
            with timed(self.workspace, STAGE) as watch, scanning as results:
                for done, (own, answer) in enumerate(results, start=1):
                    if isinstance(answer, Failure):
                        answer = f"{own[0].found.path}: cannot be scanned: {answer.reason}"
                    if isinstance(answer, str):
                        observer.problem(f"skipped: {answer}")
                        failed.append((own[0], answer))
                        caches.remove(own)
                    else:
                        caches.store(own, answer)
                    observer.progress("scanning objects", done, max(done, total), own[0].found.id)
                watch.amount = sum(count_frames(config, job) for job in pending)
                watch.what = counted(total, "object")
            self._remove_stale(with_structure(every, structure, caches), caches)
            for category in {job.category for job in every}:
                for folder in self._folders(category):
                    caches[folder].store(COMPLETE, "")
            return self._outcome(jobs, failed, caches, observer)

    def _outcome(
        self, jobs: Sequence[RenderJob], failed: Sequence[tuple[RenderJob, str]], caches: ScanCaches, observer: Observer
    ) -> Outcome:
        files = [open_scans(job.path) for job in jobs if job.path.exists()]
        skips = [(job, skip) for job in jobs if (skip := caches.not_scanned(job.path)) is not None]
        unwanted = [(job.category, skip.structure) for job, skip in skips if skip.structure and not job.variant]
        reasons = [(job, skip.reason) for job, skip in skips if skip.structure is None]
        skipped: dict[Role, dict[str, str]] = {}  # an id may occur in several roles
        for job, reason in (*reasons, *failed):
            skipped.setdefault(job.role, {})[job.found.id] = reason
        data = {"categories": summarise(files, unwanted), "skipped": skipped}
        seen = {file.category for file in files if file.provenance.role == "train" and file.frames}
        without = sorted({job.category for job in jobs if job.role == "train"} - seen)
        for category in without:
            observer.problem(f"{category}: no frame of a training object")
        return Outcome(self.workspace.scans, data, summary_text(data), failed=len(failed) + len(without))

    def _scan(
        self, config: ScansConfig, jobs: Sequence[RenderJob], structure: Structure | None, caches: ScanCaches
    ) -> Generator[tuple[tuple[RenderJob, ...], list[NotScanned | None] | Failure | str], None, None]:
        """Scan the pending jobs of one object after another.

        Training objects come first: they decide on the structure that others must have. Pseudo-labelled ones come last:
        labelled objects show how far hinges open.
        """
        render, runner = ObjectRenderer(config, self.seed), runner_for(self.workers, self.cluster)

        def pending(some: Iterable[RenderJob]) -> Iterator[tuple[RenderJob, ...]]:
            return by_object(job for job in some if not caches.is_done(job))

        yield from runner.run(render, pending(job for job in jobs if job.role == "train"))
        jobs = with_structure(jobs, structure, caches)
        yield from runner.run(render, pending(job for job in jobs if job.role not in ("train", "pseudo")))
        guessed = [job for job in jobs if job.role == "pseudo" and not caches.is_done(job)]
        openings: dict[tuple[Path, ...], tuple[float, ...]] = {}
        for references in dict.fromkeys(job.references for job in guessed):
            # without one of them, scans would have other openings, and keep them
            missing = [path for path in references if not path.exists() and not caches.not_scanned(path)]
            if missing:
                waiting = tuple(job for job in guessed if job.references == references)
                objects = f"{counted(count_objects_of(waiting), 'object')} with pseudo labels"
                why = f"scans of {missing[0].stem} are missing, which show how far hinges open"
                yield waiting, f"{objects}: skipped because {why}"
            else:
                openings[references] = known_openings(references)
        guessed = [replace(job, openings=openings[job.references]) for job in guessed if job.references in openings]
        yield from runner.run(render, by_object(guessed))

    def _scans_config(self) -> ScansConfig:
        """Settings of the scans. The other sensor is left out, because the frames do not depend on it."""
        config = load_config(self.config).scans
        return replace(config, sensor=self.sensor or config.sensor, noisy_sensor=SensorConfig())

    def _named_structure(self, config: ScansConfig) -> Structure | None:
        """The structure that the configuration names; None if the labelled shapes decide."""
        try:
            return Structure.parse(config.joints) if config.joints else None
        except ValueError as error:
            raise InputError(self.config, str(error), "scans.joints") from None

    def _jobs(self, config: ScansConfig, labelled: bool = True) -> Iterator[RenderJob]:
        """All jobs, variants included; with `labelled` False those for shapes that may still get pseudo labels.

        Raises InputError where the categories have no labelled training shape.
        """
        for job in self._objects(config, labelled):
            for variant in range(count_variants(config) if job.role in VARIED_ROLES else 1):
                name = job.path.name if not variant else f"{job.path.stem}.{variant}.safetensors"
                yield replace(job, path=job.path.with_name(name), variant=variant)

    def _objects(self, config: ScansConfig, labelled: bool) -> Iterator[RenderJob]:
        dataset = open_dataset(self.workspace, self.category)
        settings = {"scans": to_table(config), "seed": self.seed, "format": FORMAT}
        by_role: dict[Role, Sequence[IndexEntry]] = {split.value: dataset.labelled[split] for split in Split}
        by_role |= {"oracle": dataset.oracle, "unlabelled": dataset.unlabelled}
        chosen = {role: [e for e in entries if _is_wanted(e.category, self.category)] for role, entries in by_role.items()}
        if not chosen["train"]:
            wanted = self.category or f"one of {', '.join(PAPER_CATEGORIES)}"
            problem = f"expected labelled shapes of {wanted} to train on; --category names another"
            raise InputError(self.workspace.prepared, problem)
        examples: dict[str, list[RenderJob]] = {}
        for role, entries in chosen.items():
            for entry in entries:
                key = cache_key(shape=entry.key, settings=settings, role=role)
                job = self._job(ShapeSource.of(entry), entry, role, key)
                if role == "train":
                    examples.setdefault(entry.category, []).append(job)
                yield job
        for entry in dataset.unlabelled:
            folder = labels_folder(self.workspace, self.method) / label_name(entry)
            known = examples.get(entry.category, [])
            if known and (folder / LABEL).exists() == labelled:
                label = crc32((folder / LABEL).read_bytes()) if labelled else None
                references = [job.key for job in known]
                key = cache_key(shape=entry.key, settings=settings, label=label, references=references)
                found = ShapeSource(folder, PARTNET_MOBILITY, entry.id)
                yield replace(self._job(found, entry, "pseudo", key), references=tuple(job.path for job in known))

    def _job(self, found: ShapeSource, entry: IndexEntry, role: Role, key: str) -> RenderJob:
        folder = scans_folder(self.workspace, entry.category, role, self.method)
        path = folder / f"{name_on_disk(found.id)}-{entry.layout}.safetensors"
        return RenderJob(found, entry.category, role, entry.layout, path, key)

    def _remove_stale(self, jobs: Collection[RenderJob], caches: ScanCaches) -> None:
        """Remove scans in the folders of the categories at hand that belong to no finished job.

        A folder that loses scans here is complete again only when its role is scanned.
        """
        current = {job.path for job in jobs if caches.is_done(job)}
        for category in {job.category for job in jobs}:
            for role in ROLES:
                cache = caches[scans_folder(self.workspace, category, role, self.method)]
                names = {path.stem for path in current if path.parent == cache.folder}
                cache.forget(*(name for name in cache if name not in names | {COMPLETE}))
                stale = [path for path in cache.folder.glob("*.safetensors") if path not in current]
                if stale:
                    cache.forget(COMPLETE)
                for path in stale:
                    path.unlink()


def _is_wanted(category: str, wanted: str | None) -> bool:
    """True if scans of a category are asked for; None stands for the paper's categories."""
    return any(same_category(category, name) for name in (PAPER_CATEGORIES if wanted is None else (wanted,)))
