"""Spouts of faucets: their paths and parts."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.synth.details.spouts import add_spout, arm_path, neck_path
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Node

seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=50)
@given(seeds)
def test_a_neck_rises_from_its_foot_and_ends_in_front_pointing_down(seed: int) -> None:
    path = neck_path(Draw(np.random.default_rng(seed)), 0.1)
    assert np.allclose(path[0], (0, 0.1, 0))
    assert np.allclose(path[:, 0], 0.0)
    assert path[:, 1].max() > 0.15
    assert path[-1, 2] > 0.15
    assert path[-1, 1] < path[-2, 1]


@settings(max_examples=50)
@given(seeds, st.floats(0.4, 1.2), st.floats(0.2, 0.9))
def test_an_arm_has_the_given_reach(seed: int, reach: float, height: float) -> None:
    path = arm_path(Draw(np.random.default_rng(seed)), reach, height, 0.1)
    assert reach - 1e-9 <= path[-1, 2] <= reach + 0.1 + 1e-9
    assert np.isclose(path[0, 1], height)


@settings(max_examples=50)
@given(seeds)
def test_a_spout_always_has_a_tube(seed: int) -> None:
    draw, spout = Draw(np.random.default_rng(seed)), Node("spout")
    add_spout(draw, spout, arm_path(draw, 0.6, 0.5, 0.1), 0.05)
    assert spout.children[0].name == "tube"
    assert {child.name for child in spout.children} <= {"tube", "head", "mouth"}
