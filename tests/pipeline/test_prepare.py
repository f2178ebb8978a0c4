"""Preparing as a stage: what it tells beside what it makes."""

from __future__ import annotations

from pathlib import Path

from trained_workspace import Recorder

from kinmo.dataset.folder_preparation import HELD_BACK
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.prepare import Prepare
from kinmo.synth.synth_stage import Synth


def test_labels_that_nothing_holds_back_are_told(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("laptop",), ("partnet",), oracle=True).run(Recorder())
    held_back, workspace = tmp_path / "partnet" / HELD_BACK, Workspace(tmp_path / "workspace")
    warning = f"{held_back}: taken as labelled shapes; --hold-back {held_back} keeps their labels from all networks"
    for hold_back in ((), (held_back,), (tmp_path / "partnet",)):
        told = Recorder()
        Prepare(tmp_path / "partnet", workspace, hold_back=hold_back).run(told)
        assert (warning in told.notes) is not bool(hold_back)
        assert bool(open_dataset(workspace).hidden) is bool(hold_back)


def test_a_folder_that_holds_nothing_back_is_told(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("laptop",), ("partnet",)).run(Recorder())
    told, other = Recorder(), tmp_path / "other"
    other.mkdir()
    Prepare(tmp_path / "partnet", Workspace(tmp_path / "workspace"), hold_back=(other,)).run(told)
    assert told.notes == [f"{other}: no shape at or below it was prepared, so none is held back"]
