"""Objects a second of `kinmo prepare`: reading, points, boxes, distances, features, labels and writing.

Without real objects procedural shapes are written first.

Usage:
    python bench/prepare.py [--data DIR] [--workers 2] [--quick]
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections import Counter
from pathlib import Path

from common import REAL_OBJECTS, option_parser, print_claims, print_table, rate_claim
from kinmo.dataset.folder_preparation import PreparationReport, prepare_folder
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.synth.generate import shape_specs, write_shapes

GOAL = 8.0
"""Objects a second."""
QUICK = 32


def some_of(data: Path, count: int, folder: Path) -> Path:
    """Fill a folder with `count` shapes, spread evenly over those below `data`, as hard links."""
    found = list(discover(data))
    for shape in found[:: max(1, len(found) // count)][:count]:
        for file in shape.path.rglob("*"):
            if file.is_file():
                target = folder / shape.path.name / file.relative_to(shape.path)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.hardlink_to(file)
    return folder


def processor_seconds() -> float:
    """Processor time of this process and of its ended workers."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def repairs(report: PreparationReport) -> list[tuple[str, int]]:
    """Repairs by frequency, without the names of bodies and parts."""
    return Counter(reason.partition(": ")[2] or reason for row in report.repaired for reason in row.reasons).most_common(12)


def main() -> int:
    """Prepare into an empty workspace and print the rate."""
    parser = option_parser(__doc__, f"{QUICK} objects only")
    parser.add_argument("--data", type=Path, default=REAL_OBJECTS, help="folder of the objects")
    parser.add_argument("--workers", type=int, default=2, help="number of processes")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.data.parent if args.data.exists() else None, prefix="bench-") as name:
        folder = Path(name)
        data, what = args.data, "real" if args.data == REAL_OBJECTS else "given"
        if not data.exists():
            data, what = folder / "synth", "procedural"
            write_shapes(data, shape_specs(1 if args.quick else 4, layouts=(PARTNET_MOBILITY,)), workers=args.workers)
        elif args.quick:
            data = some_of(data, QUICK, folder / "some")
        begin = time.perf_counter()
        report = prepare_folder(data, Workspace(folder / "workspace"), workers=args.workers)
        seconds, processor = time.perf_counter() - begin, processor_seconds()
        store = PreparedStore(folder / "workspace" / "prepared")
        begin = time.perf_counter()
        again = prepare_folder(data, Workspace(folder / "workspace"), workers=args.workers)
        seconds_again = time.perf_counter() - begin
        size = sum((store.folder / entry.file).stat().st_size for entry in store.entries)
    total = len(store) + len(report.skipped)
    assert again.new == 0, "nothing is prepared twice"
    for row in report.skipped:
        print(f"skipped: {row.reasons[0]}")
    print_table(("repair", "shapes"), repairs(report))
    rows = {
        f"{what} objects": total,
        "repaired": len(report.repaired),
        "skipped": len(report.skipped),
        "parts": sum(entry.part_count for entry in store.entries),
        "leaf parts": sum(entry.leaf_count for entry in store.entries),
        "seconds": seconds,
        "seconds of processor time": processor,
        "seconds, second run": seconds_again,
        "MB in the store": size / 1e6,
    }
    print_table(("", ""), list(rows.items()))
    print_claims(rate_claim(f"prepare, {total} {what} objects, objects/s with {args.workers} workers", total / seconds, GOAL))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
