"""Stages that are killed and repeated end like those that were not (in short; bench/kill_resume.py is longer)."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, FAMILY, Scanned
from trained_workspace import RESULTS, Recorder, Trained, contents, copy_without

from kinmo.dataset.stage import Stage
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_networks import NETWORKS, ScanRun
from kinmo.pipeline.train_all import TrainAll
from kinmo.scans.files.scan_file import ROLES

FORK = multiprocessing.get_context("forkserver")
FORK.set_forkserver_preload(
    [
        "kinmo.pipeline.train_motion",
        "kinmo.pipeline.pseudo_label_shapes",
        "kinmo.pipeline.evaluation.evaluate_shapes",
        "kinmo.experiments.table1.baselines",
        "kinmo.pipeline.scans.render_scans",
        "kinmo.pipeline.scans.train_scans",
    ]
)


class KillingRecorder(Recorder):
    """Kills its process, and the processes that work for it, at step number `last`."""

    def __init__(self, last: int) -> None:
        super().__init__()
        self.last = last

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        super().progress(what, done, total, detail)
        if len(self.steps) == self.last:
            os.killpg(os.getpgrp(), signal.SIGKILL)


def run_until_killed(stage: Stage, last: int) -> None:
    os.setsid()
    stage.run(KillingRecorder(last))


def kill_and_repeat(stage: Stage, moments: tuple[int, ...]) -> None:
    """Kill a stage at these steps, one run after the other, and then let it end."""
    for last in moments:
        process = FORK.Process(target=run_until_killed, args=(stage, last))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL
    stage.run(Recorder())


@pytest.mark.parametrize(("name", "moments"), [("train", (2, 1)), ("pseudo-label", (2, 1)), ("eval", (1, 2))])
def test_a_killed_and_repeated_stage_ends_like_one_that_was_not(
    name: str, moments: tuple[int, ...], trained: Trained, tmp_path: Path
) -> None:
    folder, records = RESULTS[name]
    own = {path: made for path, made in contents(trained.workspace.path).items() if path.startswith(f"{folder}/")}
    workspace = copy_without(trained, tmp_path, list(RESULTS)[list(RESULTS).index(name) :])
    stage = replace(trained.stages[name], workspace=workspace)  # type: ignore[type-var]
    kill_and_repeat(stage, moments)
    ended = contents(workspace.path)
    assert own and {path: ended.get(path) for path in own} == own
    assert not [path for path in ended if path.endswith("~")]
    assert [workspace.inputs_of(record) for record in records] == [trained.workspace.inputs_of(record) for record in records]
    assert stage.plan().steps == ()


@pytest.mark.parametrize(("name", "moments"), [("render", (2, 3)), ("train", (1,))])
def test_a_killed_and_repeated_stage_for_scans_does_too(
    name: str, moments: tuple[int, ...], scanned: Scanned, tmp_path: Path
) -> None:
    again = scanned.copied(tmp_path)
    folder = {"render": "scans", "train": "models"}[name]
    shutil.rmtree(again.workspace.path / folder)
    for network in NETWORKS if name == "train" else ():
        again.workspace.forget(ScanRun(CATEGORY, "supervised", 0).stage(network))
    stage = again.render(extra=ROLES) if name == "render" else again.train("supervised")
    kill_and_repeat(stage, moments)
    own = {path: made for path, made in contents(scanned.workspace.path).items() if path.startswith(f"{folder}/")}
    ended = contents(again.workspace.path)
    assert own and {path: made for path, made in ended.items() if path.startswith(f"{folder}/")} == own
    assert stage.plan().steps == ()


def test_killed_and_repeated_training_of_everything_does_too(scanned: Scanned, tmp_path: Path) -> None:
    stages = []
    for name in ("whole", "killed"):
        shutil.copytree(scanned.workspace.prepared, tmp_path / name / "prepared")
        stages.append(TrainAll(Workspace(tmp_path / name), scanned.config, FAMILY, device="cpu"))
    recorder = Recorder()
    stages[0].run(recorder)
    third = len(recorder.steps) // 3
    kill_and_repeat(stages[1], (third, third))
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")
    assert stages[1].plan().steps == ()
