"""What the benches on real objects train and test on: the real objects in folds, and procedural shapes to start from."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.splits import Split, fold_of, is_validation_in_fold, split_of
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import PreparedShape
from kinmo.synth.draw import ParameterRange
from kinmo.synth.families import family_names
from kinmo.synth.generate import Layout, generate

ROOT = Path(__file__).parents[1]
MECHANISM = "mechanism"
SEED, ANOTHER_SEED = 11, 2026
Fold = tuple[str, list[PreparedShape], list[PreparedShape], list[PreparedShape]]
"""A name, and the shapes to train on, to choose the epoch by, and to test."""


@dataclass(frozen=True)
class Shapes:
    """The shapes, and the folder that keeps them and the networks that are trained on them.

    `mechanisms` are of no category: they join the training where what is tested is of categories that were never seen. `fresh`
    are procedural shapes of another seed, which are never trained on.
    """

    cache: Path
    real: list[PreparedShape]
    procedural: list[PreparedShape]
    mechanisms: list[PreparedShape]
    folds: int
    fresh: Sequence[PreparedShape] = ()

    def by_fold(self) -> Iterator[Fold]:
        """Every real object is tested once."""
        for fold in range(self.folds):
            others = [shape for shape in self.real if fold_of(shape.id, self.folds) != fold]
            tested = [shape for shape in self.real if fold_of(shape.id, self.folds) == fold]
            yield (f"fold{fold}", *_parted(others, fold, self.folds), tested)

    def by_category(self) -> Iterator[Fold]:
        """Every real object is tested once, none together with others of its category to train on."""
        for fold in range(self.folds):
            others = [shape for shape in self.real if fold_of(shape.category, self.folds) != fold]
            tested = [shape for shape in self.real if fold_of(shape.category, self.folds) == fold]
            yield (f"categories{fold}", *_parted(others, self.folds, self.folds), tested)

    def by_half(self) -> Iterator[Fold]:
        """Either half of the families: no real shapes to train on, and its procedural test shapes to test with."""
        for half in range(2):
            tested = [shape for shape in self.procedural if fold_of(shape.category, 2) == half]
            yield f"families{half}", [], [], [shape for shape in tested if split_of(shape.id) is Split.TEST]

    def of_seen_families(self) -> tuple[list[PreparedShape], list[PreparedShape], list[PreparedShape]]:
        """Procedural shapes of all families to train on, to choose the epoch by, and to test with."""
        training, validation, tested = (
            [shape for shape in self.procedural if split_of(shape.id) is split]
            for split in (Split.TRAIN, Split.VALIDATION, Split.TEST)
        )
        return training, validation, tested


def parser_for(description: str | None, count: int) -> argparse.ArgumentParser:
    """The options of such a bench; `count` procedural shapes a family are the default."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=ROOT / "data" / "partnet" / "gensim2")
    parser.add_argument("--cache", type=Path, default=ROOT / "workspace" / "bench")
    parser.add_argument("--count", type=int, default=count, help="procedural shapes a family")
    parser.add_argument("--folds", type=int, default=5)
    return parser


def gathered(data: Path, cache: Path, count: int, folds: int, mechanisms: int = 0, fresh: int = 0) -> Shapes | None:
    """The real objects below `data`, `count` procedural shapes a family and `mechanisms` of no category, all kept in `cache`.

    `fresh` shapes a family come from another seed. None, which is said, where there are no real ones.
    """
    if not data.exists():
        print(f"no real objects at {data}: docs/getting-the-data.md says where they come from")
        return None
    cache = cache / f"{count}-a-family"
    categories = [name for name in family_names() if name != MECHANISM]
    procedural = procedural_shapes(cache / "shapes", cache / "procedural", categories, count)
    of_no_category = procedural_shapes(cache / "mechanism-shapes", cache / "mechanisms", [MECHANISM], mechanisms)
    others = procedural_shapes(cache / "fresh-shapes", cache / "fresh", categories, fresh, ANOTHER_SEED)
    return Shapes(cache, prepared(data, cache / "real"), procedural, of_no_category, folds, others)


def procedural_shapes(shapes: Path, cache: Path, families: Sequence[str], count: int, seed: int = SEED) -> list[PreparedShape]:
    """`count` shapes of each family, of both parameter ranges, written to `shapes` and prepared in `cache`."""
    if count == 0:
        return []
    only, both = (Layout.PARTNET_MOBILITY,), ParameterRange.BOTH
    generate(shapes, count=count, families=families, layouts=only, seed=seed, parameter_range=both, workers=2)
    return prepared(shapes, cache)


def prepared(folder: Path, cache: Path) -> list[PreparedShape]:
    """The labelled shapes below a folder, with joints."""
    workspace = Workspace(cache)
    prepare_folder(folder, workspace, workers=2)
    store = PreparedStore(workspace.prepared)
    return [store.load(entry) for entry in store.entries if entry.joint_count]


def parted_by_split(shapes: Sequence[PreparedShape]) -> tuple[list[PreparedShape], list[PreparedShape]]:
    """Procedural shapes to train on, and those to choose the epoch by."""
    kept = [shape for shape in shapes if split_of(shape.id) is Split.VALIDATION]
    return [shape for shape in shapes if split_of(shape.id) is not Split.VALIDATION], kept


def _parted(shapes: Sequence[PreparedShape], fold: int, folds: int) -> tuple[list[PreparedShape], list[PreparedShape]]:
    """Shapes to train on, and those to choose the epoch by."""
    kept = {shape.id for shape in shapes if is_validation_in_fold(shape.id, fold, folds)}
    return [shape for shape in shapes if shape.id not in kept], [shape for shape in shapes if shape.id in kept]
