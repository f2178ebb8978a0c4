"""A process that divides surfaces into convex pieces by CoACD. `kinmo.robot.coacd_pieces` starts it.

It runs by itself, without kinmo: CoACD crashes on some surfaces and takes minutes for others. A signal ends the process when a
surface takes more processor time than it may. It leaves out surfaces for which all of its time is spent.

It makes a file NUMBER.started before CoACD gets surface NUMBER. It exits with `CANNOT_DIVIDE` if CoACD raises an error about a
surface, and with another code if anything else fails, such as the import of CoACD or the disk.

Usage:
    python coacd_process.py FOLDER SECONDS_EACH SECONDS_ALL NUMBER...
"""

import signal
import sys
import time
from pathlib import Path

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
CANNOT_DIVIDE = 3
"""Exit code if CoACD raised an error about a surface."""


def divide(source: Path, target: Path) -> None:
    """Divide the surface in a file `source` (arrays vertices [V, 3] and faces [F, 3]).

    The file `target` gets the corners of all pieces one after the other, and the number of corners of each. Exits with
    `CANNOT_DIVIDE` if CoACD raises an error.
    """
    import coacd

    with np.load(source) as surface:
        vertices, faces = surface["vertices"], surface["faces"]
    try:
        found = coacd.run_coacd(coacd.Mesh(vertices, faces), **SETTINGS)
        points = [np.asarray(corners, np.float64) for corners, _ in found]
        together = np.concatenate(points)
    except MemoryError:  # the same surface may fit the next time
        raise
    except Exception:
        sys.exit(CANNOT_DIVIDE)
    draft = target.with_suffix(".draft.npz")
    np.savez(draft, points=together, counts=[len(each) for each in points])
    draft.replace(target)


def main() -> None:
    """Divide some surfaces of a folder."""
    import coacd  # not at the top: kinmo imports this file, and CoACD may be missing or broken

    coacd.set_log_level("off")
    folder, seconds, all_seconds = Path(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
    for number in sys.argv[4:]:
        if time.process_time() > all_seconds:
            return
        (folder / f"{number}.started").touch()
        signal.setitimer(signal.ITIMER_PROF, seconds)  # its signal ends the process, in the middle of CoACD too
        divide(folder / f"{number}.npz", folder / f"{number}.pieces.npz")


if __name__ == "__main__":
    main()
