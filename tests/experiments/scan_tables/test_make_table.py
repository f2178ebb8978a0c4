"""Making of tables of scans: rows that are done, cannot be run, fail, or would take too long."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, CPU, FAMILY, Scanned
from trained_workspace import Recorder, contents

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.evaluate_trained import EvaluateTrained
from kinmo.experiments.scan_tables.make_table import TOO_LONG, MakeTable
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN
from kinmo.experiments.scan_tables.table_rows import TABLES
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.io.folder_lock import InUse
from kinmo.pipeline.prepare_shapes import Prepare
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.synth.synth_stage import Synth


def table(name: str, made: Scanned, seeds: int = 1, **options: object) -> MakeTable:
    """A table of pliers with the rows of kinmo's method."""
    return MakeTable(name, made.workspace, made.config, ("kinmo",), FAMILY, seeds, **CPU, **options)  # type: ignore[arg-type]


def rows_of(data: dict) -> dict[str, list]:
    return {row[0]: row for row in data[CATEGORY]["means"]["rows"]}


def written(stage: MakeTable) -> str:
    """Text of the written table on one line."""
    folder = WrittenTables(stage.workspace, stage.name).folder / CATEGORY
    return " ".join((folder / "means.md").read_text(encoding="utf-8").split())


def test_a_row_that_cannot_be_run_leaves_the_others(scanned: Scanned, tmp_path: Path) -> None:
    made, observer = scanned.copied(tmp_path), Recorder()
    stage = table("4", made)
    assert stage.plan().steps == (f"{CATEGORY}, supervised, seed 0: evaluate",)
    (other,), planned = stage.plan().impossible, stage.plan().failed
    assert other.startswith(f"{CATEGORY}, generated shapes, seed 0: cannot be run: ") and "DSG-Net" in other
    found = stage.run(observer)
    assert found.failed == planned == 1
    notes = [note for note in observer.notes if note.startswith(f"not run: {CATEGORY}, generated shapes")]
    assert len(notes) == 1 and "DSG-Net" in notes[0]
    run = {row[0]: row[1] for row in found.data[CATEGORY]["parts"]["rows"]}
    assert run == {"supervised": "1", "generated shapes": NOT_RUN, "generated shapes, paper": NOT_RUN}
    reason = "Not run: generated shapes: no shapes of Pliers in DSG-Net's layout without labels."
    assert reason in written(stage)
    WrittenTables(stage.workspace, "4").write({CATEGORY: [0]})
    assert reason in written(stage), "whoever writes the table again"


@pytest.mark.parametrize("name", ["2", "3", "4", "sensors"])
def test_a_plan_writes_nothing(scanned: Scanned, tmp_path: Path, name: str) -> None:
    made = scanned.copied(tmp_path)
    for folder in ("scans", "models"):
        shutil.rmtree(made.workspace.path / folder)
    before = contents(made.workspace.path)
    plan = table(name, made).plan()
    assert plan.steps and plan.seconds > 0.0
    assert contents(made.workspace.path) == before
    assert not (made.workspace.path / "experiments").exists()


def test_in_a_workspace_in_use_no_table_is_written(scanned: Scanned, tmp_path: Path) -> None:
    made, observer = scanned.copied(tmp_path), Recorder()
    for stage in (table("4", made), EvaluateTrained(made.workspace, FAMILY)):
        with made.workspace.locked(), pytest.raises(InUse, match="is writing here"):
            stage.run(observer)
    assert not [note for note in observer.notes if note.startswith("not ")]
    assert not made.workspace.evaluation.exists()


def test_without_oracle_labels_the_row_of_them_is_no_failure(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, (FAMILY,), ("partnet_mobility",)).run(Recorder())
    made, observer = Scanned(Workspace(tmp_path / "workspace"), "small"), Recorder()
    Prepare(tmp_path / "partnet", made.workspace).run(Recorder())
    stage = table("2", made, hours=0.0)
    assert [step.split(":")[0] for step in stage.plan().steps] == [f"{CATEGORY}, supervised, seed 0"]
    found = stage.run(observer)
    assert found.failed == 2, "self-training and semi-weakly: there are no shapes without labels"
    assert [note for note in observer.notes if "oracle labels" in note and "kinmo prepare --oracle" in note]
    assert "Not run: oracle labels: no shapes of Pliers with oracle labels" in written(stage)
    Synth(tmp_path / "partnet", 3, (FAMILY,), ("partnet_mobility",)).run(Recorder())
    Prepare(tmp_path / "partnet", made.workspace).run(Recorder())
    WrittenTables(made.workspace, "2").write({CATEGORY: [0]})
    assert "no shapes of Pliers with oracle labels" not in written(stage), "other shapes may change that"


