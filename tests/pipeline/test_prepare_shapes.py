"""The stage that prepares shapes: notes about oracle labels and lost shapes, and its summary."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from datasets import write_partnet
from trained_workspace import Recorder, Trained

from kinmo.core.errors import InputError
from kinmo.dataset.folder_preparation import ORACLE, PreparationReport, ReportEntry
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.prepare_shapes import MAX_LINES, REPORT, Prepare, summary
from kinmo.synth.synth_stage import Synth


def test_labels_beside_their_hidden_copies_are_noted_unless_they_are_oracle_labels(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("pliers",), ("partnet",), oracle=True).run(Recorder())
    folder, workspace = tmp_path / "partnet" / ORACLE, Workspace(tmp_path / "workspace")
    warning = f"{folder}: included as labelled shapes; with --oracle {folder} nothing is trained on their labels"
    for oracle in ((), (folder,), (tmp_path / "partnet",)):
        recorder = Recorder()
        Prepare(tmp_path / "partnet", workspace, oracle=oracle).run(recorder)
        assert (warning in recorder.notes) is not bool(oracle)
        assert bool(open_dataset(workspace).oracle) is bool(oracle)


def test_a_folder_without_oracle_labels_is_noted(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("pliers",), ("partnet",)).run(Recorder())
    recorder, other = Recorder(), tmp_path / "other"
    other.mkdir()
    Prepare(tmp_path / "partnet", Workspace(tmp_path / "workspace"), oracle=(other,)).run(recorder)
    assert recorder.notes == [f"{other}: no shape at or below it was prepared, so there are no oracle labels from it"]


def test_shapes_that_a_workspace_loses_are_counted(trained: Trained, tmp_path: Path) -> None:
    workspace, recorder = Workspace(tmp_path / "workspace"), Recorder()
    shutil.copytree(trained.workspace.prepared, workspace.prepared)
    Prepare(trained.shapes, workspace).run(recorder)
    assert recorder.notes == []
    Prepare(trained.shapes / "partnet", workspace).run(recorder)
    lost = len(PreparedStore(trained.workspace.prepared)) - len(PreparedStore(workspace.prepared))
    assert [note.split()[0] for note in recorder.notes] == [str(lost)] != ["0"]


def test_the_report_lists_every_shape_by_outcome(tmp_path: Path) -> None:
    for name in ("good", "bad"):
        write_partnet(tmp_path / "shapes" / name)
    (tmp_path / "shapes" / "bad" / "result.json").write_text("[{", encoding="utf-8")
    outcome = Prepare(tmp_path / "shapes", Workspace(tmp_path / "workspace")).run(Recorder())
    assert outcome.failed == 0
    assert json.loads((outcome.path / REPORT).read_text(encoding="utf-8")) == outcome.data
    assert [entry["id"] for entry in outcome.data["included"]] == ["good"]
    (skipped,) = outcome.data["skipped"]
    assert skipped["id"] == "bad" and "result.json" in skipped["reasons"][0]
    assert "skipped        1" in outcome.text


def test_the_stage_fails_if_no_shape_can_be_prepared(tmp_path: Path) -> None:
    write_partnet(tmp_path / "shapes" / "bad")
    (tmp_path / "shapes" / "bad" / "result.json").write_text("[{", encoding="utf-8")
    recorder = Recorder()
    assert Prepare(tmp_path / "shapes", Workspace(tmp_path / "workspace")).run(recorder).failed == 1
    assert recorder.notes[0].startswith("no shape could be prepared: ")


def test_a_folder_without_shapes_is_refused_in_a_dry_run_too(tmp_path: Path) -> None:
    stage = Prepare(tmp_path, Workspace(tmp_path / "workspace"))
    for call in (stage.plan, lambda: stage.run(Recorder())):
        with pytest.raises(InputError, match="expected at least one shape at or below it"):
            call()
    assert not list(tmp_path.iterdir())


def test_the_summary_counts_repairs_by_kind_and_lists_some_skipped_shapes() -> None:
    repairs = [f"joint of door {place}: direction of length {place}.5 normalised" for place in range(3)]
    repaired = [ReportEntry(str(place), "", (repair,)) for place, repair in enumerate(repairs)]
    skipped = [ReportEntry(str(place), "", (f"{place}: unreadable",)) for place in range(MAX_LINES + 2)]
    lines = summary(PreparationReport(repaired=repaired, skipped=skipped)).splitlines()
    assert "3  joint: direction of length # normalised" in lines[2]
    assert len(lines) == 3 + 1 + MAX_LINES + 1
    assert lines[-1].endswith("and 2 more; report.json and --json list all")
