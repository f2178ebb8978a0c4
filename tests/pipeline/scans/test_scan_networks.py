"""Trained networks, found again."""

from __future__ import annotations

import shutil

import pytest
from scan_road import CATEGORY, FAMILY

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.pipeline.scans.scan_finder import networks_for
from kinmo.pipeline.scans.scan_networks import Cell


def test_networks_of_which_one_is_of_other_scans_are_none(judged: Workspace) -> None:
    cell = Cell(CATEGORY, "supervised", 0)
    assert cell.weights(judged)
    record = judged.record(cell.stage("npcs"))
    assert record is not None
    judged.forget(cell.stage("npcs"))
    assert cell.weights(judged) is None
    judged.write_record(cell.stage("npcs"), StageRecord({**record.inputs, "data": "others"}))
    assert cell.weights(judged) is None, "what the one says does not go with what the other says"


def test_networks_that_are_not_trained_to_the_end_are_said_to_be_so(judged: Workspace) -> None:
    with pytest.raises(InputError, match=f"no networks that find a {FAMILY} in scans.*--method paper"):
        networks_for(judged, FAMILY, "paper", 0)
    cell = Cell(CATEGORY, "supervised", 0)
    shutil.copytree(cell.folder(judged, "npcs"), judged.training / cell.folder(judged, "npcs").relative_to(judged.models))
    assert networks_for(judged, FAMILY, None, 0)[1] == cell, "while others are trained those that are there answer"
    judged.forget(cell.stage("npcs"))
    not_done = "are not trained to the end: the same kinmo train goes on"
    with pytest.raises(InputError, match=not_done):
        networks_for(judged, FAMILY, None, 0)
    with pytest.raises(InputError, match=f"no networks that find a {FAMILY} in scans.*--method paper"):
        networks_for(judged, FAMILY, "paper", 0)
    by_paper = judged.by("paper")
    shutil.copytree(cell.folder(judged, "npcs"), Cell(CATEGORY, "semi-weakly", 0).folder(by_paper, "npcs"))
    begun = Cell(CATEGORY, "semi-weakly", 0).folder(by_paper, "npcs")
    shutil.move(begun, by_paper.training / begun.relative_to(by_paper.models))
    with pytest.raises(InputError, match=not_done):
        networks_for(judged, FAMILY, "paper", 0)
