"""Scanning one object, in whatever process, and what is left of it: its scans, or why there are none."""

from __future__ import annotations

import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinmo.config import ScansConfig
from kinmo.formats import Found, read_found
from kinmo.limits import MOST_TURN
from kinmo.pipeline.scans.dataset import REFUSED
from kinmo.scans.articulated_object import ArticulatedObject, articulated_object, still_object
from kinmo.scans.articulation import opened_as_usual
from kinmo.scans.scan import Scans, scan
from kinmo.scans.scan_file import Provenance, Role, is_made_from, write_scans
from kinmo.scans.variants import draw_change
from kinmo.shape import Shape
from kinmo.workspace import write_text_atomically

VARIED: tuple[Role, ...] = ("train", "hidden", "pseudo")
"""Roles of objects that are scanned in variants too: more like them is what networks need, and what tests must not see."""
OPENING, CHANGING = 10, 11
"""What random numbers are for, beside what `kinmo.scans.scan` draws of the same seed."""


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
    """The object itself, or which one like it (`kinmo.scans.variants`)."""

    @property
    def is_done(self) -> bool:
        """Whether its scans are there, or why there are none, made from the same."""
        return self._refused().get("made_from") == self.made_from or is_made_from(self.path, self.made_from)

    @property
    def refusal(self) -> str | None:
        """Why it cannot be scanned; None where nothing says so."""
        return self._refused().get("reason")

    @property
    def files(self) -> tuple[Path, Path]:
        """Of its scans, and of its refusal."""
        return self.path, self.path.with_suffix(REFUSED)

    def refuse(self, reason: str) -> None:
        """Leave a reason in place of scans."""
        scans, refusal = self.files
        scans.unlink(missing_ok=True)
        text = json.dumps({"made_from": self.made_from, "reason": reason}, ensure_ascii=False)
        write_text_atomically(refusal, text + "\n")

    def write(self, target: ArticulatedObject, scans: Scans) -> None:
        """Leave scans of `target`, which is the object or one like it."""
        write_scans(self.path, target, scans, Provenance(self.made_from, self.role, self.layout, self.variant))
        self.files[1].unlink(missing_ok=True)

    def _refused(self) -> dict[str, str]:
        try:
            data = json.loads(self.files[1].read_text(encoding="utf-8"))
            return {"made_from": str(data["made_from"]), "reason": str(data["reason"])}
        except (OSError, ValueError, KeyError, TypeError):
            return {}


@dataclass(frozen=True)
class Rendering:
    """Scans an object, in whatever process; from the same sides and in the same states by whatever sensor."""

    config: ScansConfig
    seed: int

    def _moving(self, shape: Shape, job: Job, seed: int) -> ArticulatedObject:
        changing = np.random.default_rng([seed, CHANGING])
        return articulated_object(
            shape,
            smallest=self.config.smallest_part,
            closes=self.config.canonical == "closed",
            guessed_within=MOST_TURN if job.role == "pseudo" else None,
            change=draw_change(np.asarray(shape.up), self.config.stretch, changing) if job.variant else None,
        )

    def __call__(self, job: Job) -> None:
        job.path.parent.mkdir(parents=True, exist_ok=True)
        seed = zlib.crc32(f"{job.found.id} {job.role} {self.seed}".encode()) + job.variant
        try:
            shape = replace(read_found(job.found), id=job.found.id)
            target = still_object(shape) if job.role == "unlabelled" else self._moving(shape, job, seed)
        except ValueError as error:
            job.refuse(str(error))
            return
        drawing = np.random.default_rng([seed, OPENING])
        target = replace(target, mobility=opened_as_usual(target.mobility, MOST_TURN, job.openings, drawing))
        config = replace(self.config, states=_states(self.config, job))
        job.write(target, scan(target, config, seed, to_train=job.role not in ("validation", "test")))


def frames_of(config: ScansConfig, job: Job) -> int:
    """How many frames it gets, refused ones included."""
    if job.role in ("validation", "test"):
        return config.test_states * config.test_views
    return _states(config, job) * config.views


def _states(config: ScansConfig, job: Job) -> int:
    """Of an object that is not to choose or test by: those there are, shared out among it and those like it.

    What stands still looks the same in all states, and gets as many as one of those.
    """
    each, left = divmod(config.states, variants_of(config))
    return each + (job.variant < left)


def variants_of(config: ScansConfig) -> int:
    """How many an object to train on has, itself included: each with a state of its own, of closed objects alone, since what is
    stretched open does not close any more.
    """
    return min(config.variants, config.states) if config.canonical == "closed" else 1


def count_objects_of(jobs: Sequence[Job]) -> int:
    """Variants of an object are one."""
    return len({(job.role, job.found.id, job.layout) for job in jobs})
