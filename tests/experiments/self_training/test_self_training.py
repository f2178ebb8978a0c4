"""Self-training: supervised networks label scans of unlabelled objects, and networks learn from these labels."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, CPU, FAMILY, Scanned
from trained_workspace import Recorder, contents

from kinmo.core.errors import InputError
from kinmo.dataset.cache import Cache
from kinmo.experiments.self_training.self_label_scans import SelfLabelScans
from kinmo.experiments.self_training.train_by_self_training import TrainBySelfTraining
from kinmo.pipeline import network_jobs
from kinmo.pipeline.scans.scan_dataset import COMPLETE, open_scan_dataset
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.pipeline.scans.train_scans import self_labels_folder
from kinmo.scans.files.scan_file import count_objects, open_scans

FRAMES = "batch_frames = 4\nbatches_per_epoch = "


@pytest.fixture(scope="module")
def made(scanned: Scanned, tmp_path_factory: pytest.TempPathFactory) -> Scanned:
    """A workspace with a configuration whose networks learn enough to find all parts."""
    folder = tmp_path_factory.mktemp("self-training")
    longer = scanned.copied(folder).changed(folder, f"{FRAMES}2", f"{FRAMES}240")
    return longer.changed(folder, "learning_rate = 1e-3\nweight_decay = 0.0", "learning_rate = 1e-2\nweight_decay = 0.0")


@pytest.fixture(scope="module")
def stage(made: Scanned) -> TrainBySelfTraining:
    """Finished self-training."""
    stage = TrainBySelfTraining(made.workspace, made.config, FAMILY, **CPU)
    planned = stage.plan()
    assert [step.split(" (")[0] for step in planned.steps if step.startswith("train")] == ["train ancsh", "train npcs"] * 2
    assert [step for step in planned.steps if step.startswith("label")]
    assert replace(stage, category=CATEGORY).plan() == planned, "in any spelling"
    outcome = stage.run(Recorder())
    assert list(outcome.data) == [f"{network} ({CATEGORY}, self-training, seed 0)" for network in ("ancsh", "npcs")]
    return stage


def labels_of(made: Scanned) -> list[Path]:
    return sorted(self_labels_folder(made.workspace, CATEGORY, 0).glob("*.safetensors"))


def test_networks_learn_from_true_labels_and_from_self_labels(made: Scanned, stage: TrainBySelfTraining) -> None:
    header = json.loads((ScanRun(CATEGORY, "self-training", 0).folder(made.workspace, "ancsh") / "weights.json").read_text())
    dataset, labels = open_scan_dataset(made.workspace, CATEGORY), labels_of(made)
    assert labels
    assert header["facts"]["labelled"] == count_objects(dataset.files["train"])
    assert header["facts"]["objects"] == count_objects(dataset.files["train"]) + len(labels)
    assert {open_scans(path).structure for path in labels} <= {dataset.structure}


def test_finished_self_training_is_not_done_again(made: Scanned, stage: TrainBySelfTraining) -> None:
    before = contents(made.workspace.path)
    assert stage.plan().steps == ()
    stage.run(Recorder())
    assert contents(made.workspace.path) == before


def test_an_interrupted_labelling_continues(made: Scanned, stage: TrainBySelfTraining, monkeypatch: pytest.MonkeyPatch) -> None:
    labelling, labels = SelfLabelScans(made.workspace, CATEGORY, confidence=0.0, **CPU), labels_of(made)
    before = contents(labels[0].parent)
    assert labelling.plan().steps == ()
    Cache(labels[0].parent).forget(COMPLETE)
    labels[0].unlink()
    kept = {path: path.stat().st_mtime_ns for path in labels[1:]}
    assert len(labelling.plan().steps) == 1
    labelling.run(Recorder())
    assert {path: path.stat().st_mtime_ns for path in labels[1:]} == kept, "finished labels stay as they are"
    assert contents(labels[0].parent) == before
    assert labelling.plan().steps == ()
    monkeypatch.setattr(network_jobs, "JOBS_PER_PROCESS", 1)
    Cache(labels[0].parent).forget(COMPLETE, *(path.stem for path in labels))
    for path in labels:
        path.unlink()
    replace(labelling, workers=2).run(Recorder())
    assert contents(labels[0].parent) == before, "two processes give the same labels"


def test_labels_change_with_the_confidence(made: Scanned, stage: TrainBySelfTraining) -> None:
    assert len(SelfLabelScans(made.workspace, CATEGORY, confidence=0.5, **CPU).plan().steps) == 1


def test_without_scans_of_unlabelled_objects_nothing_is_trained(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    made.interrupt("unlabelled")
    stage = TrainBySelfTraining(made.workspace, made.config, FAMILY, seed=1, **CPU)
    before = contents(made.workspace.path)
    for begin in (stage.plan, lambda: stage.run(Recorder())):
        with pytest.raises(InputError, match="no scans of unlabelled objects of Pliers: run kinmo render --unlabelled"):
            begin()
    assert contents(made.workspace.path) == before


def test_a_category_without_scans_is_reported(scanned: Scanned, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no scans of plierss \(did you mean Pliers\?\)"):
        TrainBySelfTraining(scanned.workspace, scanned.config, "plierss").plan()


def test_labelling_needs_supervised_networks(scanned: Scanned) -> None:
    with pytest.raises(InputError, match="no supervised networks for scans of Pliers: run kinmo train ancsh"):
        SelfLabelScans(scanned.workspace, CATEGORY, 0.0, seed=5, **CPU).run(Recorder())
