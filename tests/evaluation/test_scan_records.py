"""Means over test scans, and differences between rows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.joint import JointKind
from kinmo.evaluation.scan_metrics import FrameScore
from kinmo.evaluation.scan_records import ObjectScans, change, change_of_failed_share, gap_closed, summary
from kinmo.scans.object_structure import Structure

STRUCTURE = Structure((JointKind.REVOLUTE,), (0,))
TURN, BOXES = "rotation (deg)", "3D IoU (%)"

turns = st.lists(st.floats(0.0, 3.0), min_size=1, max_size=8)


def objects(rotations, iou=0.5):
    """One object for each rotation, with one frame in which both parts have this rotation error."""
    one = np.array([0.1])
    frames = (FrameScore(np.full(2, turn), np.full(2, 0.1), np.full(2, iou), one, one, one, one) for turn in rotations)
    return [ObjectScans(f"object-{i}", (frame,)) for i, frame in enumerate(frames)]


@given(turns, st.data())
def test_a_change_is_the_difference_of_both_means(before, data):
    after = data.draw(st.lists(st.floats(0.0, 3.0), min_size=len(before), max_size=len(before)))
    rows = objects(before), objects(after)
    earlier, later = (summary(row, STRUCTURE)[TURN].value for row in rows)
    assert change(*rows, STRUCTURE)[TURN].value == pytest.approx(later - earlier, abs=1e-9)


@given(turns, st.floats(-1.0, 1.0))
def test_an_equal_gain_of_all_objects_is_certain_whatever_their_spread(before, gain):
    found = change(objects(before), objects([turn + gain for turn in before]), STRUCTURE)[TURN]
    np.testing.assert_allclose([found.low, found.value, found.high], np.degrees(gain), atol=1e-9)


def test_a_change_is_over_the_objects_that_both_rows_have():
    found = change(objects([0.3, 0.3, 0.9]), objects([0.1, 0.1]), STRUCTURE)[TURN]
    assert (found.value, found.count) == (pytest.approx(np.degrees(-0.2)), 2)
    assert set(change(objects([]), objects([0.1]), STRUCTURE).values()) == {None}


def test_a_row_gains_nothing_from_parts_that_it_did_not_find():
    def two_frames(*rotations):
        one, half = np.array([0.1]), np.full(2, 0.5)
        frames = [FrameScore(np.array([0.0, turn]), half, half, one, one, one, one) for turn in rotations]
        return [ObjectScans("object", tuple(frames))]

    before, after = two_frames(0.1, 1.5), two_frames(0.2, np.nan)
    found = change(before, after, STRUCTURE)[TURN]
    assert found.value == pytest.approx(np.degrees(0.1 / 3.0)), "of three parts that both found, one is worse"
    assert change_of_failed_share(before, after) == pytest.approx(50.0)
    assert gap_closed(before, after, two_frames(0.0, 0.0), STRUCTURE)[TURN] == pytest.approx(-1.0)


def test_the_closed_share_of_a_gap_is_relative_to_both_of_its_ends():
    worse, between, best = (objects([turn]) for turn in (0.4, 0.2, 0.1))
    shares = gap_closed(worse, between, best, STRUCTURE)
    assert shares[TURN] == pytest.approx(2.0 / 3.0)
    assert shares[BOXES] is None, "there is no gap"
    assert set(gap_closed(best, between, worse, STRUCTURE).values()) == {None}, "oracle labels would gain nothing"
    low, middle, high = (objects([0.1], iou) for iou in (0.2, 0.5, 0.6))
    assert gap_closed(low, middle, high, STRUCTURE)[BOXES] == pytest.approx(0.75)


def test_a_gap_that_may_be_chance_has_no_closed_share():
    before = [0.1, 0.5, 0.9, 0.3]
    half = objects([turn - 0.05 for turn in before])
    all_gain, some_gain = (
        [turn - gain for turn, gain in zip(before, gains, strict=True)] for gains in ([0.1] * 4, [0.8, -0.4, -0.3, 0.3])
    )
    assert gap_closed(objects(before), half, objects(all_gain), STRUCTURE)[TURN] == pytest.approx(0.5)
    assert gap_closed(objects(before), half, objects(some_gain), STRUCTURE)[TURN] is None
