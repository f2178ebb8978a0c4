"""Scanning of one object, in any process."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np

from kinmo.config import ScansConfig
from kinmo.core.shape import Shape
from kinmo.features.joint_limits import MAX_HINGE_ANGLE
from kinmo.io.discover import ShapeSource
from kinmo.scans.canonical.articulated_object import ArticulatedObject, articulated_object, single_part_object
from kinmo.scans.canonical.hinge_openings import with_sampled_openings
from kinmo.scans.canonical.object_variants import sample_variant_matrix
from kinmo.scans.files.scan_file import Role, ScanProvenance, write_scans
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
    """One object, or one variant of it, to scan.

    Attributes:
        found: The shape's files.
        category: Category of the shape.
        role: Use of the scans.
        layout: Dataset layout of the original shape.
        path: File for the scans.
        key: Cache key of the scans.
        references: Scans of the labelled objects of the category; they show how far hinges open, unlike pseudo labels.
        openings: Opening angles of the hinges in those scans, in radians.
        variant: 0 for the object itself, otherwise the number of the variant.
        wanted: Structure that the object must have to be scanned; None for any.
    """

    found: ShapeSource
    category: str
    role: Role
    layout: str
    path: Path
    key: str
    references: tuple[Path, ...] = ()
    openings: tuple[float, ...] = ()
    variant: int = 0
    wanted: Structure | None = None

    @property
    def name(self) -> str:
        """Name of the scans in the cache of their folder."""
        return self.path.stem

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
        """Scan one object, which is read once.

        Args:
            jobs: The object, which comes first if it is among them, and its variants.

        Returns:
            For each job None if its scans were written, or the reason why not. A message if the object could not be read: it
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
            if job.wanted is None or target.structure == job.wanted:
                self._scan(target, job, seed)
                results.append(None)
                continue
            unwanted = NotScanned(f"{job.found.path}: has {target.structure.in_words}", str(target.structure))
            if not job.variant:  # variants have the same structure
                return [unwanted] * len(jobs)
            results.append(unwanted)
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
        to_train = job.role not in EVALUATED_ROLES
        which = _states(self.config, job) if to_train else slice(None)
        scans = scan_object(target, self.config, seed, to_train=to_train, subset=which)
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
    """Number of variants of a training object, itself included, each with at least one joint state.

    Only closed objects have variants: an object that is stretched while open does not close any more.
    """
    return min(config.variants, config.states) if config.closes_objects else 1


def by_object(jobs: Iterable[RenderJob]) -> Iterator[tuple[RenderJob, ...]]:
    """Group the jobs of each object, which are adjacent."""
    return (tuple(own) for _, own in groupby(jobs, key=lambda job: job.object))


def count_objects_of(jobs: Sequence[RenderJob]) -> int:
    """Number of objects; variants do not count."""
    return len({job.object for job in jobs})
