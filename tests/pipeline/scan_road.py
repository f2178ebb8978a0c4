"""A workspace with scans of a few objects, small enough for every test run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from whole_road import Listener, tiny_config

from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.scans.render import Render
from kinmo.pipeline.scans.train import TrainAncsh
from kinmo.pipeline.synth import Synth
from kinmo.scans.scan_file import ROLES
from kinmo.synth.generate import HELD_BACK
from kinmo.workspace import Workspace

FAMILY, CATEGORY = "laptop", "Laptop"
SCANS = """
[ancsh]
points = 128
centers = [32, 8]
neighbours = 8
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


def prepared_in(folder: Path, family: str = FAMILY, count: int = 6) -> Scanned:
    """Labelled objects, and some whose labels are held back, of which nothing is scanned yet."""
    config = tiny_config(folder)
    others, _ = config.read_text(encoding="utf-8").split("[ancsh]\n")
    config.write_text(others + SCANS, encoding="utf-8")
    Synth(folder / "partnet", count, (family,), ("partnet_mobility", "partnet"), held_back=True).run(Listener())
    workspace = Workspace(folder / "workspace")
    Prepare(folder / "partnet", workspace, hold_back=(folder / "partnet" / HELD_BACK,)).run(Listener())
    return Scanned(workspace, str(config))


def made_in(folder: Path) -> Scanned:
    """Objects with labels and without, scans of all, and networks that saw those with labels."""
    made = prepared_in(folder)
    made.render(beside=ROLES).run(Listener())
    made.train("supervised").run(Listener())
    return made
