"""Stages that are killed on their way, and then run again, end like those that were not (in short; bench/kill_resume.py)."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from whole_road import Listener, Road, contents

from kinmo.pipeline.stage import Stage
from kinmo.workspace import Workspace

FORK = multiprocessing.get_context("forkserver")
FORK.set_forkserver_preload(
    ["kinmo.pipeline.train", "kinmo.pipeline.pseudo_label", "kinmo.pipeline.evaluate", "kinmo.pipeline.report"]
)
MADE = {
    "train": ("models", "pseudo", "eval", "report"),
    "pseudo-label": ("pseudo", "eval", "report"),
    "eval": ("eval", "report"),
}
"""What a stage and those after it have made."""


class Doomed(Listener):
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


@pytest.mark.parametrize(("name", "moments"), [("train", (2, 1)), ("pseudo-label", (2, 1)), ("eval", (1,))])
def test_a_stage_that_is_killed_and_repeated_ends_like_one_that_was_not(
    name: str, moments: tuple[int, ...], road: Road, tmp_path: Path
) -> None:
    workspace = tmp_path / "workspace"
    shutil.copytree(road.workspace.path, workspace)
    whole = contents(workspace)
    own = {path for path in whole if path.startswith((f"{MADE[name][0]}/", f"records/{name}"))}
    for folder in MADE[name]:
        shutil.rmtree(workspace / folder)
    for record in (workspace / "records").iterdir():
        if not record.name.startswith("prepare") and not (record.name.startswith("train") and name != "train"):
            record.unlink()
    stage = replace(road.stages[name], workspace=Workspace(workspace))  # type: ignore[type-var]
    for last in moments:
        process = FORK.Process(target=run_to_the_kill, args=(stage, last))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL
    stage.run(Listener())
    ended = contents(workspace)
    assert own and {path: ended.get(path) for path in own} == {path: whole[path] for path in own}
    assert not [path for path in ended if path.endswith("~")]
