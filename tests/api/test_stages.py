"""Stages by the Python API run like the commands of the same names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from trained_workspace import Recorder, Trained, tiny_config

import kinmo
from kinmo.api.stages import train_stage, worker_count
from kinmo.dataset.folder_preparation import ORACLE
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.pipeline.train_all import TrainAll
from kinmo.pipeline.train_motion import TrainMotion
from kinmo.synth.synth_stage import Synth


def test_prepare_prepares_every_shape_of_a_folder(trained: Trained, tmp_path: Path) -> None:
    recorder = Recorder()
    outcome = kinmo.prepare(trained.shapes, tmp_path / "workspace", workers=1, observer=recorder)
    assert outcome.path == tmp_path / "workspace" / "prepared"
    assert outcome.data == trained.outcomes["prepare"].data
    assert recorder.steps
    with pytest.raises(kinmo.InputError, match="no such file"):
        kinmo.prepare(tmp_path / "nowhere", tmp_path / "workspace")


def test_prepare_takes_folders_of_oracle_labels(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("pliers",), ("partnet",), oracle=True).run(Recorder())
    kinmo.prepare(tmp_path / "partnet", tmp_path / "workspace", oracle=[str(tmp_path / "partnet" / ORACLE)], workers=1)
    assert open_dataset(Workspace(tmp_path / "workspace")).oracle


def test_train_trains_networks_that_predict(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    config = str(tiny_config(tmp_path))
    outcome = kinmo.train("gnn", workspace.path, config=config, seed=1, device="cpu", workers=1)
    assert set(outcome.data) == {"gnn_fine", "gnn_coarse"}
    shape = kinmo.load(next((trained.shapes / "partnet").iterdir()))
    assert kinmo.Predictor(workspace.path, device="cpu").predict(shape).shape is shape


def test_train_has_nothing_to_do_after_the_command(trained: Trained) -> None:
    config = trained.stages["train"].config  # type: ignore[attr-defined]
    recorder = Recorder()
    outcome = kinmo.train("motion", trained.workspace.path, config=config, device="cpu", workers=1, observer=recorder)
    assert outcome.data == trained.outcomes["train"].data
    assert not recorder.steps


def test_networks_choose_their_stage(tmp_path: Path) -> None:
    assert isinstance(train_stage("all", tmp_path, "small", "door", "paper", "semi-weakly", None, 0, "cpu", 1), TrainAll)
    scans = train_stage("ancsh", tmp_path, "small", None, "kinmo", "supervised", None, 0, "cpu", 1)
    assert isinstance(scans, TrainScans) and scans.setting == "supervised"
    motion = train_stage("axis", tmp_path, "small", None, "kinmo", "semi-weakly", tmp_path / "other", 0, "cpu", 3)
    assert isinstance(motion, TrainMotion)
    assert (motion.group, motion.workers, motion.start) == ("axis", 3, Workspace(tmp_path / "other"))


def test_wrong_networks_are_refused(tmp_path: Path) -> None:
    with pytest.raises(kinmo.InputError, match=r"networks: expected one of all, .*, got gmn \(did you mean gnn\?\)"):
        kinmo.train("gmn", tmp_path)  # type: ignore[arg-type]
    with pytest.raises(kinmo.InputError, match="method: expected one of kinmo, paper, got magic"):
        kinmo.train("all", tmp_path, method="magic")
    with pytest.raises(kinmo.InputError, match=r"setting: expected one of supervised, .*, got semi$"):
        kinmo.train("ancsh", tmp_path, setting="semi")  # type: ignore[arg-type]
    with pytest.raises(kinmo.InputError, match="--from: ancsh cannot start from trained weights"):
        kinmo.train("ancsh", tmp_path, start=tmp_path)


def test_evaluate_scores_the_methods(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    outcome = kinmo.evaluate(workspace.path, methods=["kinmo"], device="cpu", workers=1)
    for setting in ("parts_given", "hierarchy_given"):
        rows = {row[0]: row for row in outcome.data[setting]["summary"]["rows"]}
        expected = {row[0]: row for row in trained.outcomes["eval"].data[setting]["summary"]["rows"]}
        assert rows.keys() == {"kinmo"} and rows["kinmo"] == expected["kinmo"]
    recorder = Recorder()
    kinmo.evaluate(str(workspace.path), methods=("kinmo",), device="cpu", workers=1, observer=recorder)
    assert recorder.notes == ["already evaluated"]
    with pytest.raises(kinmo.InputError, match="no prepared shape of spoon"):
        kinmo.evaluate(workspace.path, category="spoon")


def test_evaluate_keeps_the_tables_of_the_command(trained: Trained) -> None:
    recorder = Recorder()
    outcome = kinmo.evaluate(trained.workspace.path, device="cpu", workers=1, observer=recorder)
    assert recorder.notes == ["already evaluated"]
    assert outcome.data == trained.outcomes["eval"].data


def test_no_workers_stand_for_one_per_core() -> None:
    assert worker_count(0) >= 1
    assert worker_count(3) == 3


def test_an_outcome_is_that_of_the_stage(trained: Trained) -> None:
    stage = replace(trained.stages["train"], workers=1)  # type: ignore[type-var]
    assert stage.run(Recorder()) == trained.outcomes["train"]
