"""A process that divides surfaces into convex pieces by CoACD. `kinmo.robot.coacd_pieces` starts it.

It runs by itself, without kinmo: CoACD crashes on some surfaces and takes minutes for others. A signal ends the process when a
surface takes more processor time than it may. It leaves out surfaces for which all of its time is spent.

Usage:
    python coacd_process.py FOLDER SECONDS_EACH SECONDS_ALL NUMBER...
"""

import os
import signal
import sys
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"  # more threads wait for each other most of the time

import coacd
import numpy as np

SETTINGS = {
    "threshold": 0.1,
    "preprocess_resolution": 20,
    "resolution": 200,
    "mcts_iterations": 10,
    "mcts_nodes": 6,
    "mcts_max_depth": 1,
    "max_convex_hull": 16,
    "seed": 0,
}
"""Settings of CoACD: a coarser and shorter search than its own, which takes minutes for some parts."""


def divide(source: Path, target: Path) -> None:
    """Divide the surface in a file `source` (arrays vertices [V, 3] and faces [F, 3]).

    The file `target` gets the corners of all pieces one after the other, and the number of corners of each.
    """
    with np.load(source) as surface:
        found = coacd.run_coacd(coacd.Mesh(surface["vertices"], surface["faces"]), **SETTINGS)
    points = [np.asarray(vertices, np.float64) for vertices, _ in found]
    draft = target.with_suffix(".draft.npz")
    np.savez(draft, points=np.concatenate(points), counts=[len(each) for each in points])
    draft.replace(target)


def main() -> None:
    """Divide some surfaces of a folder."""
    coacd.set_log_level("off")
    folder, seconds, all_seconds = Path(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
    for number in sys.argv[4:]:
        if time.process_time() > all_seconds:
            return
        signal.setitimer(signal.ITIMER_PROF, seconds)  # its signal ends the process, in the middle of CoACD too
        divide(folder / f"{number}.npz", folder / f"{number}.pieces.npz")


if __name__ == "__main__":
    main()
