"""Data of the benchmarks on real objects: workspaces of the real objects and of procedural shapes, and their folds."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count as numbers
from pathlib import Path
from typing import Literal

import numpy as np

from common import CACHE, REAL_OBJECTS, has_real_objects, option_parser
from kinmo.cli.console import LineObserver
from kinmo.dataset.splits import Split, fold_of, hashed_position, leaks, split_of
from kinmo.dataset.store import IndexEntry, PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import PreparedShape
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.pipeline.prepare_shapes import Prepare
from kinmo.synth.draw import ParameterRange
from kinmo.synth.families import family_names
from kinmo.synth.synth_stage import Synth

MECHANISM, NO_CATEGORY = "mechanism", "Mechanism"
"""Family of shapes that belong to no category, and what stands for their category."""
SEED = 11


@dataclass(frozen=True)
class Fold:
    """The shapes that a fold of a cross-validation trains on (`Workspace.select`): all but its test shapes and their copies.

    Shapes of the pipeline's own test split are trained on too. Their entries get an id of the training split.

    Attributes:
        number: Number of the fold.
        folds: Number of folds.
        by: Folds are of single shapes, or of whole categories. Shapes without a category are never tested then.
    """

    number: int
    folds: int
    by: Literal["id", "category"] = "id"

    def tests(self, entry: IndexEntry) -> bool:
        """True for a shape that the fold tests."""
        if self.by == "category":
            return entry.category != NO_CATEGORY and fold_of(entry.category, self.folds) == self.number
        return fold_of(entry.id, self.folds) == self.number

    def __call__(self, entries: Sequence[IndexEntry]) -> Sequence[IndexEntry]:
        """Entries to train on, from those of all shapes."""
        tested = [entry for entry in entries if self.tests(entry)]
        others = [entry for entry in entries if not self.tests(entry)]
        return [_not_tested(entry) for entry, copied in zip(others, leaks(others, tested, ()), strict=True) if not copied]


def _not_tested(entry: IndexEntry) -> IndexEntry:
    if split_of(entry.id) is not Split.TEST:
        return entry
    ids = (f"{entry.id}~{number}" for number in numbers())
    return replace(entry, id=next(name for name in ids if split_of(name) is Split.TRAIN))


def folds_of(
    entries: Sequence[IndexEntry], count: int, by: Literal["id", "category"] = "id"
) -> Iterator[tuple[Fold, list[IndexEntry]]]:
    """The folds of a cross-validation that test some of the shapes, with these."""
    for fold in (Fold(number, count, by) for number in range(count)):
        if tested := [entry for entry in entries if fold.tests(entry)]:
            yield fold, tested


@dataclass(frozen=True)
class Shapes:
    """The shapes of a benchmark.

    Attributes:
        cache: Folder of the shapes, and of the networks that are trained on them.
        real: Workspace of the real objects.
        procedural: Workspace of the procedural shapes.
    """

    cache: Path
    real: Workspace
    procedural: Workspace


def shapes_parser(description: str | None, quick: str, count: int) -> argparse.ArgumentParser:
    """A parser with the options of benchmarks on real objects; `count` is the default number of procedural shapes a family."""
    parser = option_parser(description, quick)
    parser.add_argument("--data", type=Path, default=REAL_OBJECTS / "GenSim2", help="folder of the real objects")
    parser.add_argument("--cache", type=Path, default=CACHE, help="folder of shapes and networks, which are made once")
    parser.add_argument("--count", type=int, default=count, help="procedural shapes a family")
    parser.add_argument("--folds", type=int, default=5, help="number of folds of the real objects")
    parser.add_argument("--seeds", type=int, default=3, help="number of seeds")
    parser.add_argument("--workers", type=int, default=2, help="number of processes")
    return parser


def gather_shapes(
    data: Path,
    cache: Path,
    count: int,
    mechanisms: int = 0,
    *,
    families: Sequence[str] = (),
    objects: int | None = None,
    workers: int = 1,
) -> Shapes | None:
    """Prepare the real objects, and write and prepare the procedural shapes. What is up to date stays.

    Args:
        data: Folder of the real objects.
        cache: Folder to keep everything in.
        count: Procedural shapes a family.
        mechanisms: Number of procedural shapes without a category.
        families: Families with a category; all if there are none.
        objects: Number of real objects; None for all.
        workers: Number of processes.

    Returns:
        The shapes; None, with a message, if there are no real objects.
    """
    if not has_real_objects(data):
        return None
    observer, real = LineObserver(), Workspace(cache / "real")
    root = data if objects is None else _few(data, cache / "objects", objects)
    Prepare(root, real, workers=workers).run(observer)
    cache = cache / f"{count}-a-family-{mechanisms}-mechanisms"
    folder, procedural = cache / "shapes", Workspace(cache / "procedural")
    categories = tuple(families) or tuple(name for name in family_names() if name != MECHANISM)
    for names, number in ((categories, count), ((MECHANISM,), mechanisms)):
        if number:
            Synth(folder, number, names, (PARTNET_MOBILITY,), ParameterRange.BOTH, seed=SEED, workers=workers).run(observer)
    Prepare(folder, procedural, workers=workers).run(observer)
    return Shapes(cache, real, procedural)


def _few(data: Path, folder: Path, count: int) -> Path:
    """A folder with links to a few of the objects, spread over the folds."""
    found = [source for source in discover(data) if source.layout == PARTNET_MOBILITY]
    found.sort(key=lambda source: hashed_position(source.id, "fold"))
    folder.mkdir(parents=True, exist_ok=True)
    for place in np.linspace(0, len(found) - 1, min(count, len(found))).round().astype(int):
        link = folder / found[place].path.name
        if not link.exists():
            link.symlink_to(found[place].path.absolute())
    return folder


def entries_of(workspace: Workspace) -> list[IndexEntry]:
    """The annotated shapes of a workspace that have joints."""
    return [entry for entry in PreparedStore(workspace.prepared).entries if entry.joint_count]


def load_shapes(workspace: Workspace, entries: Sequence[IndexEntry]) -> list[PreparedShape]:
    """Read some shapes of a workspace."""
    return [PreparedStore(workspace.prepared).load(entry) for entry in entries]


def split_training(entries: Sequence[IndexEntry]) -> tuple[list[IndexEntry], list[IndexEntry]]:
    """Training and validation shapes among shapes of which none is tested."""
    kept = [entry for entry in entries if split_of(entry.id) is Split.VALIDATION]
    return [entry for entry in entries if entry not in kept], kept
