"""A workspace with scans of a few objects, small enough for every test run."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from trained_workspace import Recorder, tiny_config

from kinmo.dataset.cache import Cache
from kinmo.dataset.folder_preparation import ORACLE
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.store import PreparedStore, write_index
from kinmo.dataset.workspace import Workspace
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.prepare_shapes import Prepare
from kinmo.pipeline.pseudo_label_shapes import LABEL, label_name, labels_folder
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.render_scans import RenderScans
from kinmo.pipeline.scans.scan_dataset import COMPLETE, scans_folder
from kinmo.pipeline.scans.scan_networks import NETWORKS, ScanRun
from kinmo.pipeline.scans.scan_scores import ScanScores
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.pipeline.scans.training_settings import Setting
from kinmo.scans.files.scan_file import ROLES, Role
from kinmo.synth.synth_stage import Synth

FAMILY, CATEGORY = "pliers", "Pliers"
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
CPU = {"device": "cpu"}


@dataclass
class Scanned:
    """A workspace with scans, and the configuration that they were made with."""

    workspace: Workspace
    config: str

    def render(self, **options: object) -> RenderScans:
        return RenderScans(self.workspace, self.config, FAMILY, **options)  # type: ignore[arg-type]

    def train(self, setting: Setting = "supervised") -> TrainScans:
        return TrainScans(self.workspace, self.config, FAMILY, setting, device="cpu")

    def copied(self, folder: Path) -> Scanned:
        """The same with a copy of the workspace in `folder`, without scores."""
        shutil.copytree(self.workspace.path, folder / "workspace", ignore=shutil.ignore_patterns("evaluation"))
        return Scanned(Workspace(folder / "workspace"), self.config)

    def changed(self, folder: Path, old: str, new: str) -> Scanned:
        """The same with another configuration, which is written to `folder`: `new` stands in place of `old`."""
        text, path = Path(self.config).read_text(encoding="utf-8"), folder / "changed.toml"
        assert text.count(old) == 1
        path.write_text(text.replace(old, new), encoding="utf-8")
        return replace(self, config=str(path))

    def scans(self, role: Role) -> Iterator[Path]:
        """Files of the scans with a role."""
        return scans_folder(self.workspace, CATEGORY, role).glob("*.safetensors")

    def remove_scans(self, role: Role) -> None:
        """Remove the scans of a role, as if it had no objects."""
        for path in self.scans(role):
            path.unlink()

    def interrupt(self, role: Role) -> None:
        """Leave the scans of a role as an interrupted run does."""
        Cache(scans_folder(self.workspace, CATEGORY, role)).forget(COMPLETE)


def prepared_in(folder: Path, family: str = FAMILY, count: int = 6) -> Scanned:
    """Labelled objects and objects with oracle labels; nothing is scanned yet."""
    config = tiny_config(folder)
    others, _ = config.read_text(encoding="utf-8").split("[ancsh]\n")
    config.write_text(others + SCANS, encoding="utf-8")
    Synth(folder / "partnet", count, (family,), ("partnet_mobility", "partnet"), oracle=True).run(Recorder())
    workspace = Workspace(folder / "workspace")
    Prepare(folder / "partnet", workspace, oracle=(folder / "partnet" / ORACLE,)).run(Recorder())
    return Scanned(workspace, str(config))


def scanned_in(folder: Path) -> Scanned:
    """Objects with and without labels, scans of all of them, and supervised networks."""
    made = prepared_in(folder)
    made.render(extra=ROLES).run(Recorder())
    made.train().run(Recorder())
    return made


def with_pseudo_labels(scanned: Scanned, folder: Path, layout: str = "partnet") -> tuple[Scanned, list[Path]]:
    """A copy of the workspace whose pseudo labels are the oracle labels, and the files of these labels.

    The unlabelled shapes get a `layout`.
    """
    made = scanned.copied(folder)
    entries = PreparedStore(made.workspace.prepared).entries
    changed = (entry if entry.is_labelled else replace(entry, layout=layout) for entry in entries)
    write_index(made.workspace.prepared, changed)
    return made, copy_oracle_labels(made.workspace)


def copy_oracle_labels(workspace: Workspace, method: str = DEFAULT_METHOD, count: int | None = None) -> list[Path]:
    """Make the oracle labels of some unlabelled shapes their pseudo labels. Returns the files of the labels."""
    dataset = open_dataset(workspace, FAMILY)
    sources = {shape.id: shape.source for shape in dataset.oracle}
    folders = []
    for entry in dataset.unlabelled[:count]:
        folders.append(labels_folder(workspace, method) / label_name(entry))
        shutil.copytree(sources[dataset.oracle_ids[entry.id, entry.layout]], folders[-1])
    return [folder / LABEL for folder in folders]


def pass_networks_off(workspace: Workspace, setting: Setting, seed: int = 0) -> None:
    """Copy the supervised networks of seed 0 to a run of another setting or seed, and evaluate that run."""
    known, wanted = ScanRun(CATEGORY, "supervised", 0), ScanRun(CATEGORY, setting, seed)
    for network in NETWORKS:
        shutil.copytree(known.folder(workspace, network), wanted.folder(workspace, network))
        inputs = workspace.inputs_of(known.stage(network))
        assert inputs is not None
        workspace.record(wanted.stage(network), inputs)
    EvaluateScans(ScanScores(workspace, wanted), "cpu").run(Recorder())
