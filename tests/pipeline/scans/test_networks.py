"""Trained networks, found again."""

from __future__ import annotations

from scan_road import CATEGORY

from kinmo.pipeline.scans.networks import Cell
from kinmo.workspace import StageRecord, Workspace


def test_networks_of_which_one_is_trained_anew_are_none(judged: Workspace) -> None:
    cell = Cell(CATEGORY, "supervised", 0)
    assert cell.weights(judged)
    record = judged.record(cell.stage("npcs"))
    assert record is not None
    judged.forget(cell.stage("npcs"))
    assert cell.weights(judged) is None
    judged.write_record(cell.stage("npcs"), StageRecord({**record.inputs, "data": "others"}))
    assert cell.weights(judged) is None, "what the one says does not go with what the other says"
