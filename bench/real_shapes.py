"""Data of the benchmarks on real objects: the real objects in folds, and procedural shapes for pre-training."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from common import CACHE, REAL_OBJECTS, has_real_objects, option_parser
from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.splits import Split, fold_of, is_validation_in_fold, split_of
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import PreparedShape
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.synth.draw import ParameterRange
from kinmo.synth.families import family_names
from kinmo.synth.generate import shape_specs, write_shapes

MECHANISM = "mechanism"
"""Family of shapes without a category."""
SEED, ANOTHER_SEED = 11, 2026
Fold = tuple[str, list[PreparedShape], list[PreparedShape], list[PreparedShape]]
"""Name, training shapes, validation shapes and test shapes."""


@dataclass(frozen=True)
class Shapes:
    """The shapes of a benchmark.

    Attributes:
        cache: Folder of the shapes and of the networks that are trained on them.
        real: The real objects.
        procedural: Procedural shapes of all categories.
        mechanisms: Procedural shapes without a category. They join the training for tests on unseen categories.
        folds: Number of folds.
        fresh: Procedural shapes of another seed, for tests only.
    """

    cache: Path
    real: list[PreparedShape]
    procedural: list[PreparedShape]
    mechanisms: list[PreparedShape]
    folds: int
    fresh: Sequence[PreparedShape] = ()

    def by_fold(self) -> Iterator[Fold]:
        """Folds of the real objects. Every object is tested once."""
        for fold in range(self.folds):
            others = [shape for shape in self.real if fold_of(shape.id, self.folds) != fold]
            tested = [shape for shape in self.real if fold_of(shape.id, self.folds) == fold]
            yield (f"fold{fold}", *_split_fold(others, fold, self.folds), tested)

    def by_category(self) -> Iterator[Fold]:
        """Folds of whole categories. Every real object is tested once, and none of its category is in training."""
        for fold in range(self.folds):
            others = [shape for shape in self.real if fold_of(shape.category, self.folds) != fold]
            tested = [shape for shape in self.real if fold_of(shape.category, self.folds) == fold]
            yield (f"categories{fold}", *_split_fold(others, self.folds, self.folds), tested)

    def by_half(self) -> Iterator[Fold]:
        """Two halves of the procedural families: no real training shapes, and the procedural test shapes of the half."""
        for half in range(2):
            tested = [shape for shape in self.procedural if fold_of(shape.category, 2) == half]
            yield f"families{half}", [], [], [shape for shape in tested if split_of(shape.id) is Split.TEST]

    def of_seen_families(self) -> tuple[list[PreparedShape], list[PreparedShape], list[PreparedShape]]:
        """Procedural shapes of all families: training, validation and test."""
        training, validation, tested = (
            [shape for shape in self.procedural if split_of(shape.id) is split]
            for split in (Split.TRAIN, Split.VALIDATION, Split.TEST)
        )
        return training, validation, tested


def shapes_parser(description: str | None, quick: str, count: int) -> argparse.ArgumentParser:
    """A parser with the options of benchmarks on real objects; `count` is the default number of procedural shapes a family."""
    parser = option_parser(description, quick)
    parser.add_argument("--data", type=Path, default=REAL_OBJECTS / "GenSim2", help="folder of the real objects")
    parser.add_argument("--cache", type=Path, default=CACHE, help="folder of shapes and networks, which are made once")
    parser.add_argument("--count", type=int, default=count, help="procedural shapes a family")
    parser.add_argument("--folds", type=int, default=5, help="number of folds of the real objects")
    return parser


def gather_shapes(data: Path, cache: Path, count: int, folds: int, mechanisms: int = 0, fresh: int = 0) -> Shapes | None:
    """Read the real objects and write the procedural shapes.

    Args:
        data: Folder of the real objects.
        cache: Folder to keep all shapes in.
        count: Procedural shapes a family.
        folds: Number of folds.
        mechanisms: Number of shapes without a category.
        fresh: Procedural shapes a family with another seed.

    Returns:
        The shapes; None, with a message, if there are no real objects.
    """
    if not has_real_objects(data):
        return None
    cache = cache / f"{count}-a-family"
    categories = [name for name in family_names() if name != MECHANISM]
    procedural = procedural_shapes(cache / "shapes", cache / "procedural", categories, count)
    of_no_category = procedural_shapes(cache / "mechanism-shapes", cache / "mechanisms", [MECHANISM], mechanisms)
    others = procedural_shapes(cache / "fresh-shapes", cache / "fresh", categories, fresh, ANOTHER_SEED)
    return Shapes(cache, prepared(data, cache / "real"), procedural, of_no_category, folds, others)


def procedural_shapes(shapes: Path, cache: Path, families: Sequence[str], count: int, seed: int = SEED) -> list[PreparedShape]:
    """`count` shapes a family, of both parameter ranges, written to `shapes` and prepared in `cache`."""
    if count == 0:
        return []
    layouts, both = (PARTNET_MOBILITY,), ParameterRange.BOTH
    write_shapes(shapes, shape_specs(count, families=families, layouts=layouts, seed=seed, parameter_range=both), workers=2)
    return prepared(shapes, cache)


def prepared(folder: Path, cache: Path) -> list[PreparedShape]:
    """The annotated shapes below a folder that have joints, prepared in `cache`."""
    workspace = Workspace(cache)
    prepare_folder(folder, workspace, workers=2)
    store = PreparedStore(workspace.prepared)
    return [store.load(entry) for entry in store.entries if entry.joint_count]


def split_procedural(shapes: Sequence[PreparedShape]) -> tuple[list[PreparedShape], list[PreparedShape]]:
    """Training and validation shapes of procedural shapes."""
    kept = [shape for shape in shapes if split_of(shape.id) is Split.VALIDATION]
    return [shape for shape in shapes if split_of(shape.id) is not Split.VALIDATION], kept


def _split_fold(shapes: Sequence[PreparedShape], fold: int, folds: int) -> tuple[list[PreparedShape], list[PreparedShape]]:
    """Training and validation shapes of a fold."""
    kept = {shape.id for shape in shapes if is_validation_in_fold(shape.id, fold, folds)}
    return [shape for shape in shapes if shape.id not in kept], [shape for shape in shapes if shape.id in kept]
