"""The journal records runs, and estimates come from it."""

from __future__ import annotations

import json
from pathlib import Path

from kinmo.dataset.journal import runs, seconds_per_unit, timed
from kinmo.dataset.workspace import Workspace


def run(workspace: Workspace, stage: str, amount: int) -> None:
    with timed(workspace, stage) as watch:
        watch.amount, watch.what = amount, f"{amount} things"


def test_a_run_that_did_nothing_is_not_recorded(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    run(workspace, "prepare", 3)
    run(workspace, "prepare", 0)
    assert [(found.stage, found.amount, found.what) for found in runs(workspace)] == [("prepare", 3, "3 things")]


def test_an_unfinished_line_of_a_killed_process_spoils_no_other(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    run(workspace, "prepare", 3)
    journal = tmp_path / "journal.jsonl"
    journal.write_bytes(journal.read_bytes() + b'{"stage": "train-axis", "sta')
    run(workspace, "train-axis", 5)
    run(workspace, "report", 7)
    assert [found.amount for found in runs(workspace)] == [3, 5, 7]
    assert seconds_per_unit(workspace, "no such stage", 0.5) == 0.5


def test_workspaces_can_share_a_journal(tmp_path: Path) -> None:
    root = Workspace(tmp_path)
    part = Workspace(tmp_path / "part", journal=root.journal)
    for workspace in (root, part):
        run(workspace, "train-gnn", 3)
    assert runs(part) == runs(root) and len(runs(root)) == 2
    assert seconds_per_unit(part, "train-gnn", 0.5) == seconds_per_unit(root, "train-gnn", 0.5) != 0.5


def test_a_new_stage_takes_as_long_as_the_last_one_with_its_prefix(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    lines = [
        {"stage": name, "started": "", "seconds": seconds, "amount": 2, "what": ""}
        for name, seconds in (("train-npcs-Safe-0", 8.0), ("train-npcs-Door-0", 4.0), ("train-gnn", 2.0))
    ]
    (tmp_path / "journal.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
    assert seconds_per_unit(workspace, "train-npcs-Safe-0", 0.5, prefix="train-npcs-") == 4.0
    assert seconds_per_unit(workspace, "train-npcs-Table-0", 0.5, prefix="train-npcs-") == 2.0
    assert seconds_per_unit(workspace, "train-npcs-Table-0", 0.5) == 0.5


def test_small_runs_do_not_count_for_estimates(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    lines = [
        {"stage": "render", "started": "", "seconds": seconds, "amount": amount, "what": ""}
        for seconds, amount in ((12.0, 4), (7.0, 1000), (9.0, 900), (13.0, 20))
    ]
    (tmp_path / "journal.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
    assert seconds_per_unit(workspace, "render", 0.5) == 0.01
