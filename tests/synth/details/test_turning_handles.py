"""Handles that turn about a stem: their reach and their position on it."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.synth.details.turning_handles import lever, revolved_cap, turning_handle
from kinmo.synth.draw import Draw

seeds = st.integers(0, 2**32 - 1)


def corners(pieces: list) -> np.ndarray:
    return np.concatenate([piece.vertices for piece in pieces])


@settings(max_examples=50)
@given(seeds, st.floats(0.05, 0.5), st.floats(0.03, 0.3))
def test_a_handle_is_on_its_stem_and_within_its_reach(seed: int, radius: float, height: float) -> None:
    pieces = turning_handle(Draw(np.random.default_rng(seed)), radius, height)
    reach = np.linalg.norm(corners(pieces)[:, [0, 2]], axis=1)
    assert reach.max() < 1.6 * radius
    assert corners(pieces)[:, 1].min() > -0.4 * radius
    hub = corners(pieces[:1])
    assert np.allclose(0.5 * (hub.min(axis=0) + hub.max(axis=0))[[0, 2]], 0.0, atol=0.15 * radius)


@settings(max_examples=50)
@given(seeds)
def test_a_lever_reaches_to_the_front_and_is_symmetric(seed: int) -> None:
    pieces = lever(Draw(np.random.default_rng(seed)), 0.5, 0.02, 0.1)
    low, high = corners(pieces).min(axis=0), corners(pieces).max(axis=0)
    assert high[2] > 0.48
    assert low[2] > -0.12
    assert abs(low[0] + high[0]) < 0.01


@settings(max_examples=50)
@given(seeds)
def test_a_cap_fills_its_height(seed: int) -> None:
    cap = corners([revolved_cap(Draw(np.random.default_rng(seed)), 0.2, 0.3)])
    assert np.isclose(cap[:, 1].min(), 0.0)
    assert np.isclose(cap[:, 1].max(), 0.3)
