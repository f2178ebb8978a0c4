"""How many objects a second does `prepare` take, with reading, points, boxes, distances, labels and writing?

    python bench/prepare.py [--data DIR] [--workers 2] [--quick]

Without data procedural shapes are written first.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
import time
from collections import Counter
from pathlib import Path

from kinmo.dataset.folder_preparation import PrepareReport, prepare_folder
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers import discover
from kinmo.synth.generate import Layout, generate

GOAL = 8.0
QUICK = 32
DATA = Path(__file__).parents[1] / "data" / "partnet"


def some_of(data: Path, count: int, folder: Path) -> Path:
    """A folder with `count` shapes, evenly spread over those below `data`, by way of hard links."""
    found = list(discover(data))
    for shape in found[:: max(1, len(found) // count)][:count]:
        for file in shape.path.rglob("*"):
            if file.is_file():
                target = folder / shape.path.name / file.relative_to(shape.path)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.hardlink_to(file)
    return folder


def processor_seconds() -> float:
    """What this process and its ended workers have used."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def reasons(report: PrepareReport) -> list[tuple[str, int]]:
    """What was repaired, without the names of bodies and parts, and how often."""
    return Counter(reason.partition(": ")[2] or reason for row in report.repaired for reason in row.reasons).most_common(12)


def main() -> int:
    """Prepare into an empty workspace and print the rate."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} objects only")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.data.parent if args.data.exists() else None, prefix="bench-") as name:
        folder = Path(name)
        data, what = args.data, "real" if args.data == DATA else "given"
        if not data.exists():
            data, what = folder / "synth", "procedural"
            generate(data, count=1 if args.quick else 4, layouts=[Layout.PARTNET_MOBILITY])
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
    total = len(store) + len(report.left_out)
    assert again.made == 0, "nothing is prepared twice"
    print(f"{what} objects         {total:8}")
    print(f"taken                {len(report.taken):8}")
    print(f"repaired             {len(report.repaired):8}")
    for reason, count in reasons(report):
        print(f"  {count:6}  {reason}")
    print(f"left out             {len(report.left_out):8}")
    for row in report.left_out:
        print(f"          {row.reasons[0]}")
    print(f"parts, leaves        {sum(e.part_count for e in store.entries):8} {sum(e.leaf_count for e in store.entries):6}")
    print(f"seconds              {seconds:8.1f}")
    print(f"seconds of processor {processor:8.1f}")
    print(f"seconds, once more   {seconds_again:8.1f}")
    print(f"MB in the store      {size / 1e6:8.1f}")
    claim = {
        "claim": f"prepare, {total} {what} objects, objects/s with {args.workers} workers",
        "ours": total / seconds,
        "peer": None,
    }
    print(json.dumps({**claim, "ratio": total / seconds / GOAL, "goal": GOAL, "met": total / seconds >= GOAL}))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
