"""A workspace with scans of a few objects, small enough for every test run."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from trained_workspace import Recorder, tiny_config

from kinmo.dataset.folder_preparation import ORACLE
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.store import INDEX
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.pipeline.label_decisions import folder_name
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.render_scans import Render
from kinmo.pipeline.scans.scan_networks import NETWORKS, Cell
from kinmo.pipeline.scans.train_scans import TrainAncsh
from kinmo.pipeline.scans.training_settings import Setting
from kinmo.scans.files.scan_file import ROLES
from kinmo.synth.synth_stage import Synth

FAMILY, CATEGORY = "laptop", "Laptop"
SCANS = """
[ancsh]
points = 128
centers = [32, 8]
neighbours = [8, 8]
width = 0.125
batch_frames = 4
batches_per_epoch = 2
confidence = 0.0
[ancsh.training]
epochs = 1
learning_rate = 1e-3
weight_decay = 0.0
decay_epochs = 0
threads = 1
[scans]
states = 2
views = 2
test_states = 1
test_views = 2
size = 96
points = 256
least_pixels = 1
"""
HOW = {"device": "cpu"}


@dataclass
class Scanned:
    """A workspace with scans, and the configuration that they were made with."""

    workspace: Workspace
    config: str

    def render(self, **options: object) -> Render:
        return Render(self.workspace, self.config, FAMILY, **options)  # type: ignore[arg-type]

    def train(self, setting: str) -> TrainAncsh:
        return TrainAncsh(self.workspace, self.config, FAMILY, setting, **HOW)  # type: ignore[arg-type]


def smaller(scanned: Scanned, folder: Path) -> str:
    """The configuration of scans with fewer pixels, in a file there."""
    path = folder / "smaller.toml"
    path.write_text(Path(scanned.config).read_text(encoding="utf-8").replace("size = 96", "size = 80"), encoding="utf-8")
    return str(path)


def prepared_in(folder: Path, family: str = FAMILY, count: int = 6) -> Scanned:
    """Labelled objects, and some whose labels are held back, of which nothing is scanned yet."""
    config = tiny_config(folder)
    others, _ = config.read_text(encoding="utf-8").split("[ancsh]\n")
    config.write_text(others + SCANS, encoding="utf-8")
    Synth(folder / "partnet", count, (family,), ("partnet_mobility", "partnet"), oracle=True).run(Recorder())
    workspace = Workspace(folder / "workspace")
    Prepare(folder / "partnet", workspace, hold_back=(folder / "partnet" / ORACLE,)).run(Recorder())
    return Scanned(workspace, str(config))


def made_in(folder: Path) -> Scanned:
    """Objects with labels and without, scans of all, and networks that saw those with labels."""
    made = prepared_in(folder)
    made.render(beside=ROLES).run(Recorder())
    made.train("supervised").run(Recorder())
    return made


def pseudo_labelled(scanned: Scanned, folder: Path, layout: str = "partnet") -> tuple[Workspace, list[Path]]:
    """The workspace copied to `folder`, its unlabelled shapes given the labels that were held back, and these labels.

    The unlabelled shapes are said to have come in a `layout`.
    """
    shutil.copytree(scanned.workspace.path, folder)
    index = folder / "prepared" / INDEX
    index.write_text(index.read_text(encoding="utf-8").replace('"partnet",', f'"{layout}",'), encoding="utf-8")
    workspace = Workspace(folder)
    dataset = open_dataset(workspace, FAMILY)
    sources = {shape.id: shape.source for shape in dataset.hidden}
    folders = [workspace.pseudo / folder_name(entry) for entry in dataset.unlabelled]
    for entry, target in zip(dataset.unlabelled, folders, strict=True):
        shutil.copytree(sources[dataset.truths[entry.id, entry.layout]], target)
    return workspace, [target / "mobility_v2.json" for target in folders]


def taken_for(workspace: Workspace, setting: Setting, seed: int) -> None:
    """Take the trained networks for those of another setting and seed, and judge them."""
    known, wanted = Cell(CATEGORY, "supervised", 0), Cell(CATEGORY, setting, seed)
    for network in NETWORKS:
        shutil.copytree(known.folder(workspace, network), wanted.folder(workspace, network))
        record = workspace.record(known.stage(network))
        assert record is not None
        workspace.write_record(wanted.stage(network), StageRecord(record.inputs))
    EvaluateScans(workspace, wanted, "cpu").run(Recorder())
