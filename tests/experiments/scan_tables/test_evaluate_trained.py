"""Judging whatever networks there are."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from scan_road import CATEGORY, FAMILY, Scanned
from trained_workspace import Recorder

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.evaluate_all import EvaluateAll
from kinmo.experiments.scan_tables.evaluate_trained import JudgeTrained
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN
from kinmo.experiments.scan_tables.table_rows import printed_row
from kinmo.experiments.table1.evaluate_table1 import Evaluate
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.scans.scan_networks import NETWORKS, Cell, trained_cells
from kinmo.pipeline.scans.train_scans import TrainAncsh
from kinmo.synth.synth_stage import Synth


def test_what_is_trained_is_judged_where_there_are_scans_of_it(scanned: Scanned) -> None:
    stage = JudgeTrained(scanned.workspace, FAMILY, device="cpu")
    found = stage.run(Recorder())
    assert list(found.data) == ["table-2"], "no rough scans, and no category of the other tables"
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    assert list(found.data["table-2"]) == [CATEGORY]


def test_a_category_without_test_objects_is_said_to_be_not_judged(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "test")
    stage, told = JudgeTrained(Workspace(tmp_path / "workspace"), FAMILY, device="cpu"), Recorder()
    assert stage.plan().steps == ()
    assert stage.run(told).failed == 0
    assert [note for note in told.notes if "not judged" in note and "expected scans of a test object" in note]


def test_networks_that_cannot_be_judged_are_a_failure(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    workspace, told = Workspace(tmp_path / "workspace"), Recorder()
    (Cell(CATEGORY, "supervised", 0).folder(workspace, "npcs") / "weights.safetensors").write_bytes(b"cut off")
    assert JudgeTrained(workspace, FAMILY, device="cpu").run(told).failed == 1
    assert [note for note in told.notes if note.startswith(f"not judged: {CATEGORY}, supervised, seed 0: ")]


def test_scans_and_networks_of_shapes_that_were_prepared_before_are_passed_over(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    known, gone = Cell(CATEGORY, "supervised", 0), Cell("Gone", "supervised", 0)
    shutil.copytree(workspace.scans / CATEGORY, workspace.scans / "Gone")
    for network in NETWORKS:
        shutil.copytree(known.folder(workspace, network), gone.folder(workspace, network))
        record = workspace.record(known.stage(network))
        assert record is not None
        workspace.write_record(gone.stage(network), record)
    assert gone in trained_cells(workspace)
    found = JudgeTrained(workspace, device="cpu").run(Recorder())
    assert (list(found.data["table-2"]), found.failed) == ([CATEGORY], 0)
    assert TrainAncsh(workspace, scanned.config, setting="supervised", device="cpu").plan().steps == ()


def test_of_a_category_of_the_paper_its_tables_are_shown_with_their_figures_before_anything_is_trained(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("scissors",), ("partnet_mobility",)).run(Recorder())
    workspace = Workspace(tmp_path / "workspace")
    Prepare(tmp_path / "partnet", workspace).run(Recorder())
    found = JudgeTrained(workspace, "scissors", device="cpu").run(Recorder())
    assert set(found.data) == {"table-2", "table-3"}
    for table, rows in (("2", ["ANCSH", "ANCSH (Semi)", "ANCSH (Semi-weakly)"]), ("3", ["Semi-weakly (30%)"])):
        (shown,) = found.data[f"table-{table}"].values()
        titles = shown["parts"]["columns"]
        turned = [row[titles.index("rotation (deg)")] for row in shown["parts"]["rows"] if "authors" in str(row[0])]
        for row in rows:
            printed = printed_row(table, "scissors", row)
            assert printed is not None and set(printed[0]) <= set(turned)
        assert [row for row in shown["means"]["rows"] if NOT_RUN in row]


def test_without_motion_networks_the_tables_of_scans_are_there_alone(scanned: Scanned) -> None:
    shapes = Evaluate(scanned.workspace, ("kinmo", "paper"), FAMILY)
    stage, told = EvaluateAll(shapes, JudgeTrained(scanned.workspace, FAMILY, device="cpu")), Recorder()
    found = stage.run(told)
    assert list(found.data) == ["table-2"]
    assert [note for note in told.notes if note.startswith("no Table 1:")]
    unknown = EvaluateAll(replace(shapes, category="fridge"), JudgeTrained(scanned.workspace, "fridge", device="cpu"))
    for ask in (unknown.plan, lambda: unknown.run(told)):
        with pytest.raises(InputError, match="fridge"):
            ask()
