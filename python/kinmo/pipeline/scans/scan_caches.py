"""Results of earlier render jobs: finished scans, the usual structure, and the openings of hinges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

from kinmo.dataset.cache import Cache
from kinmo.pipeline.scans.render_jobs import NotScanned, RenderJob
from kinmo.pipeline.scans.scan_dataset import usual_structure
from kinmo.scans.canonical.hinge_openings import hinge_opening
from kinmo.scans.files.scan_file import ScanFile, open_scans
from kinmo.scans.object_structure import Structure


class ScanCaches:
    """The caches of all folders of scans, each read once."""

    def __init__(self) -> None:
        self._known: dict[Path, Cache] = {}

    def of(self, folder: Path) -> Cache:
        """The cache of a folder."""
        if folder not in self._known:
            self._known[folder] = Cache(folder)
        return self._known[folder]

    def is_done(self, job: RenderJob) -> bool:
        """True if a job's scans are up to date, or it is known that there can be none."""
        found = self.of(job.path.parent).find(job.name)
        if found is None or found.key != job.key:
            return False
        structure = (found.data or {}).get("structure")
        return structure is None or (job.wanted is not None and structure != str(job.wanted))

    def not_scanned(self, job: RenderJob) -> NotScanned | None:
        """The reason why a job has no scans; None if it has some, or was not tried."""
        data = self.of(job.path.parent).data(job.name) or {}
        return NotScanned(data["reason"], data.get("structure")) if "reason" in data else None

    def is_skipped(self, path: Path) -> bool:
        """True if it is known that there can be no scans in this file."""
        return "reason" in (self.of(path.parent).data(path.stem) or {})

    def store(self, jobs: Sequence[RenderJob], results: Sequence[NotScanned | None]) -> None:
        """Store the results of one object."""
        for job, skip in zip(jobs, results, strict=True):
            cache = self.of(job.path.parent)
            if skip is None:
                cache.store(job.name, job.key, [job.path])
            else:
                job.path.unlink(missing_ok=True)
                facts = {"reason": skip.reason, "structure": skip.structure, "layout": job.layout, "variant": job.variant}
                cache.store(job.name, job.key, data=facts)

    def remove(self, jobs: Sequence[RenderJob]) -> None:
        """Remove scans of an object that cannot be read now: they may come from other settings."""
        for job in jobs:
            self.of(job.path.parent).forget(job.name)
            job.path.unlink(missing_ok=True)


def with_structure(jobs: Sequence[RenderJob], structure: Structure | None, caches: ScanCaches) -> list[RenderJob]:
    """The jobs, each with the structure that it must have: the given one, or the usual one of the training scans so far.

    Training objects must only have a given structure, and unlabelled objects none.
    """
    if structure is not None:
        return [job if job.role == "unlabelled" else replace(job, wanted=structure) for job in jobs]
    scanned: dict[str, list[ScanFile]] = {}
    for job in jobs:
        if job.role == "train" and caches.is_done(job) and job.path.exists():
            scanned.setdefault(job.category, []).append(open_scans(job.path))
    structures = {category: usual_structure(files) for category, files in scanned.items()}
    return [job if job.role in ("train", "unlabelled") else replace(job, wanted=structures.get(job.category)) for job in jobs]


def known_openings(paths: Iterable[Path]) -> tuple[float, ...]:
    """Known opening angles of the hinges in some scans, in radians."""
    files = [open_scans(path) for path in paths if path.exists()]
    return tuple(filter(None, (hinge_opening(joint) for joint in chain.from_iterable(file.joints for file in files))))
