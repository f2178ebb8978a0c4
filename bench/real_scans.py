"""Table 2 on real categories: what pseudo labels are worth for partial scans where most labels of real objects are hidden.

    python bench/real_scans.py DATA... --cache DIR [--from WORKSPACE] [--category NAME ...] [--share 0.3]
                                [--seeds 1] [--method kinmo paper] [--config small]

DATA are folders of PartNet-Mobility objects. Of each category, of its objects to train on, `--share` keep their joints; the
others are shown without, as PartNet has them, and their joints are held back for the row with true labels. Objects of all other
categories keep theirs, for the motion networks, which go on from those of `--from` (procedural shapes) if that is given. Cells
are kept in DIR: the same command goes on where it stopped.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from kinmo.cli.console import LineObserver
from kinmo.core.categories import canonical_category, same_category
from kinmo.dataset.splits import Split, split_of, within_share
from kinmo.dataset.workspace import DEFAULT_METHOD, Workspace
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.methods import METHOD_MODELS
from kinmo.pipeline.prepare import Prepare

CATEGORIES = ("laptop", "bucket", "table", "safe", "box")
METHODS = tuple(METHOD_MODELS)
JOINTS = ("mobility_v2.json", "mobility.urdf")


def arrange(data: Iterable[Path], categories: Iterable[str], share: float, folder: Path) -> dict[str, tuple[int, int]]:
    """Copy the objects into `folder`, as labelled, or as unlabelled and held back; returns how many of either, by category."""
    objects = {found.id: found.path for root in data for found in discover(root) if found.layout == PARTNET_MOBILITY}
    category = {name: _category_of(path) for name, path in objects.items()}
    hidden: set[str] = set()
    counts = {}
    for wanted in categories:
        own = sorted(n for n in objects if same_category(category[n], wanted) and split_of(n) is Split.TRAIN)
        kept = within_share([(name, category[name]) for name in own], share)
        hidden |= {name for name, keeps in zip(own, kept, strict=True) if not keeps}
        counts[wanted] = sum(kept), len(own) - sum(kept)
    for name, path in objects.items():
        labelled = folder / "unlabelled" / "held_back" if name in hidden else folder / "labelled"
        _copy(path, labelled / name)
        if name in hidden:
            _copy(path, folder / "unlabelled" / name, without=JOINTS)
    return counts


def _category_of(path: Path) -> str:
    return canonical_category(json.loads((path / "meta.json").read_text(encoding="utf-8"))["model_cat"])


def _copy(source: Path, place: Path, without: Sequence[str] = ()) -> None:
    if not place.exists():
        half = place.with_name(f".{place.name}")
        shutil.rmtree(half, ignore_errors=True)
        shutil.copytree(source, half, ignore=shutil.ignore_patterns(*without), copy_function=_link)
        half.rename(place)


def _link(source: str, place: str) -> None:
    """The same file at another place, or where that is on another disk its copy."""
    try:
        os.link(source, place)
    except OSError:
        shutil.copy2(source, place)


def main() -> None:
    """Arrange, prepare, and make the table of one category after the other."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", nargs="+", type=Path)
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--from", dest="start", type=Path)
    parser.add_argument("--category", nargs="+", choices=CATEGORIES, default=list(CATEGORIES))
    parser.add_argument("--method", nargs="+", choices=METHODS, help="all; with --from, kinmo, as others cannot start from it")
    parser.add_argument("--share", type=float, default=0.3)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--config", default="small")
    parser.add_argument("--hours", type=float)
    parser.add_argument("--quick", action="store_true", help="only arrange and prepare")
    options = parser.parse_args()
    folder = options.cache / f"partnet-{options.share:g}"
    for name, (kept, hidden) in arrange(options.data, CATEGORIES, options.share, folder).items():
        print(f"{name}: {kept} objects to train on with joints, {hidden} without")
    workspace, observer = Workspace(options.cache / f"workspace-{options.share:g}"), LineObserver()
    workers = os.cpu_count() or 1
    Prepare(folder, workspace, workers=workers, hold_back=(folder / "unlabelled" / "held_back",)).run(observer)
    start = None if options.start is None else Workspace(options.start)
    methods = tuple(options.method or (METHODS if start is None else (DEFAULT_METHOD,)))
    if options.quick:
        print(json.dumps(claim(options.category[0], {})))
        return
    for category in options.category:
        table = MakeTable(
            "2", workspace, options.config, methods, category, options.seeds, options.hours, workers=workers, start=start
        )
        outcome = table.run(observer)
        print(outcome.text)
        for name, tables in outcome.data.items():
            place = tables["means"]["columns"].index("rotation (deg)")
            print(json.dumps(claim(name, {row[0]: row[place] for row in tables["means"]["rows"]})))


def claim(category: str, rotations: Mapping[str, float | None]) -> dict[str, Any]:
    """What pseudo labels gain of rotations; those are told by row."""
    ours, peer = rotations.get("semi-weakly"), rotations.get("supervised")
    is_known = ours is not None and peer is not None
    line = {"claim": f"rotation of {category}, pseudo labels beside few labels alone, degrees", "ours": ours, "peer": peer}
    return line | {"ratio": peer / ours if is_known else None, "goal": 1.0, "met": ours < peer if is_known else None}


if __name__ == "__main__":
    main()
