"""The tables of networks that see scans: what they show, and what they say of what is not there."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from scan_road import CATEGORY, FAMILY, HOW, Scanned, smaller
from trained_workspace import Recorder

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.evaluate_trained import JudgeTrained
from kinmo.experiments.scan_tables.make_table import TOO_LONG, MakeTable
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN
from kinmo.experiments.scan_tables.table_rows import TABLES
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.io.folder_lock import InUse
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.scans.train_scans import TrainAncsh
from kinmo.synth.synth_stage import Synth


def test_a_cell_that_cannot_be_run_leaves_the_others(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)  # of other tests
    told = Recorder()
    stage = MakeTable("4", Workspace(tmp_path / "workspace"), scanned.config, ("kinmo",), FAMILY, 1, **HOW)
    assert stage.plan().steps == (f"{CATEGORY}, supervised, seed 0: judge",)
    (other,) = stage.plan().impossible
    assert other.startswith(f"{CATEGORY}, generated shapes, seed 0: cannot be run: ") and "DSG-Net" in other
    found = stage.run(told)
    assert found.failed == 1
    assert [note for note in told.notes if note.startswith(f"not run: {CATEGORY}, generated shapes") and "DSG-Net" in note]
    run = {row[0]: row[1] for row in found.data[CATEGORY]["parts"]["rows"]}
    assert run == {"supervised": "1", "generated shapes": "not run", "generated shapes, paper": "not run"}
    assert "Not run: generated shapes: no shapes of Laptop in DSG-Net's layout." in found.text
    assert "Not run: generated" in WrittenTables(stage.workspace, "4").write({CATEGORY: [0]}).text, "whoever writes it again"


def test_where_another_process_is_writing_it_is_said_once_and_no_table_is_written(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    workspace, told = Workspace(tmp_path / "workspace"), Recorder()
    for stage in (MakeTable("4", workspace, scanned.config, ("kinmo",), FAMILY, 1, **HOW), JudgeTrained(workspace, FAMILY)):
        with workspace.locked(), pytest.raises(InUse, match="is writing here"):
            stage.run(told)
    assert not [note for note in told.notes if note.startswith("not ")]
    assert not workspace.evaluation.exists()


def test_without_labels_that_are_held_back_the_row_of_true_ones_is_no_failure(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, (FAMILY,), ("partnet_mobility",)).run(Recorder())
    workspace, told = Workspace(tmp_path / "workspace"), Recorder()
    Prepare(tmp_path / "partnet", workspace).run(Recorder())
    stage = MakeTable("2", workspace, "small", ("kinmo",), FAMILY, 1, hours=0.0, **HOW)
    assert [step.split(":")[0] for step in stage.plan().steps] == [f"{CATEGORY}, supervised, seed 0"]
    found = stage.run(told)
    assert found.failed == 2, "semi and semi-weakly: there is nothing without labels"
    assert [note for note in told.notes if "true labels" in note and "kinmo prepare --hold-back" in note]
    assert "Not run: true labels: no shapes of Laptop whose labels are held back" in found.text
    Synth(tmp_path / "partnet", 3, (FAMILY,), ("partnet_mobility",)).run(Recorder())
    Prepare(tmp_path / "partnet", workspace).run(Recorder())
    text = " ".join(WrittenTables(workspace, "2").write({CATEGORY: [0]}).text.split())
    assert "whose labels are held back" not in text, "other shapes may change that"


@pytest.mark.parametrize("is_scanned", [True, False])
def test_without_time_no_cell_is_run_and_all_are_told(scanned: Scanned, tmp_path: Path, is_scanned: bool) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    for folder in ("eval", *(() if is_scanned else ("scans", "own-scans", "models"))):
        shutil.rmtree(tmp_path / "workspace" / folder, ignore_errors=True)
    told = Recorder()
    stage = MakeTable("2", Workspace(tmp_path / "workspace"), scanned.config, ("kinmo",), FAMILY, 1, hours=0.0, **HOW)
    found = stage.run(told)
    assert not found.failed, "time that is over is no failure"
    made = [row for row in TABLES["2"].rows if row.method == "kinmo"]
    assert sum(note.startswith("not run") for note in told.notes) == len(made) == len(TABLES["2"].rows) - 1
    text = " ".join((found.path / CATEGORY / "means.md").read_text(encoding="utf-8").split())
    for row in made:
        assert f"Not run: {row.title}: " in text
    assert "Not run: supervised: it would have taken longer than --hours." in text
    assert (found.path / CATEGORY / "parts.md").exists() is is_scanned
    assert {row[2 if is_scanned else 1] for row in found.data[CATEGORY]["means"]["rows"]} == {NOT_RUN}


def test_what_is_done_for_scans_that_are_to_be_made_anew_is_to_be_done_again(
    scanned: Scanned, judged: Workspace, tmp_path: Path
) -> None:
    config = smaller(scanned, tmp_path)
    plans = [MakeTable("4", judged, name, ("kinmo",), FAMILY, 1, **HOW).plan() for name in (scanned.config, config)]
    assert plans[0].steps == ()
    assert plans[1].steps == (f"{CATEGORY}, supervised, seed 0: render, train, judge",)
    training = TrainAncsh(judged, config, FAMILY, "supervised", **HOW).guess().seconds
    assert plans[1].seconds > training > 0.0


@pytest.mark.parametrize("threads", [0, 1])
def test_training_takes_as_long_before_there_are_scans_as_with_them(scanned: Scanned, tmp_path: Path, threads: int) -> None:
    text, config = Path(scanned.config).read_text(encoding="utf-8"), tmp_path / "threads.toml"
    others, own = text.split("[ancsh]\n")
    config.write_text(f"{others}[ancsh]\n{own.replace('threads = 1', f'threads = {threads}')}", encoding="utf-8")
    stages = [TrainAncsh(scanned.workspace, str(config), FAMILY, "supervised", 1, "cpu", workers) for workers in (1, 2)]
    alone, together = (stage.plan().seconds for stage in stages)
    assert [stage.guess().seconds for stage in stages] == [alone, together]
    assert (together < alone) is (threads == 1), "on all threads one network is trained at a time"


def test_a_table_whose_motion_networks_have_none_to_go_on_from_says_so(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, told = Workspace(tmp_path / "workspace"), Recorder()
    stage = MakeTable("3", workspace, scanned.config, ("kinmo",), FAMILY, 1, start=Workspace(tmp_path / "none"), **HOW)
    problem = re.escape(f"{tmp_path / 'none'}") + ".*--from: expected the weights to go on from"
    for begin in (stage.plan, lambda: stage.run(told)):
        with pytest.raises(InputError, match=problem):
            begin()
    assert not told.notes


def test_categories_that_the_paper_varies_have_three_seeds_unless_it_is_said(scanned: Scanned) -> None:
    stage = MakeTable("2", scanned.workspace, scanned.config, ("kinmo",), **HOW)
    counts = {name: len(stage._seeds_of(name)) for name in ("Refrigerator", "Scissors", "Door", "Table", "Dishwasher")}
    assert counts == {"Refrigerator": 3, "Scissors": 3, "Door": 1, "Table": 1, "Dishwasher": 1}
    assert replace(stage, seeds=2)._seeds_of("Scissors") == replace(stage, seeds=2)._seeds_of("Door") == (0, 1)


def test_within_some_hours_what_fits_is_run(scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    stage = MakeTable("4", Workspace(tmp_path / "workspace"), scanned.config, ("kinmo",), FAMILY, 2, **HOW)
    row = TABLES["4"].rows[0]
    trained, untrained = (stage._pending(row, CATEGORY, seed, {}).seconds for seed in (0, 1))
    assert 0.0 < trained < untrained, "the second is to be trained first"
    monkeypatch.setattr("kinmo.experiments.scan_tables.make_table.time.monotonic", lambda: 0.0)
    told = Recorder()
    found = replace(stage, hours=(trained + untrained) / 2 / 3600).run(told)
    assert f"not run: {CATEGORY}, supervised, seed 1: {TOO_LONG}" in told.notes
    rows = {row[0]: row for row in found.data[CATEGORY]["means"]["rows"]}
    assert rows["supervised"][2] == "0"


def test_a_training_that_dies_leaves_the_other_cells_and_says_so_in_the_table(
    scanned: Scanned, judged: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = MakeTable("4", judged, scanned.config, ("kinmo",), FAMILY, 2, **HOW)
    problem = "the process that trained npcs died: too little memory?"

    def die(training: TrainAncsh, observer: object) -> None:
        if training.seed == 1:
            raise ChildProcessError(problem)

    monkeypatch.setattr(TrainAncsh, "run", die)
    told = Recorder()
    found = stage.run(told)
    assert [note for note in told.notes if note == f"not run: {CATEGORY}, supervised, seed 1: {problem}"]
    rows = {row[0]: row for row in found.data[CATEGORY]["means"]["rows"]}
    assert rows["supervised"][2] == "0"
    assert f"Not run: supervised: seeds 1: {problem}." in " ".join(found.text.split())
