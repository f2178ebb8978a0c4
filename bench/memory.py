"""Does the memory of `prepare` stay flat in the number of shapes?

    python bench/memory.py [--shapes 10000] [--workers 1] [--family NAME ...] [--quick]

Procedural shapes in the layouts of PartNet-Mobility and PartNet are prepared, by default of families with few and small parts,
so that 10,000 of them take minutes; the memory of the process that holds the index (and of the largest worker) is read as it
goes.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import tempfile
import time
from pathlib import Path

from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.workspace import Workspace
from kinmo.synth.generate import Layout, generate

SHAPES = 10_000
FAMILIES = ("knife", "lighter", "mouse", "trash_can", "usb")
QUICK = 300
GOAL = 1.25
"""At most so much more at the end than at a tenth of the way."""
PAGE = os.sysconf("SC_PAGE_SIZE")


def resident() -> float:
    """Resident memory of this process in MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE / 1e6


def main() -> int:
    """Prepare and print memory at every tenth."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", type=int, default=SHAPES)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--family", action="append", help=f"may be repeated (default: {', '.join(FAMILIES)})")
    parser.add_argument("--data", type=Path, help="where the shapes are, or are to be written (default: a temporary folder)")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} shapes")
    args = parser.parse_args()
    shapes = QUICK if args.quick else args.shapes
    seen: dict[int, float] = {}
    with tempfile.TemporaryDirectory(prefix="memory-") as name:
        data = args.data or Path(name) / "shapes"
        families = args.family or FAMILIES
        per_family = -(-shapes // (2 * len(families)))
        layouts = [Layout.PARTNET_MOBILITY, Layout.PARTNET]
        generate(data, count=per_family, families=families, layouts=layouts, workers=args.workers)

        def note(done: int, total: int, _: str) -> None:
            tenth = done * 10 // total
            if tenth and tenth not in seen:
                seen[tenth] = resident()
                print(f"{done:7} shapes  {seen[tenth]:7.1f} MB", flush=True)

        begin = time.perf_counter()
        report = prepare_folder(data, Workspace(Path(name) / "workspace"), workers=args.workers, on_progress=note)
        seconds = time.perf_counter() - begin
    total = len(report.taken) + len(report.repaired) + len(report.left_out)
    worker = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3
    print(f"{total:7} shapes in {seconds:.0f} s ({total / seconds:.1f} a second), {len(report.left_out)} left out")
    print(f"largest worker: {worker:.1f} MB")
    claim = {"claim": f"prepare, {total} shapes: MB at the end and at a tenth", "ours": seen[10], "peer": seen[1]}
    print(json.dumps({**claim, "ratio": seen[10] / seen[1], "goal": GOAL, "met": seen[10] <= GOAL * seen[1]}))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
