"""Evaluation on shapes: the rows and figures of Table 1, and results that are made once."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from trained_workspace import METHODS, Recorder, Trained, copy_without, tiny_config

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1 import baselines as baselines_module
from kinmo.experiments.table1.ablations import CONTACT_EDGES, AblationRows
from kinmo.experiments.table1.baselines import PaperBaselines
from kinmo.learning.model_folder import ModelFolder
from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes
from kinmo.pipeline.evaluation.evaluation_folder import SETTINGS
from kinmo.pipeline.evaluation.example_predictions import read_examples
from kinmo.pipeline.train_motion import TrainMotion

METHOD_ROWS = ("kinmo", "GNN_coarse", "OBB_coarse", "GNN_fine", "OBB_fine")


class InterruptedRecorder(Recorder):
    """Presses Ctrl-C when the first shape is scored."""

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        super().progress(what, done, total, detail)
        if what == "evaluating shapes":
            raise KeyboardInterrupt


def scored_shapes(recorder: Recorder) -> int:
    return recorder.steps.count("evaluating shapes")


def test_tables_have_rows_of_both_methods_and_of_baselines_in_both_settings(trained: Trained) -> None:
    for setting in SETTINGS:
        for table in ("overview_micro", "summary"):
            rows = [row[0] for row in trained.outcomes["eval"].data[setting][table]["rows"]]
            assert [name for name in rows if name in METHOD_ROWS] == list(METHOD_ROWS)
            assert {"upper bound, paper's candidates", "upper bound, all candidates", "no learning"} <= set(rows)
        for ending in ("txt", "json", "csv", "md", "tex"):
            assert (trained.outcomes["eval"].path / setting / f"angle.{ending}").exists()


def test_one_short_table_per_setting_is_printed(trained: Trained) -> None:
    text = trained.outcomes["eval"].text
    assert [line for line in text.splitlines() if line.startswith("Table 1")] == [
        "Table 1, parts given.",
        "Table 1, hierarchy given.",
    ]
    assert "--details" in text


def test_axes_are_also_scored_with_the_true_type_given(trained: Trained) -> None:
    table = trained.outcomes["eval"].data["parts_given"]["overview_micro"]
    place = table["columns"].index("axis, type given (deg)")
    assert all(0.0 <= row[place] <= 90.0 for row in table["rows"] if row[0] in METHOD_ROWS)
    summary = json.loads((trained.outcomes["eval"].path / "summaries" / "parts_given.json").read_text(encoding="utf-8"))
    for row in METHOD_ROWS:
        figures = summary[row]["micro"]
        assert figures["typed_axis"]["count"] >= figures["axis"]["count"]


def test_every_true_joint_of_the_test_shapes_has_an_example(trained: Trained) -> None:
    examples = read_examples(trained.outcomes["eval"].path / "examples.jsonl")
    table = trained.outcomes["eval"].data["parts_given"]["overview_micro"]
    joints = table["rows"][0][table["columns"].index("joints")]
    assert len(examples) == joints > 0


def test_tables_state_the_share_of_penetration(trained: Trained) -> None:
    for setting in SETTINGS:
        table = trained.outcomes["eval"].data[setting]["overview_micro"]
        place = table["columns"].index("penetration")
        shares = [row[place] for row in table["rows"] if row[place] is not None]
        assert shares and all(0.0 <= share <= 1.0 for share in shares)


def test_edges_are_scored_where_a_method_predicts_their_types(trained: Trained) -> None:
    table = trained.outcomes["eval"].data["parts_given"]["overview_micro"]
    place = table["columns"].index("edges")
    edges = {row[0]: row[place] for row in table["rows"]}
    assert edges["kinmo"] is None
    assert all(0.0 <= edges[name] <= 1.0 for name in ("GNN_coarse", "GNN_fine", "OBB_fine"))


def test_every_figure_has_its_interval_in_the_summaries(trained: Trained) -> None:
    for setting in SETTINGS:
        found = json.loads((trained.outcomes["eval"].path / "summaries" / f"{setting}.json").read_text(encoding="utf-8"))
        for summary in found.values():
            figures = [figure for figure in summary["micro"].values() if figure is not None]
            assert figures and all(figure["low"] <= figure["high"] for figure in figures)


def test_categories_match_whatever_their_spelling(trained: Trained) -> None:
    plans = [EvaluateShapes(trained.workspace, METHODS, name, device="cpu").plan().steps for name in ("Pliers", "PLIERS")]
    assert plans[0] == plans[1] != ()
    with pytest.raises(InputError, match="Stapler"):
        EvaluateShapes(trained.workspace, METHODS, "spoon").plan()


def test_an_unknown_method_is_refused(trained: Trained) -> None:
    with pytest.raises(InputError, match="methods: expected one of kinmo, paper, got magic"):
        EvaluateShapes(trained.workspace, ("magic",)).plan()


def test_rows_of_contact_edges_need_their_network(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    stage = EvaluateShapes(workspace, ("paper",), "pliers", more_rows=AblationRows(ablations=True), device="cpu")

    def rows(recorder: Recorder) -> list[str]:
        table = stage.run(recorder).data["parts_given"]["overview_micro"]
        assert ("not trained (kinmo train contact-edges)" in table["caption"]) is bool(recorder.notes)
        return [row[0] for row in table["rows"]]

    recorder = Recorder()
    assert CONTACT_EDGES not in rows(recorder)
    assert recorder.notes == ["No rows of contact edges: their network is not trained (kinmo train contact-edges)."]
    TrainMotion("contact-edges", workspace, str(tiny_config(tmp_path)), device="cpu").run(Recorder())
    recorder = Recorder()
    assert CONTACT_EDGES in rows(recorder)
    assert recorder.notes == []


def test_an_interrupted_evaluation_continues(trained: Trained, tmp_path: Path) -> None:
    workspace = copy_without(trained, tmp_path, ["eval"])
    stage = replace(trained.stages["eval"], workspace=workspace)  # type: ignore[type-var]
    with pytest.raises(KeyboardInterrupt):
        stage.run(InterruptedRecorder())
    assert not (workspace.evaluation / "all").exists()
    recorder = Recorder()
    assert stage.run(recorder).data == trained.outcomes["eval"].data
    total = len(list((trained.workspace.evaluation / "shape_scores").glob("*.json")))
    assert scored_shapes(recorder) == total - 1


def test_a_shape_is_scored_once_for_all_evaluations_with_the_same_rows(trained: Trained, tmp_path: Path) -> None:
    stage = replace(trained.stages["eval"], workspace=trained.copy(tmp_path), category="pliers", more_tables=None)  # type: ignore[type-var]
    recorder = Recorder()
    stage.run(recorder)
    assert scored_shapes(recorder) == 0


def test_boosted_trees_are_trained_once(trained: Trained, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    workspace = trained.copy(tmp_path)
    seeds = []
    fit = baselines_module.fit_trees
    monkeypatch.setattr(baselines_module, "fit_trees", lambda shapes, seed: seeds.append(seed) or fit(shapes, seed=seed))
    refinement = ModelFolder(workspace.models).config().refinement
    stage = EvaluateShapes(workspace, METHODS[:1], baselines=PaperBaselines(refinement), device="cpu")
    outcome = stage.run(Recorder())
    assert seeds == []
    assert "trees" in {row[0] for row in outcome.data["parts_given"]["overview_micro"]["rows"]}
    replace(stage, baselines=PaperBaselines(refinement, seed=1)).run(Recorder())
    assert seeds == [1]


@pytest.mark.parametrize("text", ["[]", '{"key": 3, "dat'])
def test_garbled_results_are_made_again(text: str, trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    workspace.forget("evaluate-all")
    before = {path: path.read_bytes() for path in workspace.evaluation.rglob("*.json")}
    caches = list(workspace.evaluation.rglob(".kinmo.jsonl"))
    scores = list((workspace.evaluation / "shape_scores").glob("*.json"))
    assert len(caches) == 2 and scores
    for path in (*caches, *scores):
        path.write_text(text, encoding="utf-8")
    stage = replace(trained.stages["eval"], workspace=workspace)  # type: ignore[type-var]
    assert stage.run(Recorder()).data == trained.outcomes["eval"].data
    assert {path: path.read_bytes() for path in workspace.evaluation.rglob("*.json")} == before


def test_a_shape_that_is_gone_is_named(trained: Trained, tmp_path: Path) -> None:
    workspace = copy_without(trained, tmp_path, ["eval"])
    index = workspace.prepared / "index.jsonl"
    index.write_text(index.read_text(encoding="utf-8").replace(str(trained.shapes), str(tmp_path / "gone")), encoding="utf-8")
    stage = replace(trained.stages["eval"], workspace=workspace)  # type: ignore[type-var]
    with pytest.raises(InputError, match="gone"):
        stage.run(Recorder())
    assert not (workspace.evaluation / "all").exists()


def test_a_failing_row_misses_all_joints_of_the_shape(
    trained: Trained, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from kinmo.methods.kinmo.kinmo_method import KinmoMethod

    def fail(*given: object) -> None:
        raise ValueError("no axis")

    workspace = Workspace(tmp_path / "workspace")
    shutil.copytree(trained.workspace.path, workspace.path)
    monkeypatch.setattr(KinmoMethod, "predict_given", fail)
    recorder = Recorder()
    outcome = EvaluateShapes(workspace, ("kinmo",), "pliers", device="cpu").run(recorder)
    assert any(note.startswith("failed: kinmo on ") and note.endswith(": no axis") for note in recorder.notes)
    table = outcome.data["parts_given"]["overview_micro"]
    assert "predictions failed and count as missed." in table["caption"]
    assert table["rows"][0][table["columns"].index("missed")] == 1.0
