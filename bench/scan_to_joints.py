"""Scans to parts, boxes, joints and states, all in: networks, their input frame, RANSAC and what follows.

    OMP_NUM_THREADS=2 python bench/scan_to_joints.py [--quick]

Scans of procedural refrigerators, networks of `small` with weights at random: they take as long as trained ones, and RANSAC
takes longer, since fewer points agree. Goal: 10 scans a second on two cores.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import torch
from kinmo.pipeline.scans.scan_finder import ScanFinder
from numpy.typing import NDArray

from kinmo.cli.console import QuietObserver
from kinmo.config import load_config
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.scans.render_scans import Render
from kinmo.scans.ancsh.ancsh_network import AncshNetwork, PartNetwork
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.files.scan_file import ScanFile, open_scans
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.synth.synth_stage import Synth

GOAL = 10.0


def scanned(folder: Path, count: int) -> list[ScanFile]:
    """Those of the structure that most refrigerators have."""
    Synth(folder / "partnet", count, ("refrigerator",), ("partnet_mobility",)).run(QuietObserver())
    workspace = Workspace(folder / "workspace")
    Prepare(folder / "partnet", workspace).run(QuietObserver())
    Render(workspace, "small", "refrigerator").run(QuietObserver())
    files = [file for path in sorted(workspace.scans.rglob("*.safetensors")) if (file := open_scans(path)).frames]
    usual, _ = Counter(file.structure for file in files).most_common(1)[0]
    return [file for file in files if file.structure == usual]


def networks(files: list[ScanFile]) -> Ancsh:
    torch.manual_seed(0)
    config, structure = load_config("small").ancsh, files[0].structure
    parts = structure.part_count
    own = (AncshNetwork(config, parts, parts).eval(), PartNetwork(config, parts, parts).eval())
    return Ancsh(*own, config, structure, CategoryPrior.from_scans(files), "cpu")


def seconds(network: Ancsh, points: list[NDArray[np.float32]], repeats: int) -> tuple[float, float]:
    """Least seconds a scan of some runs: of the networks alone, and all in."""
    alone, whole = [], []
    network.find(points[:2])
    for _ in range(repeats):
        start = time.perf_counter()
        network.answer(points)
        alone.append(time.perf_counter() - start)
        start = time.perf_counter()
        network.find(points)
        whole.append(time.perf_counter() - start)
    return min(alone) / len(points), min(whole) / len(points)


def seconds_one_by_one(network: Ancsh, points: list[NDArray[np.float32]], repeats: int) -> float:
    """Least seconds a scan of some runs, each found before the next one is looked at."""
    finder = ScanFinder(network, "Refrigerator", "weights at random", "")
    found = []
    for _ in range(repeats):
        start = time.perf_counter()
        for scan in points:
            finder.find(scan)
        found.append(time.perf_counter() - start)
    return min(found) / len(points)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer objects and runs")
    quick = parser.parse_args().quick
    torch.set_num_threads(int(os.environ.get("OMP_NUM_THREADS", "2")))
    with tempfile.TemporaryDirectory() as folder:
        files = scanned(Path(folder), 4 if quick else 12)
        points = [scan for file in files for scan in file.read("points", slice(0, 4 if quick else 12))]
        network = networks(files)
        answering, whole = seconds(network, points, 1 if quick else 3)
        one_by_one = seconds_one_by_one(network, points[:: 1 if quick else 4], 1 if quick else 3)
    print(f"{len(points)} scans of {len(points[0])} points, {files[0].structure}: {1.0 / whole:.1f} a second;")
    print(f"networks and their input {1e3 * answering:.1f} ms, poses, joints and states {1e3 * (whole - answering):.1f} ms;")
    print(f"one after another, as from a camera, {1.0 / one_by_one:.1f} a second")
    figures = {"ours": 1.0 / whole, "peer": None, "ratio": None, "goal": GOAL, "met": 1.0 / whole >= GOAL}
    print(json.dumps({"claim": "scan to joints with small, scans a second on two cores", **figures}))


if __name__ == "__main__":
    main()
