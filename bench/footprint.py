"""Memory and time of a command with all its processes.

Memory is the sum of the proportional set sizes of the command and its descendants (shared memory counts once), read every half
second. Linux only. --quick changes nothing: the command decides how long it takes.

Usage:
    python bench/footprint.py --minutes 12 -- kinmo train all --category dishwasher --workspace demo/workspace
    python bench/footprint.py --minutes 20 -- make demo
"""

from __future__ import annotations

import subprocess
import time
from collections import defaultdict
from pathlib import Path

from common import budget_claim, option_parser, print_claims, print_table

INTERVAL = 0.5
"""Seconds between two readings."""
GOAL = 6.0
"""Largest memory, in GiB."""
KIB_PER_GIB = 2**20


def process_tree(root: int) -> list[int]:
    """Ids of a process and of its running descendants."""
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
    """The proportional set size of a process in KiB; 0 for one that has ended."""
    try:
        lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    return sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))


def main() -> int:
    """Run the command, and print its time and memory."""
    parser = option_parser(__doc__, "changes nothing")
    parser.add_argument("--goal", type=float, default=GOAL, help=f"memory to stay below, in GiB (default: {GOAL:g})")
    parser.add_argument("--minutes", type=float, help="time to stay below, in minutes")
    parser.add_argument("command", nargs="+", help="the command and its arguments")
    arguments = parser.parse_args()
    begin = time.monotonic()
    running = subprocess.Popen(arguments.command)
    most = largest = 0
    while running.poll() is None:
        sizes = [kibibytes(process) for process in process_tree(running.pid)]
        most, largest = max(most, sum(sizes)), max(largest, *sizes)
        time.sleep(INTERVAL)
    took = time.monotonic() - begin
    what = " ".join(arguments.command)
    total, one = most / KIB_PER_GIB, largest / KIB_PER_GIB
    print_table(("minutes", "GiB in all processes", "GiB in the largest"), [(took / 60.0, total, one)])
    goals = ((f"minutes of {what}", took / 60.0, arguments.minutes), (f"GiB of {what}", total, arguments.goal))
    print_claims(*(budget_claim(claim, ours, goal) for claim, ours, goal in goals if goal is not None))
    return running.returncode


if __name__ == "__main__":
    raise SystemExit(main())
