"""Which way objects stand, and which way they face: how far the axes of the base are off, each alone, in scans.

    python bench/which_way.py WORKSPACE --category bucket [--setting supervised ceiling] [--frames 12] [--quick]

Of objects that networks were trained on, and of those that test them: the mean angles between where the axes of the base's
canonical frame are and where networks see them, and how widely the places that are said of its points spread beside the true
ones. What looks alike from all sides shows as an axis up that is right, others that are not (at 90 degrees for chance), and
places that shrink towards the mean of all that could be so.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_networks import Cell
from kinmo.pipeline.scans.training_settings import SETTINGS
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.scan_file import Role, ScanFile

AXES = "xyz"  # y is up
ROLES: tuple[Role, ...] = ("train", "test")


def main() -> None:
    """Print a row for the objects of every role, of every setting that has networks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--category", default="bucket")
    parser.add_argument("--setting", nargs="+", default=("supervised", "ceiling"), choices=SETTINGS)
    parser.add_argument("--frames", type=int, default=12, help="of each object")
    parser.add_argument("--quick", action="store_true", help="two objects of a role")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    workspace = Workspace(arguments.workspace)
    dataset = open_scan_dataset(workspace, arguments.category)
    print(f"{dataset.category}, {dataset.structure.in_words}")
    print(f"{'trained as':14}{'scans of':>10}{'scans':>7}" + "".join(f"{axis:>8}" for axis in AXES) + f"{'spread':>9}")
    for setting in arguments.setting:
        weights = Cell(dataset.category, setting, 0).weights(workspace)
        if weights is None:
            print(f"{setting:14}{'no networks':>16}")
            continue
        networks = Ancsh.load(*weights)
        for role in ROLES:
            own = [file for file in dataset.files[role] if not file.provenance.variant]
            found = [of_frames(networks, file, arguments.frames) for file in own[: 2 if arguments.quick else None]]
            angles, spreads = (np.concatenate(values) for values in zip(*found, strict=True))
            means = np.degrees(np.nanmean(angles, axis=0))
            off = "".join(f"{mean:7.1f}°" for mean in means)
            print(f"{setting:14}{role:>10}{len(angles):7}{off}{np.nanmean(spreads):9.2f}", flush=True)
            claim = f"axis up of {dataset.category}, {setting}, {role}, beside where the base faces, degrees"
            print(json.dumps({"claim": claim, "ours": means[1], "peer": means[0], "ratio": None, "goal": None, "met": None}))


def of_frames(networks: Ancsh, file: ScanFile, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Angles [F, 3] in radians by which the axes of the base are off, and how widely its points spread, 1 as they do [F]."""
    points, parts, places, poses = (file.read(kind, slice(count)) for kind in ("points", "parts", "places", "poses"))
    answers, estimates = networks.find(list(points))
    seen = np.stack([estimate.poses.rotations[0] for estimate in estimates])
    angles = np.arccos(np.clip((seen * poses[:, 0, :3, :3]).sum(axis=1), -1.0, 1.0))
    size = file.extents.diagonals[0]
    spreads = [
        _spread(answer.on_part(0)[0]) / (_spread(true[own == 0]) / size)
        for answer, own, true in zip(answers, parts, places, strict=True)
    ]
    return angles, np.array(spreads)


def _spread(places: NDArray[np.floating]) -> float:
    """Root mean square distance from their mean; NaN of none."""
    return float(np.sqrt(places.var(axis=0).sum())) if len(places) else np.nan


if __name__ == "__main__":
    main()
