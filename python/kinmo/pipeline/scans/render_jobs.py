"""Scanning one object, in whatever process, and what is left of it: its scans, or why there are none."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np

from kinmo.config import ScansConfig
from kinmo.core.shape import Shape
from kinmo.features.free_travel import MOST_TURN
from kinmo.io.readers import Found, read_found
from kinmo.pipeline.scans.refusal import Refusal, read_refusal, refusal_path, write_refusal
from kinmo.scans.articulated_object import ArticulatedObject, Structure, articulated_object, still_object
from kinmo.scans.joint_states import opened_as_usual
from kinmo.scans.labelled_frames import Scans, scan
from kinmo.scans.object_variants import draw_change
from kinmo.scans.scan_file import Provenance, Role, is_made_from, write_scans

VARIED: tuple[Role, ...] = ("train", "hidden", "pseudo")
"""Roles of objects that are scanned in variants too: more like them is what networks need, and what tests must not see."""
TO_MEASURE_BY: tuple[Role, ...] = ("validation", "test")
OPENING, CHANGING = 10, 11
"""What random numbers are for, beside what `kinmo.scans.labelled_frames` draws of the same seed."""


@dataclass(frozen=True)
class Job:
    """One object to scan into `path`; `made_from` is a hash of all that its frames depend on."""

    found: Found
    category: str
    role: Role
    layout: str
    path: Path
    made_from: str
    like: tuple[Path, ...] = ()
    """Where scans of labelled objects of the category are, which show what pseudo labels do not know."""
    openings: tuple[float, ...] = ()
    """How far their hinges open, in radians."""
    variant: int = 0
    """The object itself, or which one like it (`kinmo.scans.object_variants`)."""
    wanted: Structure | None = None
    """The structure without which it is not scanned; None for any."""

    @property
    def is_done(self) -> bool:
        """Whether its scans are there, or why there are none, made from the same."""
        refusal = self.refusal
        if refusal is None or refusal.made_from != self.made_from:
            return is_made_from(self.path, self.made_from)
        return refusal.structure is None or (self.wanted is not None and refusal.structure != str(self.wanted))

    @property
    def refusal(self) -> Refusal | None:
        """Why it is not scanned; None where nothing says so."""
        return read_refusal(refusal_path(self.path))

    @property
    def files(self) -> tuple[Path, Path]:
        """Of its scans, and of its refusal."""
        return self.path, refusal_path(self.path)

    @property
    def object(self) -> tuple[Role, str, str]:
        """What tells the object from others; those like it have the same."""
        return self.role, self.found.id, self.layout

    def refuse(self, reason: str, structure: Structure | None = None) -> None:
        """Leave a reason in place of scans, or the structure that is one."""
        scans, refusal = self.files
        scans.unlink(missing_ok=True)
        write_refusal(refusal, Refusal(self.made_from, reason, None if structure is None else str(structure)))

    def write(self, target: ArticulatedObject, scans: Scans) -> None:
        """Leave scans of `target`, which is the object or one like it."""
        self.files[1].unlink(missing_ok=True)  # first: what is cut off in between looks at the object again
        write_scans(self.path, target, scans, Provenance(self.made_from, self.role, self.layout, self.variant))


@dataclass(frozen=True)
class Rendering:
    """Scans an object and those like it, in whatever process; from the same sides and in the same states by whatever sensor."""

    config: ScansConfig
    seed: int

    def __call__(self, jobs: Sequence[Job]) -> str | None:
        """`jobs` are of one object, which is read once; the object itself comes first, if it is among them.

        Returns why it could not be read, which is no refusal: it could be when it was prepared, and may be again.
        """
        jobs[0].path.parent.mkdir(parents=True, exist_ok=True)
        try:
            shape = replace(read_found(jobs[0].found), id=jobs[0].found.id)
        except ValueError as error:
            return str(error)
        for job in jobs:
            seed = zlib.crc32(f"{job.found.id} {job.role} {self.seed}".encode()) + job.variant
            try:
                target = still_object(shape) if job.role == "unlabelled" else self._moving(shape, job, seed)
            except ValueError as error:
                job.refuse(str(error))
                continue
            if job.wanted is None or target.structure == job.wanted:
                self._scan(target, job, seed)
                continue
            # those like an object that is not wanted are not either; it comes last, so that what is cut off looks at it again
            unwanted = (job,) if job.variant else reversed(jobs)
            for each in unwanted:
                each.refuse(f"{job.found.path}: has {target.structure.in_words}", target.structure)
            if not job.variant:
                break
        return None

    def _moving(self, shape: Shape, job: Job, seed: int) -> ArticulatedObject:
        changing = np.random.default_rng([seed, CHANGING])
        return articulated_object(
            shape,
            smallest=self.config.smallest_part,
            closes=self.config.canonical == "closed",
            guessed_within=MOST_TURN if job.role == "pseudo" else None,
            change=draw_change(np.asarray(shape.up), self.config.stretch, changing) if job.variant else None,
        )

    def _scan(self, target: ArticulatedObject, job: Job, seed: int) -> None:
        drawing = np.random.default_rng([seed, OPENING])
        target = replace(target, mobility=opened_as_usual(target.mobility, MOST_TURN, job.openings, drawing))
        to_train = job.role not in TO_MEASURE_BY
        which = _share(self.config, job) if to_train else slice(None)
        job.write(target, scan(target, self.config, seed, to_train=to_train, which=which))


def frames_of(config: ScansConfig, job: Job) -> int:
    """How many frames it gets, refused ones included."""
    if job.role in TO_MEASURE_BY:
        return config.test_states * config.test_views
    return len(range(config.states)[_share(config, job)]) * config.views


def _share(config: ScansConfig, job: Job) -> slice:
    """Which of all states are of an object that is not to choose or test by: it takes turns with those like it.

    What stands still looks the same in all states, and gets as many as one of those.
    """
    return slice(job.variant, None, variants_of(config))


def variants_of(config: ScansConfig) -> int:
    """How many an object to train on has, itself included: each with a state of its own, of closed objects alone, since what is
    stretched open does not close any more.
    """
    return min(config.variants, config.states) if config.canonical == "closed" else 1


def by_object(jobs: Iterable[Job]) -> Iterator[tuple[Job, ...]]:
    """Those of one object, which stand in a row, together."""
    return (tuple(own) for _, own in groupby(jobs, key=lambda job: job.object))


def count_objects_of(jobs: Sequence[Job]) -> int:
    """Variants of an object are one."""
    return len({job.object for job in jobs})
