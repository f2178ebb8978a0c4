"""Tables are those of the workspace as it is now, or they are not shown."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from trained_workspace import METHODS, Recorder, Trained

from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1.evaluate_table1 import Evaluate
from kinmo.experiments.table1.evaluation_folder import ALL, Choice, evaluations, is_current, stage_of
from kinmo.view.report import OUTDATED, Report

TABLE = "Table 1, parts given"


@pytest.fixture
def workspace(trained: Trained, tmp_path: Path) -> Workspace:
    """A copy of the workspace that has gone the whole trained."""
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    return Workspace(tmp_path / "workspace")


def page(workspace: Workspace) -> str:
    return Report(workspace).run(Recorder()).path.read_text(encoding="utf-8")


def retrain(workspace: Workspace, model: str) -> None:
    """What is left of a training with another result, as far as digests go."""
    path = workspace.models / model / "weights.json"
    header = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**header, "sha256": "0" * 64}), encoding="utf-8")


def test_no_table_of_a_former_choice_stays(workspace: Workspace) -> None:
    assert list((workspace.evaluation / ALL).rglob("*OBB_fine*"))
    outcome = Evaluate(workspace, ("kinmo",), device="cpu").run(Recorder())
    assert not list((workspace.evaluation / ALL).rglob("*OBB_fine*"))
    assert not {"GNN_fine", "OBB_fine"} & {row[0] for row in outcome.data["parts_given"]["overview_micro"]["rows"]}
    assert "labels of kinmo" in page(workspace) and "labels of OBB_fine" not in page(workspace)


@pytest.mark.parametrize("model", ["ranking", "axis", "gnn_coarse"])
def test_the_report_leaves_out_what_other_weights_gave(model: str, workspace: Workspace) -> None:
    assert TABLE in page(workspace)
    retrain(workspace, model)
    html = page(workspace)
    assert TABLE not in html and OUTDATED in html
    assert 'class="object"' not in html


def test_the_report_leaves_out_what_was_not_finished(workspace: Workspace) -> None:
    workspace.forget(stage_of(ALL))
    assert OUTDATED in page(workspace)


def test_weights_that_have_no_say_do_not_matter(workspace: Workspace) -> None:
    Evaluate(workspace, ("kinmo",), device="cpu").run(Recorder())
    retrain(workspace, "axis")
    assert is_current(workspace, ALL)


def test_shapes_and_settings_that_change_make_an_evaluation_stale(workspace: Workspace) -> None:
    config = workspace.models / "config.json"
    table = json.loads(config.read_text(encoding="utf-8"))
    table["refinement"]["threshold"] = 0.123
    assert is_current(workspace, ALL)
    config.write_text(json.dumps(table), encoding="utf-8")
    assert not is_current(workspace, ALL)


@pytest.mark.parametrize("change", [{"seed": 1}, {"ablations": True}, {"hidden_names": True}, {"methods": METHODS[:1]}])
def test_another_choice_is_another_evaluation(change: dict[str, object], trained: Trained) -> None:
    assert not trained.stages["eval"].plan().steps
    assert replace(trained.stages["eval"], **change).plan().steps  # type: ignore[type-var]


def test_one_category_has_one_folder_whatever_its_spelling(workspace: Workspace) -> None:
    for name in ("laptop", "Lap top", "LAPTOP"):
        outcome = Evaluate(workspace, ("kinmo",), name, device="cpu").run(Recorder())
        assert outcome.path == workspace.evaluation / "laptop"
    assert evaluations(workspace) == [ALL, "laptop"]
    assert is_current(workspace, ALL) and is_current(workspace, "laptop")


def test_no_category_leads_out_of_the_folder() -> None:
    assert Path(Choice(METHODS, "../../x").name).parts == (Choice(METHODS, "../../x").name,)


def test_labels_of_former_networks_are_called_so(workspace: Workspace) -> None:
    assert "labels up to date" not in page(workspace)
    retrain(workspace, "ranking")
    assert "labels up to date" in page(workspace)
