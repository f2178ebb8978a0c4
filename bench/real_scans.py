"""Table 2 on real categories: the gain by pseudo labels for partial scans, if most real labels are hidden.

DATA are folders of PartNet-Mobility objects. In each category, `--share` of the training objects keep their joints. The others
are written without joints, as in PartNet; their joints are oracle labels for the row with true labels. Objects of all other
categories keep their joints for the motion networks, which continue from those of `--from` (procedural shapes) if given. All
results are kept in the cache, and the same command resumes.

Usage:
    python bench/real_scans.py DATA... --cache DIR [--from WORKSPACE] [--category NAME ...] [--share 0.3]
                               [--seeds 1] [--method kinmo paper] [--config small] [--hours N] [--quick]
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from common import Claim, option_parser, print_claims
from kinmo.cli.console import LineObserver
from kinmo.core.categories import canonical_category, same_category
from kinmo.dataset.folder_preparation import ORACLE
from kinmo.dataset.splits import Split, hashed_position, split_of
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.methods import DEFAULT_METHOD, METHOD_MODELS
from kinmo.pipeline.prepare_shapes import Prepare

CATEGORIES = ("laptop", "bucket", "table", "safe", "box")
METHODS = tuple(METHOD_MODELS)
JOINTS = ("mobility_v2.json", "mobility.urdf")


def arrange(data: Iterable[Path], categories: Iterable[str], share: float, folder: Path) -> dict[str, tuple[int, int]]:
    """Copy the objects into `folder`, as labelled, or as unlabelled with oracle labels. Returns both numbers by category."""
    objects = {found.id: found.path for root in data for found in discover(root) if found.layout == PARTNET_MOBILITY}
    category = {name: _category_of(path) for name, path in objects.items()}
    hidden: set[str] = set()
    counts = {}
    for wanted in categories:
        own = sorted(n for n in objects if same_category(category[n], wanted) and split_of(n) is Split.TRAIN)
        kept = set(sorted(own, key=lambda name: hashed_position(name, "share"))[: max(1, round(share * len(own)))])
        hidden |= set(own) - kept
        counts[wanted] = len(kept), len(own) - len(kept)
    for name, path in objects.items():
        labelled = folder / "unlabelled" / ORACLE if name in hidden else folder / "labelled"
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
    """Make a hard link, or a copy on another disk."""
    try:
        os.link(source, place)
    except OSError:
        shutil.copy2(source, place)


def main() -> None:
    """Arrange and prepare the objects, and make the table of each category."""
    parser = option_parser(__doc__, "arrange and prepare only")
    parser.add_argument("data", nargs="+", type=Path, help="folders of real objects")
    parser.add_argument("--cache", type=Path, required=True, help="folder of all results")
    parser.add_argument("--from", dest="start", type=Path, help="workspace whose motion networks to continue")
    parser.add_argument("--category", nargs="+", choices=CATEGORIES, default=list(CATEGORIES), help="categories (default: all)")
    parser.add_argument(
        "--method", nargs="+", choices=METHODS, help="methods of pseudo labels (default: all; with --from, kinmo)"
    )
    parser.add_argument("--share", type=float, default=0.3, help="share of objects that keep their joints")
    parser.add_argument("--seeds", type=int, default=1, help="number of seeds")
    parser.add_argument("--config", default="small", help="configuration of the networks")
    parser.add_argument("--hours", type=float, help="stop after this many hours")
    options = parser.parse_args()
    folder = options.cache / f"partnet-{options.share:g}"
    for name, (kept, hidden) in arrange(options.data, CATEGORIES, options.share, folder).items():
        print(f"{name}: {kept} training objects with joints, {hidden} without")
    workspace, observer = Workspace(options.cache / f"workspace-{options.share:g}"), LineObserver()
    workers = os.cpu_count() or 1
    Prepare(folder, workspace, workers=workers, oracle=(folder / "unlabelled" / ORACLE,)).run(observer)
    start = None if options.start is None else Workspace(options.start)
    methods = tuple(options.method or (METHODS if start is None else (DEFAULT_METHOD,)))
    if options.quick:
        print_claims(claim(options.category[0], {}))
        return
    claims = []
    for category in options.category:
        table = MakeTable(
            "2", workspace, options.config, methods, category, options.seeds, options.hours, workers=workers, start=start
        )
        outcome = table.run(observer)
        print(outcome.text)
        for name, tables in outcome.data.items():
            place = tables["means"]["columns"].index("rotation (deg)")
            claims.append(claim(name, {row[0]: row[place] for row in tables["means"]["rows"]}))
    print_claims(*claims)


def claim(category: str, rotations: Mapping[str, float | None]) -> Claim:
    """The claim that pseudo labels reduce the rotation error; `rotations` are by row of the table."""
    ours, peer = rotations.get("semi-weakly"), rotations.get("supervised")
    is_known = ours is not None and peer is not None
    line = {
        "claim": f"rotation error of {category} with pseudo labels compared with few labels alone, degrees",
        "ours": ours,
        "peer": peer,
    }
    return line | {"ratio": peer / ours if is_known else None, "goal": 1.0, "met": ours < peer if is_known else None}


if __name__ == "__main__":
    main()
