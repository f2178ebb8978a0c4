"""Evaluation of all trained networks for scans."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, FAMILY, Scanned
from trained_workspace import Recorder

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.evaluate_all import EvaluateAll
from kinmo.experiments.scan_tables.evaluate_trained import EvaluateTrained
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN
from kinmo.experiments.scan_tables.table_rows import printed_row
from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes
from kinmo.pipeline.prepare_shapes import Prepare
from kinmo.pipeline.scans.scan_networks import NETWORKS, ScanRun, trained_runs
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.synth.synth_stage import Synth

RUN = ScanRun(CATEGORY, "supervised", 0)


def test_trained_networks_are_evaluated_if_there_are_scans(scanned: Scanned) -> None:
    stage = EvaluateTrained(scanned.workspace, FAMILY, device="cpu")
    found = stage.run(Recorder())
    assert list(found.data) == ["table-2"], "no noisy scans, and no category of the other tables"
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    assert list(found.data["table-2"]) == [CATEGORY]


def test_a_category_without_test_objects_is_reported_and_is_no_failure(scanned: Scanned, tmp_path: Path) -> None:
    made, observer = scanned.copied(tmp_path), Recorder()
    made.remove_scans("test")
    stage = EvaluateTrained(made.workspace, FAMILY, device="cpu")
    assert stage.plan().steps == ()
    assert stage.run(observer).failed == 0
    assert [note for note in observer.notes if "not evaluated" in note and "expected scans of a test object" in note]


def test_damaged_networks_are_trained_again_and_unreadable_ones_are_a_failure(scanned: Scanned, tmp_path: Path) -> None:
    made, observer = scanned.copied(tmp_path), Recorder()
    weights = RUN.folder(made.workspace, "npcs") / "weights.safetensors"
    inputs = made.workspace.inputs_of(RUN.stage("npcs"))
    assert inputs is not None
    weights.write_bytes(b"cut off")
    assert trained_runs(made.workspace) == []
    (step,) = made.train().plan().steps
    assert step.startswith("train npcs")
    made.workspace.record(RUN.stage("npcs"), inputs, [weights])
    assert EvaluateTrained(made.workspace, FAMILY, device="cpu").run(observer).failed == 1
    assert [note for note in observer.notes if note.startswith(f"not evaluated: {RUN}: ")]


def test_scans_and_networks_of_categories_that_are_no_longer_prepared_are_ignored(scanned: Scanned, tmp_path: Path) -> None:
    made, gone = scanned.copied(tmp_path), ScanRun("Gone", "supervised", 0)
    workspace = made.workspace
    shutil.copytree(workspace.scans / CATEGORY, workspace.scans / "Gone")
    for network in NETWORKS:
        shutil.copytree(RUN.folder(workspace, network), gone.folder(workspace, network))
        inputs = workspace.inputs_of(RUN.stage(network))
        assert inputs is not None
        workspace.record(gone.stage(network), inputs)
    assert gone in trained_runs(workspace)
    found = EvaluateTrained(workspace, device="cpu").run(Recorder())
    assert (list(found.data["table-2"]), found.failed) == ([CATEGORY], 0)
    assert TrainScans(workspace, made.config, setting="supervised", device="cpu").plan().steps == ()


def test_the_papers_figures_are_shown_before_anything_is_trained(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("scissors",), ("partnet_mobility",)).run(Recorder())
    workspace = Workspace(tmp_path / "workspace")
    Prepare(tmp_path / "partnet", workspace).run(Recorder())
    found = EvaluateTrained(workspace, "scissors", device="cpu").run(Recorder())
    assert set(found.data) == {"table-2", "table-3"}
    for table, rows in (("2", ["ANCSH", "ANCSH (Semi)", "ANCSH (Semi-weakly)"]), ("3", ["Semi-weakly (30%)"])):
        (shown,) = found.data[f"table-{table}"].values()
        titles = shown["parts"]["columns"]
        errors = [row[titles.index("rotation (deg)")] for row in shown["parts"]["rows"] if "authors" in str(row[0])]
        for row in rows:
            printed = printed_row(table, "scissors", row)
            assert printed is not None and set(printed[0]) <= set(errors)
        assert [row for row in shown["means"]["rows"] if NOT_RUN in row]


def test_without_motion_networks_there_are_tables_of_scans_alone(scanned: Scanned) -> None:
    shapes = EvaluateShapes(scanned.workspace, category=FAMILY)
    stage, observer = EvaluateAll(shapes, EvaluateTrained(scanned.workspace, FAMILY, device="cpu")), Recorder()
    stage.plan()
    found = stage.run(observer)
    assert list(found.data) == ["table-2"]
    assert [note for note in observer.notes if note.startswith("no Table 1:")]
    unknown = EvaluateAll(replace(shapes, category="fridge"), EvaluateTrained(scanned.workspace, "fridge", device="cpu"))
    for ask in (unknown.plan, lambda: unknown.run(observer)):
        with pytest.raises(InputError, match="fridge"):
            ask()
