"""Random choices: ranges, weights and identical sources."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.synth.draw import Draw, ParameterRange


def draw(seed: int = 0, parameter_range: ParameterRange = ParameterRange.BOTH) -> Draw:
    return Draw(np.random.default_rng(seed), parameter_range)


@pytest.mark.parametrize(
    ("parameter_range", "low", "high"),
    [(ParameterRange.LABELLED, 2.0, 3.4), (ParameterRange.UNLABELLED, 2.6, 4.0), (ParameterRange.BOTH, 2.0, 4.0)],
)
def test_values_fill_the_window_of_their_range(parameter_range: ParameterRange, low: float, high: float) -> None:
    source = draw(1, parameter_range)
    values = [source.between(2.0, 4.0) for _ in range(500)]
    assert low <= min(values) < low + 0.1
    assert high - 0.1 < max(values) <= high


def test_ratios_are_as_often_below_as_above_their_geometric_middle() -> None:
    source = draw(5)
    values = np.array([source.ratio(0.5, 8.0) for _ in range(800)])
    assert values.min() >= 0.5 and values.max() <= 8.0
    assert np.mean(values < 2.0) == pytest.approx(0.5, abs=0.06)


def test_options_are_picked_by_their_weights() -> None:
    source = draw(2)
    picked = [source.pick("abc", [3, 0, 1]) for _ in range(2000)]
    assert "b" not in picked
    assert picked.count("a") / len(picked) == pytest.approx(0.75, abs=0.03)


def test_integers_include_both_ends() -> None:
    source = draw(3)
    assert {source.integer(2, 4) for _ in range(100)} == {2, 3, 4}


def test_identical_sources_give_the_same_values_in_the_same_window() -> None:
    one, other = draw(4, ParameterRange.LABELLED).identical(2)
    values = [one.between(0.0, 1.0) for _ in range(100)]
    assert values == [other.between(0.0, 1.0) for _ in range(100)]
    assert max(values) <= 0.7
