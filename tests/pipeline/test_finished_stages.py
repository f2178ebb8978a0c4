"""All stages: a finished one is not run again, and damaged files are named or made again."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from trained_workspace import METHODS, Recorder, Trained, contents

from kinmo.core.errors import InputError
from kinmo.dataset.journal import runs
from kinmo.dataset.stage import Stage
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes
from kinmo.pipeline.pseudo_label_shapes import PseudoLabel
from kinmo.pipeline.train_motion import TrainMotion

STAGES = ("synth", "prepare", "train", "pseudo-label", "eval")


def test_every_stage_has_a_result_that_exists(trained: Trained) -> None:
    for name, outcome in trained.outcomes.items():
        assert outcome.path.exists(), name
        assert outcome.failed == 0
        json.dumps(outcome.data)


@pytest.mark.parametrize("name", STAGES)
def test_a_finished_stage_is_not_run_again(name: str, trained: Trained) -> None:
    folder = trained.workspace.path if name != "synth" else trained.shapes
    caches = {path: path.read_bytes() for path in folder.rglob(".kinmo.jsonl")}
    before, entries = contents(folder), len(runs(trained.workspace))
    again = trained.stages[name].run(Recorder())
    assert contents(folder) == before
    assert {path: path.read_bytes() for path in folder.rglob(".kinmo.jsonl")} == caches
    assert len(runs(trained.workspace)) == entries, "the journal has another run"
    assert again.path == trained.outcomes[name].path
    if name != "synth":
        assert again.data == trained.outcomes[name].data


@pytest.mark.parametrize("name", ["synth", "train", "pseudo-label", "eval"])
def test_a_dry_run_of_a_finished_stage_has_nothing_to_do(name: str, trained: Trained) -> None:
    plan = trained.stages[name].plan()
    assert plan.steps == () and plan.seconds == 0


def test_a_copied_workspace_is_up_to_date(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    for path in workspace.path.rglob("*"):
        path.touch()
    for name in ("train", "pseudo-label", "eval"):
        assert replace(trained.stages[name], workspace=workspace).plan().steps == (), name  # type: ignore[type-var]


@pytest.mark.parametrize(
    ("file", "text", "stages"),
    [
        ("models/ranking/weights.safetensors", "cut", ("eval", "pseudo-label")),
        ("models/ranking/weights.json", "[]", ("eval", "pseudo-label")),
        ("models/gnn_fine/metrics.json", "[1]", ("report",)),
        ("models/config.json", "{", ("eval",)),
        ("prepared/index.jsonl", "{}", ("train", "eval", "pseudo-label", "report")),
        ("pseudo_labels/kinmo/acceptance.json", "{}", ("report",)),
    ],
)
def test_a_damaged_file_is_named_and_nothing_is_lost(
    file: str, text: str, stages: tuple[str, ...], trained: Trained, tmp_path: Path
) -> None:
    workspace = trained.copy(tmp_path)
    (workspace.path / file).write_text(text, encoding="utf-8")
    before = contents(tmp_path)
    for name in stages:
        stage = replace(trained.stages[name], workspace=workspace)  # type: ignore[type-var]
        with pytest.raises(InputError, match=Path(file).stem):
            stage.run(Recorder())
        assert contents(tmp_path) == before, name


@pytest.mark.parametrize(
    ("file", "stage"),
    [
        ("models/gnn_fine/metrics.json", "train"),
        ("models/ranking/weights.safetensors", "train"),
        ("models/axis/weights.json", "train"),
        ("pseudo_labels/kinmo/acceptance.json", "pseudo-label"),
        ("evaluation/all/examples.jsonl", "eval"),
        ("evaluation/all/parts_given/angle.json", "eval"),
    ],
)
def test_a_damaged_result_is_made_again(file: str, stage: str, trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    again = replace(trained.stages[stage], workspace=workspace)  # type: ignore[type-var]
    assert again.plan().steps == ()
    damaged = workspace.path / file
    damaged.write_bytes(damaged.read_bytes()[:-3])
    assert len(again.plan().steps) == 1


@pytest.mark.parametrize(
    "stage",
    [
        TrainMotion("motion", Workspace("nowhere"), "small"),
        EvaluateShapes(Workspace("nowhere"), METHODS),
        PseudoLabel(Workspace("nowhere")),
    ],
)
def test_a_stage_without_inputs_names_the_command_to_run_first(
    stage: Stage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="run kinmo prepare first"):
        stage.run(Recorder())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["eval", "pseudo-label"])
def test_a_stage_without_networks_names_the_command_to_run_first(name: str, trained: Trained, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "workspace", prepared=trained.workspace.prepared)
    stage = replace(trained.stages[name], workspace=workspace)  # type: ignore[type-var]
    for call in (stage.plan, lambda: stage.run(Recorder())):
        with pytest.raises(InputError, match="run kinmo train motion first"):
            call()
    assert not workspace.path.exists()
