"""Sampled joint states."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scanned_objects import cupboard_object, hinge, slider

from kinmo.scans.rendering.joint_states import joint_range, sample_joint_states


def test_every_value_is_in_the_range_of_its_joint() -> None:
    mobility = cupboard_object().mobility
    for state in sample_joint_states(mobility, 20, np.random.default_rng(0)):
        for index, body in mobility.movable():
            assert body.joint is not None
            low, high = joint_range(body.joint)
            assert low - 1e-12 <= state.values[index] <= high + 1e-12


def test_the_release_ignores_limits() -> None:
    mobility = cupboard_object().mobility
    first, last = sample_joint_states(mobility, 2, np.random.default_rng(0), like_release=True)
    drawer, door = 1, 3
    assert (first.values[door], last.values[door]) == pytest.approx((math.radians(-90), math.radians(30)))
    assert (first.values[drawer], last.values[drawer]) == pytest.approx((0.0, 0.4))


def test_without_limits_a_hinge_turns_a_quarter_and_a_slider_stays() -> None:
    free = replace(hinge((0.0, 0.0, 0.0)), lower=None, upper=None, rest=1.0)
    assert joint_range(free) == pytest.approx((1.0 - math.pi / 2, 1.0 + math.pi / 2))
    assert joint_range(replace(slider(), lower=None, upper=None, rest=0.2)) == (0.2, 0.2)


def test_a_screw_slides_and_turns() -> None:
    states = list(sample_joint_states(cupboard_object().mobility, 5, np.random.default_rng(1)))
    assert all(set(state.turns) == {2} for state in states)
    assert len({state.turns[2] for state in states}) == 5
