"""The journal of a workspace."""

from __future__ import annotations

import json
from pathlib import Path

from kinmo.dataset.journal import runs, seconds_per_unit, timed
from kinmo.dataset.workspace import Workspace


def run(workspace: Workspace, stage: str, amount: int) -> None:
    with timed(workspace, stage) as watch:
        watch.amount, watch.what = amount, f"{amount} things"


def test_a_run_that_did_nothing_is_no_entry(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    run(workspace, "prepare", 3)
    run(workspace, "prepare", 0)
    assert [(found.stage, found.amount, found.what) for found in runs(workspace)] == [("prepare", 3, "3 things")]


def test_a_line_that_a_killed_process_left_unfinished_spoils_no_other(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    run(workspace, "prepare", 3)
    journal = tmp_path / "journal.jsonl"
    journal.write_bytes(journal.read_bytes() + b'{"stage": "train-axis", "sta')
    run(workspace, "train-axis", 5)
    run(workspace, "report", 7)
    assert [found.amount for found in runs(workspace)] == [3, 5, 7]
    assert seconds_per_unit(workspace, "no such stage", 0.5) == 0.5


def test_shares_of_labels_share_the_journal_and_say_where_they_ran(tmp_path: Path) -> None:
    root, some, rough = Workspace(tmp_path), Workspace(tmp_path, 0.8), Workspace(tmp_path, 0.8, is_rough=True)
    for workspace in (root, some, rough):
        run(workspace, "train-gnn", 3)
    assert [found.what for found in runs(root)] == ["3 things", "labels-80: 3 things", "rough/labels-80: 3 things"]
    assert runs(some) == runs(root)
    assert seconds_per_unit(rough, "train-gnn", 0.5) == seconds_per_unit(root, "train-gnn", 0.5) != 0.5


def test_what_never_ran_takes_as_long_as_the_last_of_its_kind(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    lines = [
        {"stage": name, "started": "", "seconds": seconds, "amount": 2, "what": ""}
        for name, seconds in (("train-npcs-Safe-0", 8.0), ("train-npcs-Door-0", 4.0), ("train-gnn", 2.0))
    ]
    (tmp_path / "journal.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
    assert seconds_per_unit(workspace, "train-npcs-Safe-0", 0.5, kind="train-npcs-") == 4.0
    assert seconds_per_unit(workspace, "train-npcs-Table-0", 0.5, kind="train-npcs-") == 2.0
    assert seconds_per_unit(workspace, "train-npcs-Table-0", 0.5) == 0.5


def test_a_run_that_did_little_does_not_tell_how_long_much_takes(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    lines = [
        {"stage": "render", "started": "", "seconds": seconds, "amount": amount, "what": ""}
        for seconds, amount in ((12.0, 4), (7.0, 1000), (9.0, 900), (13.0, 20))
    ]
    (tmp_path / "journal.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
    assert seconds_per_unit(workspace, "render", 0.5) == 0.01
