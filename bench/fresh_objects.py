"""Table 2 on other test objects: made with another seed, as many of the labelled range of proportions as of the other one.

    python bench/fresh_objects.py WORKSPACE --category refrigerator --cache DIR [--count 60] [--seed 1000] [--quick]

The networks are those that the workspace has of the category, and were neither trained nor chosen on these objects, nor was
anything else. `--count` objects of each range are made and scanned; those with the joints that networks know are judged. All is
kept in DIR: the same command goes on where it stopped.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import torch

from kinmo.cli.console import LineObserver
from kinmo.config import load_config
from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.typed_tables import to_table
from kinmo.dataset.workers import Crashed, map_unordered
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.scan_records import read_scores, write_scores
from kinmo.evaluation.tables import Caption, as_text
from kinmo.experiments.scan_tables.scan_summary import change
from kinmo.experiments.scan_tables.scan_table_layout import ScanRow, over_parts
from kinmo.io.readers import discover
from kinmo.learning.model_folder import networks_digest
from kinmo.pipeline.scans.evaluate_scans import judged
from kinmo.pipeline.scans.render_jobs import Job, Rendering
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_networks import trained_by_all_methods
from kinmo.pipeline.scans.training_settings import by_method
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import open_scans
from kinmo.synth.draw import ParameterRange
from kinmo.synth.synth_stage import Synth

RANGES = (ParameterRange.LABELLED, ParameterRange.UNLABELLED)
LAYOUT = "partnet_mobility"
LEAST = "supervised"
QUICK = 6


@dataclass(frozen=True)
class Trained:
    """The networks of a seed, and what they learnt from: a setting, with the method whose labels they saw."""

    title: str
    seed: int
    weights: tuple[Path, Path]


@dataclass(frozen=True)
class Judging:
    """Judges the networks of a cell on scans, in whatever process."""

    scans: tuple[Path, ...]
    folder: Path

    def scores(self, trained: Trained) -> Path:
        """Of these very weights."""
        return self.folder / f"{networks_digest(trained.weights)}-{trained.seed}.jsonl"

    def __call__(self, trained: Trained) -> None:
        torch.set_num_threads(1)
        network = Ancsh.load(*trained.weights, device="cpu")
        files = map(open_scans, self.scans)
        scores = [(file.id, frame.score) for file in files for frame in judged(file, network, trained.seed)]
        self.folder.mkdir(parents=True, exist_ok=True)
        write_scores(self.scores(trained), scores)


def main() -> None:
    """Make, scan and judge, and print a table of all objects, and one of either range."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--category", default="refrigerator")
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--count", type=int, default=60, help="of objects of each range, whatever joints they have")
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} objects of each range")
    options = parser.parse_args()
    count = QUICK if options.quick else options.count
    workspace = Workspace(options.workspace)
    dataset = open_scan_dataset(workspace, options.category)
    trained = [
        Trained(by_method(cell.setting, place.method), cell.seed, weights)
        for place, cell in trained_by_all_methods(workspace)
        if same_category(cell.category, dataset.category) and (weights := cell.weights(place))
    ]
    place = options.cache / f"{dataset.category}-{options.seed}-{count}"
    judgings = []
    for parameter_range in RANGES:
        folder = place / parameter_range.value
        scans = scanned(folder, options.category, count, options.seed, parameter_range, dataset.structure)
        judgings.append(Judging(scans, folder / "scores"))
        todo = [each for each in trained if not judgings[-1].scores(each).exists()]
        for own, found in map_unordered(judgings[-1], todo, os.cpu_count() or 1):
            if isinstance(found, Crashed):
                raise ChildProcessError(f"the process that judged {own.title}, seed {own.seed}, died")
    for name, some in (("both ranges", judgings), *((each.value, [own]) for each, own in zip(RANGES, judgings, strict=True))):
        print(table(f"{dataset.category}, {name}, seed {options.seed}", some, trained, dataset.structure), flush=True)
    for least, row in compared(judgings, trained):
        (turn, *_) = change(least.objects, row.objects, dataset.structure)
        assert turn is not None
        claim = f"rotations in scans of other {dataset.category}: {row.name} against {least.name}, degrees"
        figures = {"ours": turn.value, "peer": 0.0, "ratio": None, "goal": 0.0, "met": turn.value < 0.0}
        print(json.dumps({"claim": claim} | figures))


def scanned(
    folder: Path, family: str, count: int, seed: int, parameter_range: ParameterRange, structure: Structure
) -> tuple[Path, ...]:
    """Scans of the objects with this structure, one file each."""
    shapes, workers = folder / "shapes", os.cpu_count() or 1
    Synth(shapes, count, (family,), (LAYOUT,), parameter_range, seed=seed, workers=workers).run(LineObserver())
    config = load_config("small").scans
    rendering = Rendering(config, seed)
    jobs = []
    for found in discover(shapes):
        path = folder / "scans" / f"{found.id}.safetensors"
        made_from = digest([found.id, to_table(config), seed])
        jobs.append(Job(found, family, "test", found.layout.value, path, made_from, wanted=structure))
    for (job,), problem in map_unordered(rendering, [(job,) for job in jobs if not job.is_done], workers):
        if problem is not None:
            raise ValueError(f"{job.found.path}: {problem}")
    files = [open_scans(job.path) for job in jobs if job.path.exists()]
    return tuple(file.path for file in files if file.frames)


def row_of(title: str, judgings: Sequence[Judging], trained: Sequence[Trained]) -> ScanRow:
    """All networks of a title."""
    own = [each for each in trained if each.title == title]
    objects = read_scores([judging.scores(each) for judging in judgings for each in own])
    return ScanRow(title, tuple(objects), seeds=tuple(each.seed for each in own))


def compared(judgings: Sequence[Judging], trained: Sequence[Trained]) -> list[tuple[ScanRow, ScanRow]]:
    """Every other row beside those of the labelled objects alone, over the seeds that both have."""
    others = [row_of(title, judgings, trained) for title in titles(trained) if title != LEAST]
    return [(row_of(LEAST, judgings, [each for each in trained if each.seed in row.seeds]), row) for row in others]


def titles(trained: Sequence[Trained]) -> list[str]:
    """Without repetitions."""
    return list(dict.fromkeys(each.title for each in trained))


def table(what: str, judgings: Sequence[Judging], trained: Sequence[Trained], structure: Structure) -> str:
    """Means of every row, and what the others are above that of the labelled objects alone."""
    seeds = tuple(sorted({each.seed for each in trained}))
    caption = Caption(what, "procedural objects made for this alone", 0, 0, "all of them", seeds)
    rows = [row_of(title, judgings, trained) for title in titles(trained)]
    return as_text(over_parts(rows, structure, caption, compared(judgings, trained)))


if __name__ == "__main__":
    main()
