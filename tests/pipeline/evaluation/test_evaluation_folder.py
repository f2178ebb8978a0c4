"""The report shows the tables of an evaluation only while nothing has changed that they depend on."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from trained_workspace import METHODS, Recorder, Trained

from kinmo.dataset.store import INDEX
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.label_truth import label_truth_tables
from kinmo.experiments.table1.ablations import AblationRows
from kinmo.experiments.table1.baselines import PaperBaselines
from kinmo.learning.model_folder import ModelFolder
from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes
from kinmo.pipeline.evaluation.evaluation_folder import EvaluationFolder, evaluation_folders
from kinmo.view.html_report import OUTDATED, RELABEL, Report

TABLE = "Table 1, parts given"


@pytest.fixture
def workspace(trained: Trained, tmp_path: Path) -> Workspace:
    """A copy of the trained workspace."""
    return trained.copy(tmp_path)


def page(workspace: Workspace) -> str:
    return Report(workspace).run(Recorder()).path.read_text(encoding="utf-8")


def retrain(workspace: Workspace, model: str) -> None:
    """Change the header of a network as a training with another result does."""
    path = workspace.models / model / "weights.json"
    header = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**header, "sha256": "0" * 64}), encoding="utf-8")


def test_an_evaluation_of_fewer_methods_leaves_no_tables_of_others(workspace: Workspace) -> None:
    folder = EvaluationFolder(workspace).path
    assert list(folder.rglob("*OBB_fine*"))
    outcome = EvaluateShapes(workspace, ("kinmo",), more_tables=label_truth_tables, device="cpu").run(Recorder())
    assert not list(folder.rglob("*OBB_fine*"))
    assert not {"GNN_fine", "OBB_fine"} & {row[0] for row in outcome.data["parts_given"]["overview_micro"]["rows"]}
    html = page(workspace)
    assert "pseudo labels of kinmo" in html and "pseudo labels of OBB_fine" not in html


@pytest.mark.parametrize("model", ["ranking", "axis", "gnn_coarse"])
def test_the_report_hides_tables_and_pictures_of_earlier_networks(model: str, workspace: Workspace) -> None:
    assert TABLE in page(workspace)
    retrain(workspace, model)
    html = page(workspace)
    assert TABLE not in html and OUTDATED in html
    assert 'class="object"' not in html


def test_the_report_hides_the_tables_of_an_interrupted_evaluation(workspace: Workspace) -> None:
    workspace.forget(EvaluationFolder(workspace).stage)
    assert OUTDATED in page(workspace)


def test_networks_that_an_evaluation_does_not_use_do_not_matter(workspace: Workspace) -> None:
    EvaluateShapes(workspace, ("kinmo",), device="cpu").run(Recorder())
    retrain(workspace, "axis")
    assert EvaluationFolder(workspace).is_current


def test_other_settings_make_an_evaluation_outdated(workspace: Workspace) -> None:
    config = workspace.models / "config.json"
    table = json.loads(config.read_text(encoding="utf-8"))
    table["refinement"]["threshold"] = 0.123
    assert EvaluationFolder(workspace).is_current
    config.write_text(json.dumps(table), encoding="utf-8")
    assert not EvaluationFolder(workspace).is_current


@pytest.mark.parametrize("is_test", [True, False])
def test_other_shapes_make_an_evaluation_outdated(is_test: bool, workspace: Workspace) -> None:
    index = workspace.prepared / INDEX
    lines = [json.loads(line) for line in index.read_text(encoding="utf-8").splitlines()]
    tests = {path.stem.rpartition("-")[0] for path in (workspace.evaluation / "shape_scores").glob("*.json")}
    changed = next(
        line for line in lines if line["is_labelled"] and (line["id"] in tests) is is_test and _is_fitted(line, is_test)
    )
    changed["key"] = "another"
    index.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    assert not EvaluationFolder(workspace).is_current


def _is_fitted(line: dict[str, str], is_test: bool) -> bool:
    from kinmo.dataset.splits import Split, split_of

    return is_test or split_of(line["id"]) is Split.TRAIN


def test_a_removed_table_makes_an_evaluation_outdated(workspace: Workspace) -> None:
    (EvaluationFolder(workspace).path / "parts_given" / "angle.json").unlink()
    assert not EvaluationFolder(workspace).is_current


@pytest.mark.parametrize("seed", [0, 1])
def test_another_seed_of_the_baselines_is_another_evaluation(seed: int, trained: Trained) -> None:
    refinement = ModelFolder(trained.workspace.models).config().refinement
    stage = replace(trained.stages["eval"], baselines=PaperBaselines(refinement, seed))  # type: ignore[type-var]
    assert bool(stage.plan().steps) is (seed == 1)


@pytest.mark.parametrize(
    "change",
    [
        {"more_rows": AblationRows(ablations=True)},
        {"more_rows": AblationRows(hidden_names=True)},
        {"methods": METHODS[:1]},
    ],
)
def test_other_rows_or_tables_are_another_evaluation(change: dict[str, object], trained: Trained) -> None:
    assert not trained.stages["eval"].plan().steps
    assert replace(trained.stages["eval"], **change).plan().steps  # type: ignore[type-var]


def test_tables_with_more_than_was_asked_for_stay(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    plain = EvaluateShapes(workspace, METHODS, device="cpu")
    complete = replace(trained.stages["eval"], workspace=workspace)  # type: ignore[type-var]
    assert not plain.plan().steps
    workspace.forget(EvaluationFolder(workspace).stage)
    plain.run(Recorder())
    assert not plain.plan().steps
    assert complete.plan().steps


def test_details_are_printed_without_another_evaluation(trained: Trained) -> None:
    stage = replace(trained.stages["eval"], details=True)  # type: ignore[type-var]
    recorder = Recorder()
    outcome = stage.run(recorder)
    assert recorder.notes == ["already evaluated"]
    assert len(outcome.text) > 2 * len(trained.outcomes["eval"].text)
    assert "axis error in degrees" in outcome.text


def test_a_category_has_one_folder_whatever_its_spelling(workspace: Workspace) -> None:
    for name in ("pliers", "Pli ers", "PLIERS"):
        outcome = EvaluateShapes(workspace, ("kinmo",), name, device="cpu").run(Recorder())
        assert outcome.path == workspace.evaluation / "pliers"
    folders = evaluation_folders(workspace, ("Pliers", "Stapler"))
    assert [folder.name for folder in folders] == ["all", "pliers"]
    assert all(folder.is_current for folder in folders)


def test_a_category_cannot_lead_out_of_the_folder(tmp_path: Path) -> None:
    folder = EvaluationFolder(Workspace(tmp_path), "../../x")
    assert Path(folder.name).parts == (folder.name,)


def test_the_report_says_that_pseudo_labels_are_outdated(workspace: Workspace) -> None:
    assert RELABEL not in page(workspace)
    retrain(workspace, "ranking")
    assert RELABEL in page(workspace)
