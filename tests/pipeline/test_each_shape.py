"""Evaluation, labels and predictions, however many processes they are made on, and wherever they were stopped."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from whole_road import METHODS, Listener, Road, contents, undone

from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1 import trees_answers
from kinmo.experiments.table1.evaluate_table1 import Evaluate
from kinmo.pipeline import each_shape
from kinmo.pipeline.predict_shapes import Predict

UNDONE = ("pseudo-label", "eval")


class Impatient(Listener):
    """Presses Ctrl-C after some steps."""

    def __init__(self, patience: int) -> None:
        super().__init__()
        self.patience = patience

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        super().progress(what, done, total, detail)
        if self.steps.count("evaluating shapes") == self.patience:
            raise KeyboardInterrupt


def test_two_processes_make_the_same_files_as_one(road: Road, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(each_shape, "JOBS_A_PROCESS", 1)
    workspace = undone(road, tmp_path, UNDONE)
    for name in ("eval", "pseudo-label"):
        replace(road.stages[name], workspace=workspace, workers=2).run(Listener())  # type: ignore[type-var]
    shutil.rmtree(workspace.report)
    before = contents(road.workspace.path)
    assert contents(workspace.path) == {path: hash for path, hash in before.items() if not path.startswith("report")}
    made = []
    for workers in (1, 2):
        source, out = road.shapes / "partnet", tmp_path / str(workers)
        Predict(source, out, road.workspace, METHODS[0], device="cpu", workers=workers).run(Listener())
        made.append(contents(out))
    assert made[0] == made[1] and len(made[0]) > 4


def test_networks_trained_side_by_side_are_those_trained_one_by_one(road: Road, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "workspace")
    shutil.copytree(road.workspace.prepared, workspace.prepared)
    stage, listener = replace(road.stages["train"], workspace=workspace, workers=2), Listener()  # type: ignore[type-var]
    outcome = stage.run(listener)
    assert {name: made["sha256"] for name, made in outcome.data.items()} == {
        name: made["sha256"] for name, made in road.outcomes["train"].data.items()
    }
    assert len(set(listener.steps)) == len(outcome.data) == 4
    assert not stage.plan().steps


def test_an_evaluation_that_was_stopped_goes_on(road: Road, tmp_path: Path) -> None:
    workspace = undone(road, tmp_path, UNDONE)
    stage = replace(road.stages["eval"], workspace=workspace)  # type: ignore[type-var]
    with pytest.raises(KeyboardInterrupt):
        stage.run(Impatient(1))
    assert not (workspace.evaluation / "all").exists()
    listener = Listener()
    assert stage.run(listener).data == road.outcomes["eval"].data
    total = len(list((road.workspace.evaluation / "judgements").rglob("*.json")))
    assert listener.steps.count("evaluating shapes") == total - 1


def test_what_one_evaluation_judged_the_next_does_not_judge_again(road: Road, tmp_path: Path) -> None:
    shutil.copytree(road.workspace.path, tmp_path / "workspace")
    listener = Listener()
    Evaluate(Workspace(tmp_path / "workspace"), METHODS, "laptop", device="cpu").run(listener)
    assert not listener.steps


def test_boosted_trees_are_fitted_once(road: Road, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(road.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    fitted = []
    fit = trees_answers.fit_trees
    monkeypatch.setattr(trees_answers, "fit_trees", lambda *given, **named: fitted.append(named) or fit(*given, **named))
    outcome = Evaluate(workspace, METHODS[:1], device="cpu").run(Listener())
    assert not fitted
    assert "trees" in {row[0] for row in outcome.data["parts_given"]["overview_micro"]["rows"]}
    Evaluate(workspace, METHODS[:1], device="cpu", seed=1).run(Listener())
    assert fitted == [{"seed": 1}]


@pytest.mark.parametrize("text", ["[]", '{"made_from": 3, "ans'])
def test_kept_answers_that_are_garbled_are_made_again(text: str, road: Road, tmp_path: Path) -> None:
    shutil.copytree(road.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    workspace.forget("eval-all")
    before = contents(workspace.path)
    for path in (workspace.evaluation / "trees.json", *(workspace.evaluation / "judgements").rglob("*.json")):
        path.write_text(text, encoding="utf-8")
    replace(road.stages["eval"], workspace=workspace).run(Listener())  # type: ignore[type-var]
    after = {path: hash for path, hash in contents(workspace.path).items() if path != "records/eval-all.json"}
    assert after == before
