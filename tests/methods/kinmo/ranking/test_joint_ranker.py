"""Calibration of scores."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torch import nn

from kinmo.config import RankingConfig, TrainingConfig
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker


def ranker(slope: float, offset: float) -> JointRanker:
    config = RankingConfig(TrainingConfig(1, 1e-3), score_slope=slope, score_offset=offset)
    return JointRanker(nn.ModuleList(), config, "cpu", hide_names=False)


@given(st.floats(0.0, 1.0))
def test_scores_stay_as_they_are_without_calibration(score: float) -> None:
    assert ranker(1.0, 0.0).calibrated(score) == pytest.approx(score, abs=2e-6)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.1, 3.0), st.floats(-3.0, 3.0))
def test_calibration_keeps_the_order_of_scores(one: float, other: float, slope: float, offset: float) -> None:
    low, high = (ranker(slope, offset).calibrated(score) for score in sorted((one, other)))
    assert 0.0 <= low <= high <= 1.0


def test_a_slope_below_1_makes_scores_less_extreme() -> None:
    assert 0.5 < ranker(0.5, 0.0).calibrated(0.99) < 0.99
    assert 0.01 < ranker(0.5, 0.0).calibrated(0.01) < 0.5
