"""Results are the same on one process as on several."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from trained_workspace import METHODS, Recorder, Trained, contents, copy_without

from kinmo.dataset.workspace import Workspace
from kinmo.pipeline import network_jobs
from kinmo.pipeline.predict_shapes import PredictShapes


def test_two_processes_write_the_same_files_as_one(trained: Trained, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network_jobs, "JOBS_PER_PROCESS", 1)
    workspace = copy_without(trained, tmp_path, ["pseudo-label", "eval"])
    for name in ("eval", "pseudo-label"):
        replace(trained.stages[name], workspace=workspace, workers=2).run(Recorder())  # type: ignore[type-var]
    shutil.rmtree(workspace.report)
    before = contents(trained.workspace.path)
    assert contents(workspace.path) == {path: hash for path, hash in before.items() if not path.startswith("report")}
    made = []
    for workers in (1, 2):
        source, out = trained.shapes / "partnet", tmp_path / str(workers)
        PredictShapes([source], out, trained.workspace, METHODS[0], device="cpu", workers=workers).run(Recorder())
        made.append(contents(out))
    assert made[0] == made[1] and len(made[0]) > 4


def test_networks_trained_side_by_side_equal_those_trained_in_turn(trained: Trained, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "workspace", prepared=trained.workspace.prepared)
    stage, recorder = replace(trained.stages["train"], workspace=workspace, workers=2), Recorder()  # type: ignore[type-var]
    outcome = stage.run(recorder)
    assert {name: result["sha256"] for name, result in outcome.data.items()} == {
        name: result["sha256"] for name, result in trained.outcomes["train"].data.items()
    }
    assert len({step for step in recorder.steps if step.startswith("training")}) == len(outcome.data) == 6
    assert not stage.plan().steps
