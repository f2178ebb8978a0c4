"""What one point far from all others costs in a scan, with and without `kinmo.scans.outliers`, and what that cuts off by mistake.

    python bench/stray_points.py WORKSPACE --category refrigerator

On test scans of a category, with one point put some diagonals outside of their box, in a direction drawn at random.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_finder import ScanFinder
from kinmo.scans.outliers import are_strays

F64 = NDArray[np.float64]
AWAY = (0.1, 0.2, 0.5, 1.0, 2.0)


def main() -> None:
    """Print mean rotation errors, a line a distance, and what is cut off of scans that have no such point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--category", default="refrigerator")
    parser.add_argument("--scans", type=int, default=60)
    parser.add_argument("--quick", action="store_true", help="10 scans")
    arguments = parser.parse_args()
    workspace, rng = Workspace(arguments.workspace), np.random.default_rng(0)
    finder = ScanFinder.load(workspace, arguments.category)
    files = open_scan_dataset(workspace, finder.category).files["test"]
    every = [(file.read("points", frame), file.read("poses", frame)) for file in files for frame in range(file.frames)]
    some = [every[place] for place in rng.permutation(len(every))[: 10 if arguments.quick else arguments.scans]]
    for away in (0.0, *AWAY):
        scans = [points if away == 0.0 else with_stray(points, away, rng) for points, _ in some]
        kept, cut = (np.mean([error(found(finder, scan), poses) for scan, (_, poses) in zip(scans, some, strict=True)])
                     for found in (as_it_is, without_strays))  # fmt: skip
        print(f"{away:g} diagonals away: {kept:.1f} deg with all points, {cut:.1f} deg without strays")
    strays = [int(are_strays(points, points).sum()) for points, _ in every]
    changed = sum(count > 0 for count in strays)
    print(f"scans without such a point: {sum(strays)} points are cut off of {changed} of {len(every)}")
    claim = f"rotation of {arguments.category} with a point {AWAY[-1]:g} diagonals away, degrees, beside all points kept"
    print(json.dumps({"claim": claim, "ours": float(cut), "peer": float(kept), "ratio": None, "goal": None, "met": None}))


def with_stray(points: NDArray[np.float32], away: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """With one of the points [n, 3] so many diagonals of their box outside of that, in a direction drawn at random."""
    low, high = points.min(axis=0), points.max(axis=0)
    while True:
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        reach = float(np.min(0.5 * (high - low) / np.abs(direction)))
        place = 0.5 * (low + high) + (reach + away * np.linalg.norm(high - low)) * direction
        if place[2] > 0.0:
            changed = points.copy()
            changed[rng.integers(len(points))] = place
            return changed


def as_it_is(finder: ScanFinder, points: NDArray[np.float32]) -> F64:
    """Rotations [K, 3, 3] from all points."""
    (_,), (estimate,) = finder.network.find([points], [float(np.linalg.norm(np.ptp(points, axis=0)))])
    return estimate.poses.rotations


def without_strays(finder: ScanFinder, points: NDArray[np.float32]) -> F64:
    """Rotations [K, 3, 3] as a user gets them."""
    return finder.find(points).estimate.poses.rotations


def error(rotations: F64, poses: F64) -> float:
    """The mean angle, in degrees, of the parts that were found; 180 where none was."""
    turned = np.einsum("kji,kjl->kil", rotations, poses[:, :3, :3])
    angles = np.degrees(np.arccos(np.clip(0.5 * (np.trace(turned, axis1=1, axis2=2) - 1.0), -1.0, 1.0)))
    return float(np.nanmean(angles)) if np.isfinite(angles).any() else 180.0


if __name__ == "__main__":
    main()