@pytest.mark.parametrize("is_scanned", [True, False])
def test_without_time_no_row_is_run_and_all_are_reported(scanned: Scanned, tmp_path: Path, is_scanned: bool) -> None:
    made, observer = scanned.copied(tmp_path), Recorder()
    for folder in () if is_scanned else ("scans", "models"):
        shutil.rmtree(made.workspace.path / folder)
    stage = table("2", made, hours=0.0)
    found = stage.run(observer)
    assert not found.failed, "a lack of time is no failure"
    rows = [row for row in TABLES["2"].rows if row.method == "kinmo"]
    assert sum(note.startswith("not run") for note in observer.notes) == len(rows) == len(TABLES["2"].rows) - 1
    text = written(stage)
    for row in rows:
        assert f"Not run: {row.title}: " in text
    assert "Not run: supervised: it would have taken longer than --hours." in text
    assert (found.path / CATEGORY / "parts.md").exists() is is_scanned
    assert {row[2 if is_scanned else 1] for row in found.data[CATEGORY]["means"]["rows"]} == {NOT_RUN}


def test_outdated_scans_make_all_later_stages_outdated(scanned: Scanned, evaluated: Workspace, tmp_path: Path) -> None:
    made = Scanned(evaluated, scanned.config)
    other = made.changed(tmp_path, "size = 96", "size = 80")
    assert table("4", made).plan().steps == ()
    plan = table("4", other).plan()
    assert plan.steps == (f"{CATEGORY}, supervised, seed 0: render, train, evaluate",)
    assert plan.seconds > other.train().guess().seconds > 0.0


def test_weights_to_continue_from_must_exist(scanned: Scanned, tmp_path: Path) -> None:
    made, observer = scanned.copied(tmp_path), Recorder()
    stage = table("3", made, start=Workspace(tmp_path / "none"))
    problem = re.escape(f"{tmp_path / 'none'}") + ".*--from: expected the weights to continue from"
    for begin in (stage.plan, lambda: stage.run(observer)):
        with pytest.raises(InputError, match=problem):
            begin()
    assert not observer.notes


def test_some_categories_have_three_seeds_by_default(scanned: Scanned) -> None:
    stage = MakeTable("2", scanned.workspace, scanned.config, ("kinmo",), **CPU)  # type: ignore[arg-type]
    counts = {name: len(stage._seeds_of(name)) for name in ("Refrigerator", "Scissors", "Door", "Table", "Dishwasher")}
    assert counts == {"Refrigerator": 3, "Scissors": 3, "Door": 1, "Table": 1, "Dishwasher": 1}
    assert replace(stage, seeds=2)._seeds_of("Scissors") == replace(stage, seeds=2)._seeds_of("Door") == (0, 1)


def test_rows_that_fit_into_the_given_hours_are_run(scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stage, observer = table("4", scanned.copied(tmp_path), seeds=2), Recorder()
    row = TABLES["4"].rows[0]
    trained, untrained = (stage._pending(row, CATEGORY, seed, {}).seconds for seed in (0, 1))
    assert 0.0 < trained < untrained, "networks of the second seed are not trained yet"
    monkeypatch.setattr("kinmo.experiments.scan_tables.make_table.time.monotonic", lambda: 0.0)
    found = replace(stage, hours=(trained + untrained) / 2 / 3600).run(observer)
    assert f"not run: {CATEGORY}, supervised, seed 1: {TOO_LONG}" in observer.notes
    assert rows_of(found.data)["supervised"][2] == "0"


def test_a_training_that_dies_leaves_the_other_rows_and_is_reported_in_the_table(
    scanned: Scanned, evaluated: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage, observer = table("4", Scanned(evaluated, scanned.config), seeds=2), Recorder()
    problem = "the process that trained npcs died: too little memory?"

    def die(training: TrainScans, observer: object) -> None:
        if training.seed == 1:
            raise ChildProcessError(problem)

    monkeypatch.setattr(TrainScans, "run", die)
    found = stage.run(observer)
    assert [note for note in observer.notes if note == f"not run: {CATEGORY}, supervised, seed 1: {problem}"]
    assert rows_of(found.data)["supervised"][2] == "0"
    assert f"Not run: supervised: seeds 1: {problem}." in written(stage)
