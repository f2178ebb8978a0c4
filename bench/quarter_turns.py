"""How much of what is wrong in scans comes of objects that networks take to stand otherwise: turned by a quarter, mostly.

    python bench/quarter_turns.py WORKSPACE --category dishwasher

Of every judged cell of a category: in how many frames the base is turned by more than 45 degrees, and the mean errors of
these, of the others, and of all.
"""

from __future__ import annotations

import argparse
import json
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.categories import same_category
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.scan_records import read_scores
from kinmo.pipeline.scans.scan_networks import scores_path, trained_by_all_methods

OTHERWISE = np.radians(45.0)


def main() -> None:
    """Print a line a cell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--category", default="dishwasher")
    parser.add_argument("--quick", action="store_true", help="of one training")
    arguments = parser.parse_args()
    trained = trained_by_all_methods(Workspace(arguments.workspace))
    wanted = ((place, cell) for place, cell in trained if same_category(cell.category, arguments.category))
    judged = ((*each, path) for each in wanted if (path := scores_path(*each, on_rough=False)).exists())
    for workspace, cell, path in islice(judged, 1 if arguments.quick else None):
        frames = [frame for scans in read_scores([path]) for frame in scans.frames]
        base = np.array([frame.rotation[0] for frame in frames])
        turns = np.degrees([_mean(frame.rotation) for frame in frames])
        axes = np.degrees([_mean(frame.axis) for frame in frames])
        stands_otherwise = base > OTHERWISE
        print(f"{cell.title(workspace)}: {stands_otherwise.sum()} of {len(frames)} frames with a base that stands otherwise")
        for name, errors in (("rotation", turns), ("axis", axes)):
            means = [_mean(part) for part in (errors[stands_otherwise], errors[~stands_otherwise], errors)]
            print(f"  {name}: {means[0]:.1f} deg in these, {means[1]:.2f} in the others, {means[2]:.2f} in all")
        print(json.dumps({"claim": f"axes of {cell.title(workspace)} where the base stands as it does, degrees",
                          "ours": means[1], "peer": means[2], "ratio": None, "goal": None, "met": None}))  # fmt: skip


def _mean(errors: NDArray[np.float64]) -> float:
    """Of those that are known."""
    known = errors[np.isfinite(errors)]
    return float(known.mean()) if len(known) else np.nan


if __name__ == "__main__":
    main()
