"""Stages that are killed on their way, and then run again, end like those that were not (in short; bench/kill_resume.py)."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, CPU, FAMILY, Scanned
from trained_workspace import MADE, Recorder, Trained, contents, undone

from kinmo.dataset.stage import Stage
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_networks import NETWORKS, Cell
from kinmo.pipeline.train_all import TrainAll
from kinmo.scans.files.scan_file import ROLES

FORK = multiprocessing.get_context("forkserver")
FORK.set_forkserver_preload(
    [
        "kinmo.pipeline.train_motion",
        "kinmo.pipeline.pseudo_label",
        "kinmo.experiments.table1.evaluate_table1",
        "kinmo.view.report",
        "kinmo.pipeline.scans.render_scans",
        "kinmo.pipeline.scans.train_scans",
    ]
)


class Doomed(Recorder):
    """Ends its process, and the processes that work for it, at the news of step number `last`."""

    def __init__(self, last: int) -> None:
        super().__init__()
        self.last = last

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        super().progress(what, done, total, detail)
        if len(self.steps) == self.last:
            os.killpg(os.getpgrp(), signal.SIGKILL)


def run_to_the_kill(stage: Stage, last: int) -> None:
    os.setsid()
    stage.run(Doomed(last))


def killed_and_repeated(stage: Stage, moments: tuple[int, ...]) -> None:
    """Kill a stage at the news of these steps, one after the other, and then let it end."""
    for last in moments:
        process = FORK.Process(target=run_to_the_kill, args=(stage, last))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL
    stage.run(Recorder())


@pytest.mark.parametrize(("name", "moments"), [("train", (2, 1)), ("pseudo-label", (2, 1)), ("eval", (1,))])
def test_a_stage_that_is_killed_and_repeated_ends_like_one_that_was_not(
    name: str, moments: tuple[int, ...], trained: Trained, tmp_path: Path
) -> None:
    whole = contents(trained.workspace.path)
    folder, records = MADE[name]
    prefixes = (f"{folder}/", *(f"records/{record}." for record in records))
    own = {path: made for path, made in whole.items() if path.startswith(prefixes)}
    workspace = undone(trained, tmp_path, list(MADE)[list(MADE).index(name) :])
    killed_and_repeated(replace(trained.stages[name], workspace=workspace), moments)  # type: ignore[type-var]
    ended = contents(workspace.path)
    assert own and {path: ended.get(path) for path in own} == own
    assert not [path for path in ended if path.endswith("~")]


@pytest.mark.parametrize(("name", "moments"), [("render", (2, 3)), ("train", (1,))])
def test_stages_of_scans_do_too(name: str, moments: tuple[int, ...], scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    again = replace(scanned, workspace=Workspace(tmp_path / "workspace"))
    folders = {"render": ("scans/", "own-scans/"), "train": ("models/",)}[name]
    for folder in folders:
        shutil.rmtree(again.workspace.path / folder)
    for network in NETWORKS if name == "train" else ():
        again.workspace.forget(Cell(CATEGORY, "supervised", 0).stage(network))
    stage = again.render(beside=ROLES) if name == "render" else again.train("supervised")
    killed_and_repeated(stage, moments)
    own = {path: made for path, made in contents(scanned.workspace.path).items() if path.startswith(folders)}
    ended = contents(again.workspace.path)
    assert own and {path: made for path, made in ended.items() if path.startswith(folders)} == own


def test_the_whole_way_does_too(scanned: Scanned, tmp_path: Path) -> None:
    ways = []
    for name in ("whole", "killed"):
        shutil.copytree(scanned.workspace.prepared, tmp_path / name / "prepared")
        ways.append(TrainAll(Workspace(tmp_path / name), scanned.config, FAMILY, **CPU))
    told = Recorder()
    ways[0].run(told)
    third = len(told.steps) // 3
    killed_and_repeated(ways[1], (third, third))
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")
