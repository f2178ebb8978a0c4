"""Overlaps of boxes as networks say them, and with their sides where scans show them, by sensors with one fault each.

    python bench/seen_boxes.py WORKSPACE --category refrigerator --setting ceiling [--objects 30] [--quick]

Test objects of the workspace are scanned anew; the networks are those that the workspace has.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch

from kinmo.config import SensorConfig, load_config
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.scan_metrics import score_frame, truth
from kinmo.io.readers import Found, Layout, read_found
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_networks import Cell
from kinmo.pipeline.scans.training_settings import SETTINGS
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.articulated_object import articulated_object
from kinmo.scans.labelled_frames import scan
from kinmo.scans.pose_fitting import PoseOptions, estimate
from kinmo.scans.scan_file import Provenance, ScanFile, open_scans, write_scans

BOXES = ("said", "seen")


def main() -> None:
    """Print a row for every sensor."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--category", default="refrigerator")
    parser.add_argument("--setting", default="ceiling", choices=SETTINGS)
    parser.add_argument("--objects", type=int, default=30)
    parser.add_argument("--quick", action="store_true", help="two objects")
    arguments = parser.parse_args()
    count = 2 if arguments.quick else arguments.objects
    torch.set_num_threads(1)
    workspace = Workspace(arguments.workspace)
    dataset = open_scan_dataset(workspace, arguments.category)
    cell = Cell(dataset.category, arguments.setting, 0)
    weights = cell.weights(workspace)
    if weights is None:
        parser.error(f"no networks for {cell}")
    network, rough = Ancsh.load(*weights), load_config("small").scans.rough
    sensors = {"clean": SensorConfig(), "rough": rough}
    sensors |= {name: replace(SensorConfig(), **{name: getattr(rough, name)}) for name in ("noise", "holes", "crop", "steep")}
    print(f"{cell}\n{'sensor':8}{'scans':>8}{'turned by':>12}" + "".join(f"{boxes:>8}" for boxes in BOXES))
    for name, sensor in sensors.items():
        rotations: list[np.ndarray] = []
        overlaps: dict[str, list[np.ndarray]] = {boxes: [] for boxes in BOXES}
        for file in scanned(workspace, dataset.category, {file.id for file in dataset.files["test"]}, sensor, count):
            points, *states = (file.read(kind) for kind in ("points", "poses", "values", "turns"))
            answers = network.answer(list(points), [1.0] * len(points))
            true = [truth(*state, file.joints, file.structure, file.extents) for state in zip(*states, strict=True)]
            for boxes in BOXES:
                options = PoseOptions(ties=network.config.ties, boxes=boxes, seed=0)
                found = estimate(answers, network.structure, options, network.typical)
                scores = [score_frame(*both, file.structure) for both in zip(found, true, strict=True)]
                overlaps[boxes] += [score.iou for score in scores]
                rotations += [score.rotation for score in scores]
        means = "".join(f"{np.nanmean(overlaps[boxes]):8.3f}" for boxes in BOXES)
        print(f"{name:8}{len(overlaps['said']):8}{np.degrees(np.nanmean(rotations)):11.1f}°{means}", flush=True)
        said, seen = (float(np.nanmean(overlaps[boxes])) for boxes in BOXES)
        claim = f"IoU of boxes as scans show them, by {name} sensors, beside as networks say them"
        print(json.dumps({"claim": claim, "ours": seen, "peer": said, "ratio": seen / said, "goal": 1.0, "met": seen >= said}))


def scanned(workspace: Workspace, category: str, ids: set[str], sensor: SensorConfig, count: int) -> Iterator[ScanFile]:
    """Scans by a sensor of the first test objects among `ids`."""
    config = replace(load_config("small").scans, sensor=sensor)
    entries = [entry for entry in open_dataset(workspace, category).labelled[Split.TEST] if entry.id in ids]
    with tempfile.TemporaryDirectory() as folder:
        for entry in entries[:count]:
            target = articulated_object(read_found(Found(Path(entry.source), Layout(entry.layout), entry.id)))
            scans = scan(target, config, zlib.crc32(entry.id.encode()), to_train=False)
            if len(scans):
                path = Path(folder) / "scans.safetensors"
                write_scans(path, target, scans, Provenance())
                yield open_scans(path)


if __name__ == "__main__":
    main()
