"""How much memory, and time, does a command take, with all processes that work for it?

    python bench/footprint.py --minutes 12 -- kinmo train all --category dishwasher --workspace demo/workspace
    python bench/footprint.py --minutes 20 -- make demo

Every half second the proportional set sizes (what processes share counts once) of the command and its descendants are added up.
Linux only. How long it takes is up to the command: there is no `--quick`.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import time
from collections import defaultdict
from pathlib import Path

EVERY = 0.5
GOAL = 6.0
"""GiB."""
KIB_PER_GIB = 2**20


def family(root: int) -> list[int]:
    """A process and its descendants, as far as they are there."""
    children: dict[int, list[int]] = defaultdict(list)
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            after_name = (folder / "stat").read_text().rpartition(")")[2].split()
            children[int(after_name[1])].append(int(folder.name))
        except (OSError, IndexError, ValueError):  # it has just ended
            continue
    found = [root]
    for process in found:
        found += children[process]
    return found


def kibibytes(process: int) -> int:
    """The proportional set size of a process; none of one that has ended."""
    try:
        lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    return sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))


def main() -> int:
    """Run the command and print what it took."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--goal", type=float, default=GOAL, help="GiB")
    parser.add_argument("--minutes", type=float, help="within which it should be done")
    parser.add_argument("command", nargs="+")
    arguments = parser.parse_args()
    begin = time.monotonic()
    running = subprocess.Popen(arguments.command)
    most = largest = 0
    while running.poll() is None:
        sizes = [kibibytes(process) for process in family(running.pid)]
        most, largest = max(most, sum(sizes)), max(largest, *sizes)
        time.sleep(EVERY)
    took = time.monotonic() - begin
    minutes, seconds = divmod(round(took), 60)
    what = " ".join(arguments.command)
    total, one = most / KIB_PER_GIB, largest / KIB_PER_GIB
    print(f"{what}: {minutes} min {seconds} s, {total:.2f} GiB in all processes at once, {one:.2f} GiB in the largest")
    for unit, ours, goal in (("minutes", took / 60.0, arguments.minutes), ("GiB", total, arguments.goal)):
        if goal is not None:
            claim = {"claim": f"{unit} of {what}", "ours": ours, "peer": goal, "ratio": goal / ours}
            print(json.dumps({**claim, "goal": 1.0, "met": ours <= goal}))
    return running.returncode


if __name__ == "__main__":
    raise SystemExit(main())
