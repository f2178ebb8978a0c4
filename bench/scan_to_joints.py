"""Speed from scan to joints, all steps included: networks, their input frame, RANSAC, boxes, joints and states.

Scans of procedural refrigerators with 1,024 points, and networks of `small` with random weights. These take as long as trained
ones, and RANSAC takes longer, since fewer points agree. The goal is 10 scans a second on two cores.

Usage:
    OMP_NUM_THREADS=2 python bench/scan_to_joints.py [--quick]
"""

from __future__ import annotations

import os
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from common import option_parser, print_claims, print_table, rate_claim
from kinmo.cli.console import QuietObserver
from kinmo.config import load_config
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.prepare_shapes import Prepare
from kinmo.pipeline.scans.render_scans import RenderScans
from kinmo.pipeline.scans.scan_predictor import ScanPredictor
from kinmo.scans.ancsh.ancsh_network import AncshNetwork, PartNetwork
from kinmo.scans.ancsh.ancsh_predictor import AncshPredictor
from kinmo.scans.files.scan_file import ScanFile, open_scans
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.synth.synth_stage import Synth

GOAL = 10.0
"""Scans a second."""


def scan_refrigerators(folder: Path, count: int) -> list[ScanFile]:
    """Scans of the refrigerators with the most frequent structure."""
    Synth(folder / "partnet", count, ("refrigerator",), ("partnet_mobility",)).run(QuietObserver())
    workspace = Workspace(folder / "workspace")
    Prepare(folder / "partnet", workspace).run(QuietObserver())
    RenderScans(workspace, "small", "refrigerator").run(QuietObserver())
    files = [file for path in sorted(workspace.scans.rglob("*.safetensors")) if (file := open_scans(path)).frames]
    usual, _ = Counter(file.structure for file in files).most_common(1)[0]
    return [file for file in files if file.structure == usual]


def random_networks(files: list[ScanFile]) -> AncshPredictor:
    """Networks with random weights for the structure of the scans."""
    torch.manual_seed(0)
    config, structure = load_config("small").ancsh, files[0].structure
    parts = structure.part_count
    own = (AncshNetwork(config, parts, parts).eval(), PartNetwork(config, parts, parts).eval())
    return AncshPredictor(*own, config, structure, CategoryPrior.from_scans(files), "cpu")


def seconds(network: AncshPredictor, points: list[NDArray[np.float32]], repeats: int) -> tuple[float, float]:
    """Least seconds a scan in several runs: the networks alone, and all steps."""
    alone, whole = [], []
    network.predict(points[:2])
    for _ in range(repeats):
        start = time.perf_counter()
        network.predict_points(points)
        alone.append(time.perf_counter() - start)
        start = time.perf_counter()
        network.predict(points)
        whole.append(time.perf_counter() - start)
    return min(alone) / len(points), min(whole) / len(points)


def seconds_one_by_one(network: AncshPredictor, points: list[NDArray[np.float32]], repeats: int) -> float:
    """Least seconds a scan in several runs, one scan after another."""
    predictor = ScanPredictor(network, "Refrigerator", "random weights", "")
    found = []
    for _ in range(repeats):
        start = time.perf_counter()
        for scan in points:
            predictor.predict(scan)
        found.append(time.perf_counter() - start)
    return min(found) / len(points)


def main() -> None:
    """Time scans in batches, and one after another."""
    quick = option_parser(__doc__, "few objects and runs").parse_args().quick
    torch.set_num_threads(int(os.environ.get("OMP_NUM_THREADS", "2")))
    with tempfile.TemporaryDirectory() as folder:
        files = scan_refrigerators(Path(folder), 4 if quick else 12)
        points = [scan for file in files for scan in file.read("points", slice(0, 4 if quick else 12))]
        network = random_networks(files)
        answering, whole = seconds(network, points, 1 if quick else 3)
        one_by_one = seconds_one_by_one(network, points[:: 1 if quick else 4], 1 if quick else 3)
    print(f"{len(points)} scans of {len(points[0])} points, {files[0].structure}")
    rows = [
        ("networks and their input frame", 1e3 * answering, None),
        ("poses, joints and states", 1e3 * (whole - answering), None),
        ("all, in batches", 1e3 * whole, 1.0 / whole),
        ("all, one after another", 1e3 * one_by_one, 1.0 / one_by_one),
    ]
    print_table(("step", "time a scan (ms)", "scans a second"), rows)
    print_claims(rate_claim("scan to joints with small, scans a second on two cores", 1.0 / whole, GOAL))


if __name__ == "__main__":
    main()
