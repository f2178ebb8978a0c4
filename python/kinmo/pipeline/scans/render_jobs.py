"""Render jobs: scanning of one object, in any process, and the results of earlier jobs."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np

from kinmo.config import ScansConfig
from kinmo.core.shape import Shape
from kinmo.dataset.cache import Cache
from kinmo.features.joint_limits import MAX_HINGE_ANGLE
from kinmo.io.discover import ShapeSource
from kinmo.pipeline.scans.scan_dataset import usual_structure
from kinmo.scans.canonical.articulated_object import ArticulatedObject, articulated_object, single_part_object
from kinmo.scans.canonical.hinge_openings import hinge_opening, with_sampled_openings
from kinmo.scans.canonical.object_variants import sample_variant_matrix
from kinmo.scans.files.scan_file import Role, ScanFile, ScanProvenance, open_scans, write_scans
from kinmo.scans.object_structure import Structure
from kinmo.scans.rendering.labelled_frames import scan_object

VARIED_ROLES: tuple[Role, ...] = ("train", "oracle", "pseudo")
"""Roles whose objects are scanned in variants too. Tests must not see variants."""
EVALUATED_ROLES: tuple[Role, ...] = ("validation", "test")
SEED_NAMES: Mapping[Role, str] = {"oracle": "hidden"}
"""Names of roles in seeds, if they have others there: with another name all random numbers would change."""
OPENING_STREAM, VARIANT_STREAM = 10, 11
"""Streams of random numbers; `labelled_frames` draws others from the same seed."""


@dataclass(frozen=True)
class RenderJob:
    """One object, or one variant of it, to scan into the file `path`."""

    found: ShapeSource
    category: str
    role: Role
    layout: str  # of the original shape
    path: Path
    key: str  # cache key of the scans
    references: tuple[Path, ...] = ()  # scans of labelled objects, which show how far hinges open; pseudo labels do not
    openings: tuple[float, ...] = ()  # opening angles of the hinges in those scans, in radians
    variant: int = 0  # 0 for the object itself, otherwise the number of the variant
    wanted: Structure | None = None  # structure that the object must have to be scanned; None for any

    @property
    def object(self) -> tuple[Role, str, str]:
        """Identity of the object; its variants share it."""
        return self.role, self.found.id, self.layout


@dataclass(frozen=True)
class NotScanned:
    """The `reason` why an object has no scans; `structure` is given if the structure is the reason."""

    reason: str
    structure: str | None = None


@dataclass(frozen=True)
class ObjectRenderer:
    """Scans an object and its variants. Views and joint states do not depend on the sensor."""

    config: ScansConfig
    seed: int

    def __call__(self, jobs: Sequence[RenderJob]) -> list[NotScanned | None] | str:
        """Scan an object, which is read once: itself, which comes first if it is among the jobs, and its variants.

        Returns None for each job whose scans were written, or the reason why not. A message if the object could not be read: it
        could when it was prepared, so that is no final result.
        """
        jobs[0].path.parent.mkdir(parents=True, exist_ok=True)
        try:
            shape = replace(jobs[0].found.read(), id=jobs[0].found.id)
        except ValueError as error:
            return str(error)
        results: list[NotScanned | None] = []
        for job in jobs:
            seed = zlib.crc32(f"{job.found.id} {SEED_NAMES.get(job.role, job.role)} {self.seed}".encode()) + job.variant
            try:
                target = single_part_object(shape) if job.role == "unlabelled" else self._articulated(shape, job, seed)
            except ValueError as error:
                results.append(NotScanned(str(error)))
                continue
            if job.wanted is not None and target.structure != job.wanted:
                unwanted = NotScanned(f"{job.found.path}: has {target.structure.in_words}", str(target.structure))
                if not job.variant:  # variants have the same structure
                    return [unwanted] * len(jobs)
                results.append(unwanted)
            else:
                self._scan(target, job, seed)
                results.append(None)
        return results

    def _articulated(self, shape: Shape, job: RenderJob, seed: int) -> ArticulatedObject:
        rng = np.random.default_rng([seed, VARIANT_STREAM])
        return articulated_object(
            shape,
            min_part_size=self.config.smallest_part,
            closes=self.config.closes_objects,
            max_guessed_opening=MAX_HINGE_ANGLE if job.role == "pseudo" else None,
            variant_matrix=sample_variant_matrix(np.asarray(shape.up), self.config.stretch, rng) if job.variant else None,
        )

    def _scan(self, target: ArticulatedObject, job: RenderJob, seed: int) -> None:
        rng = np.random.default_rng([seed, OPENING_STREAM])
        target = replace(target, mobility=with_sampled_openings(target.mobility, MAX_HINGE_ANGLE, job.openings, rng))
        is_evaluated = job.role in EVALUATED_ROLES
        which = slice(None) if is_evaluated else _states(self.config, job)
        scans = scan_object(target, self.config, seed, to_train=not is_evaluated, subset=which)
        write_scans(job.path, target, scans, ScanProvenance(job.key, job.role, job.layout, job.variant))


def count_frames(config: ScansConfig, job: RenderJob) -> int:
    """Number of frames of a job, including frames that show too little."""
    if job.role in EVALUATED_ROLES:
        return config.test_states * config.test_views
    return len(range(config.states)[_states(config, job)]) * config.views


def _states(config: ScansConfig, job: RenderJob) -> slice:
    """Joint states of a training object: it shares them with its variants."""
    return slice(job.variant, None, count_variants(config))


def count_variants(config: ScansConfig) -> int:
    """Number of variants of a training object, itself included, each with at least one joint state."""
    # an object that is stretched while open does not close any more
    return min(config.variants, config.states) if config.closes_objects else 1


def by_object(jobs: Iterable[RenderJob]) -> Iterator[tuple[RenderJob, ...]]:
    """Group the jobs of each object, which are adjacent."""
    return (tuple(own) for _, own in groupby(jobs, key=lambda job: job.object))


def count_objects_of(jobs: Sequence[RenderJob]) -> int:
    """Number of objects; variants do not count."""
    return len({job.object for job in jobs})


class ScanCaches(dict[Path, Cache]):
    """The caches of all folders of scans, each read once."""

    def __missing__(self, folder: Path) -> Cache:
        self[folder] = Cache(folder)
        return self[folder]

    def is_done(self, job: RenderJob) -> bool:
        """True if a job's scans are up to date, or it is known that there can be none."""
        found = self[job.path.parent].find(job.path.stem)
        if found is None or found.key != job.key:
            return False
        structure = (found.data or {}).get("structure")
        return structure is None or (job.wanted is not None and structure != str(job.wanted))

    def not_scanned(self, path: Path) -> NotScanned | None:
        """The reason why there are no scans in a file; None if there are some, or none were tried."""
        data = self[path.parent].data(path.stem) or {}
        return NotScanned(data["reason"], data.get("structure")) if "reason" in data else None

    def store(self, jobs: Sequence[RenderJob], results: Sequence[NotScanned | None]) -> None:
        """Store the results of one object."""
        for job, skip in zip(jobs, results, strict=True):
            cache = self[job.path.parent]
            if skip is None:
                cache.store(job.path.stem, job.key, [job.path])
            else:
                job.path.unlink(missing_ok=True)
                facts = {"reason": skip.reason, "structure": skip.structure, "layout": job.layout, "variant": job.variant}
                cache.store(job.path.stem, job.key, data=facts)

    def remove(self, jobs: Sequence[RenderJob]) -> None:
        """Remove scans of an object that cannot be read now: they may come from other settings."""
        for job in jobs:
            self[job.path.parent].forget(job.path.stem)
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
    joints = (joint for path in paths if path.exists() for joint in open_scans(path).joints)
    return tuple(filter(None, map(hinge_opening, joints)))
