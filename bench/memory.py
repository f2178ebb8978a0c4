"""Memory of `kinmo prepare` as the number of shapes grows: it should stay flat.

Procedural shapes in the layouts of PartNet-Mobility and PartNet are prepared. Default families have few and small parts, so
10,000 shapes take minutes. The memory of the process with the index is read during the run, that of
the largest worker after it.

Usage:
    python bench/memory.py [--shapes 10000] [--workers 1] [--family NAME ...] [--quick]
"""

from __future__ import annotations

import os
import resource
import tempfile
import time
from pathlib import Path

from common import option_parser, print_claims
from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers import PARTNET, PARTNET_MOBILITY
from kinmo.synth.generate import shape_specs, write_shapes

SHAPES = 10_000
FAMILIES = ("knife", "lighter", "mouse", "trash_can", "usb")
QUICK = 300
GOAL = 1.25
"""Largest ratio of the memory at the end to that after a tenth of the shapes."""
PAGE = os.sysconf("SC_PAGE_SIZE")


def resident() -> float:
    """Resident memory of this process in MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE / 1e6


def main() -> int:
    """Prepare, and print the memory after every tenth of the shapes."""
    parser = option_parser(__doc__, f"{QUICK} shapes")
    parser.add_argument("--shapes", type=int, default=SHAPES, help="number of shapes")
    parser.add_argument("--workers", type=int, default=1, help="number of processes")
    parser.add_argument("--family", action="append", help=f"family of shapes, repeatable (default: {', '.join(FAMILIES)})")
    parser.add_argument("--data", type=Path, help="folder to write the shapes to (default: a temporary one)")
    args = parser.parse_args()
    shapes = QUICK if args.quick else args.shapes
    seen: dict[int, float] = {}
    with tempfile.TemporaryDirectory(prefix="memory-") as name:
        data = args.data or Path(name) / "shapes"
        families = args.family or FAMILIES
        per_family = -(-shapes // (2 * len(families)))
        specs = shape_specs(per_family, families=families, layouts=(PARTNET_MOBILITY, PARTNET))
        write_shapes(data, specs, workers=args.workers)

        def note(done: int, total: int, _: str) -> None:
            tenth = done * 10 // total
            if tenth and tenth not in seen:
                seen[tenth] = resident()
                print(f"{done:7} shapes  {seen[tenth]:7.1f} MB", flush=True)

        begin = time.perf_counter()
        report = prepare_folder(data, Workspace(Path(name) / "workspace"), workers=args.workers, on_progress=note)
        seconds = time.perf_counter() - begin
    total = len(report.included) + len(report.repaired) + len(report.skipped)
    worker = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3
    print(f"{total:7} shapes in {seconds:.0f} s ({total / seconds:.1f} a second), {len(report.skipped)} skipped")
    print(f"largest worker: {worker:.1f} MB")
    claim = {"claim": f"prepare, {total} shapes: MB at the end and after a tenth", "ours": seen[10], "peer": seen[1]}
    print_claims({**claim, "ratio": seen[10] / seen[1], "goal": GOAL, "met": seen[10] <= GOAL * seen[1]})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
