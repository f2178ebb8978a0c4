"""Trained networks are found again, and are used in pairs."""

from __future__ import annotations

import shutil

import pytest
from scanned_workspace import CATEGORY, FAMILY

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_networks import ScanRun, trained_runs, unfinished_runs
from kinmo.pipeline.scans.scan_predictor import choose_run

RUN = ScanRun(CATEGORY, "supervised", 0)


def begin_training(workspace: Workspace, run: ScanRun) -> None:
    """Leave what an interrupted training of a run leaves."""
    folder = run.folder(workspace, "npcs")
    shutil.copytree(RUN.folder(workspace, "npcs"), workspace.training / folder.relative_to(workspace.models))


def test_two_networks_that_were_trained_on_other_scans_are_no_pair(evaluated: Workspace) -> None:
    assert RUN.weights(evaluated)
    inputs = evaluated.inputs_of(RUN.stage("npcs"))
    assert inputs is not None
    assert RUN.was_trained_on(evaluated, inputs["data"])
    evaluated.forget(RUN.stage("npcs"))
    assert RUN.weights(evaluated) is None
    evaluated.record(RUN.stage("npcs"), {**inputs, "data": "others"})
    assert RUN.weights(evaluated) is None
    assert not RUN.was_trained_on(evaluated, inputs["data"])


def test_runs_are_found_by_their_folders(evaluated: Workspace) -> None:
    begun = [ScanRun(CATEGORY, "semi-weakly", 3, "paper"), ScanRun(CATEGORY, "self-training", 1)]
    for run in begun:
        begin_training(evaluated, run)
    assert trained_runs(evaluated) == [RUN]
    assert set(unfinished_runs(evaluated)) == set(begun)


def test_an_unfinished_training_is_reported(evaluated: Workspace) -> None:
    with pytest.raises(InputError, match=r"no networks for scans of pliers that learned .*paper.*--method paper first"):
        choose_run(evaluated, FAMILY, "paper", 0)
    begin_training(evaluated, RUN)
    assert choose_run(evaluated, FAMILY, None, 0) == RUN, "earlier networks are used until the training is finished"
    evaluated.forget(RUN.stage("npcs"))
    unfinished = "the training of networks for pliers is not finished: run the same kinmo train again"
    with pytest.raises(InputError, match=unfinished):
        choose_run(evaluated, FAMILY, None, 0)
    with pytest.raises(InputError, match=r"no networks for scans of pliers that learned .*paper.*--method paper first"):
        choose_run(evaluated, FAMILY, "paper", 0)
    begin_training(evaluated, ScanRun(CATEGORY, "semi-weakly", 0, "paper"))
    with pytest.raises(InputError, match=unfinished):
        choose_run(evaluated, FAMILY, "paper", 0)
