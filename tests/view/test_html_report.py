"""The report of a workspace: what it shows, in which order, and from which files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from browser import READY, assert_shown_without_complaint, needs_browser, needs_driven_browser, open_page
from trained_workspace import Recorder, Trained

from kinmo.core.errors import InputError
from kinmo.dataset.journal import runs
from kinmo.dataset.store import INDEX
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import METRICS
from kinmo.pipeline.evaluation.example_predictions import read_examples
from kinmo.view.html_report import MAX_PICTURES, PICTURED_TOGETHER, Report, SceneBudget


def html_of(trained: Trained) -> str:
    return trained.outcomes["report"].path.read_text(encoding="utf-8")


def test_curves_are_named_by_their_networks(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.prepared.mkdir()
    (workspace.prepared / INDEX).touch()
    for place in ("gnn_fine", "gnn_fine/Pliers", "axis/Pliers", "ancsh/Pliers/semi-weakly-kinmo/0/npcs"):
        (workspace.models / place).mkdir(parents=True)
        epochs = [{"epoch": epoch, "training/loss": 1.0, "validation/loss": 1.0} for epoch in (0, 1)]
        (workspace.models / place / METRICS).write_text(json.dumps(epochs), encoding="utf-8")
    html = Report(workspace).run(Recorder()).path.read_text(encoding="utf-8")
    for name in ("gnn_fine", "gnn_fine Pliers", "axis Pliers", "Pliers semi-weakly-kinmo 0 npcs"):
        assert f">{name}: loss<" in html


def test_the_report_names_all_runs(trained: Trained) -> None:
    html = html_of(trained)
    for run in runs(trained.workspace):
        assert run.stage in html
    for title in ("Table 1, parts given", "Table 1, hierarchy given", "Training", "Pseudo labels by kinmo", "Data", "Runs"):
        assert title in html


def test_pictures_come_first_then_summaries_then_folded_details(trained: Trained) -> None:
    html = html_of(trained)
    titles = trained.outcomes["report"].data["sections"]
    tables = [titles.index(title) for title in titles if title.startswith("Table 1")]
    details = [titles.index(title) for title in ("Data", "Pseudo labels by kinmo", "Training", "Runs")]
    pictures = [place for place, title in enumerate(titles) if title.endswith((": right", ": wrong"))]
    assert pictures and max(pictures) < min(tables) and max(tables) < min(details)
    folded = re.findall(r"<details><summary><h2>([^<]*)</h2>", html)
    assert folded == [titles[place] for place in sorted(details)]


def test_every_table_of_an_evaluation_is_in_the_report(trained: Trained) -> None:
    html = html_of(trained)
    for setting in ("parts_given", "hierarchy_given"):
        for table in trained.outcomes["eval"].data[setting].values():
            assert table["caption"].split(".")[0].replace("'", "&#39;") in html


def test_the_report_counts_shapes_by_outcome(trained: Trained) -> None:
    counts = {name: len(entries) for name, entries in trained.outcomes["prepare"].data.items()}
    assert f"{counts['included']} included, {counts['repaired']} repaired, {counts['skipped']} skipped." in html_of(trained)


@needs_browser
@pytest.mark.parametrize("width", [400, 1200])
def test_a_browser_shows_the_report_without_complaint(width: int, trained: Trained, tmp_path: Path) -> None:
    assert_shown_without_complaint(html_of(trained), width, tmp_path)


def test_there_is_a_picture_for_each_joint_and_row(trained: Trained) -> None:
    examples = read_examples(trained.outcomes["eval"].path / "examples.jsonl")
    pictured = [row for example in examples for row, _ in PICTURED_TOGETHER if row in example.predictions]
    assert len(examples) < MAX_PICTURES
    assert html_of(trained).count('<svg class="object"') == len(pictured) > 0


def test_a_shape_that_is_gone_has_no_picture_and_a_note(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    index = workspace.prepared / INDEX
    index.write_text(index.read_text(encoding="utf-8").replace(str(trained.shapes), str(tmp_path / "gone")), encoding="utf-8")
    recorder = Recorder()
    html = Report(workspace).run(recorder).path.read_text(encoding="utf-8")
    assert '<svg class="object"' not in html
    assert recorder.notes and all(note.startswith("no picture of ") for note in recorder.notes)


def test_the_report_of_a_workspace_without_evaluation_has_no_pictures(trained: Trained, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "workspace", prepared=trained.workspace.prepared)
    outcome = Report(workspace).run(Recorder())
    assert outcome.data["sections"] == ["Data", "Runs"]


@pytest.mark.parametrize(
    "file", ["models/gnn_fine/metrics.json", "pseudo_labels/kinmo/acceptance.json", "prepared/report.json"]
)
@pytest.mark.parametrize("text", ["{", "[1]"])
def test_a_damaged_file_is_named(file: str, text: str, trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    (workspace.path / file).write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=Path(file).stem):
        Report(workspace).run(Recorder())


def test_a_dry_run_names_the_page(trained: Trained) -> None:
    plan = Report(trained.workspace).plan()
    assert plan.steps == (f"write {trained.workspace.report / 'index.html'}",)
    assert plan.seconds > 1.0


def test_a_report_needs_prepared_shapes(tmp_path: Path) -> None:
    report = Report(Workspace(tmp_path))
    for call in (report.plan, lambda: report.run(Recorder())):
        with pytest.raises(InputError, match="run kinmo prepare first"):
            call()


@needs_driven_browser
@pytest.mark.parametrize("width", [1280, 390])
def test_every_picture_can_be_seen_in_3d(width: int, trained: Trained) -> None:
    html = trained.outcomes["report"].path
    with open_page(html.as_uri(), width) as shown:
        buttons = shown.page.locator(".open3d")
        assert buttons.count() == html_of(trained).count('<svg class="object"')
        for place in (0, buttons.count() - 1):
            buttons.nth(place).click()
            shown.page.wait_for_selector(READY)
            assert "true joint" in shown.page.inner_text("#viewer3d")
            assert not shown.scrolls_sideways()
            shown.page.get_by_text("Close", exact=True).click()
            shown.page.wait_for_selector("#viewer3d canvas", state="detached")
        assert not shown.complaints


def test_objects_beyond_the_budget_are_counted() -> None:
    budget = SceneBudget(left=10)
    assert (budget.take("12345678"), budget.take("123"), budget.take("12")) == ("12345678", "", "12")
    assert budget.note().startswith("1 of them without 3D") and budget.note() == ""
