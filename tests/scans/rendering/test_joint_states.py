"""Sampled joint states."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scanned_objects import cupboard_object, hinge, slider

from kinmo.scans.rendering.labelled_frames import joint_range, sample_joint_states


def test_every_value_is_in_the_range_of_its_joint() -> None:
    mobility = cupboard_object().mobility
    for values, _ in sample_joint_states(mobility, 20, np.random.default_rng(0)):
        for index, body in mobility.movable():
            assert body.joint is not None
            low, high = joint_range(body.joint)
            assert low - 1e-12 <= values[index] <= high + 1e-12


def test_the_release_ignores_limits() -> None:
    mobility = cupboard_object().mobility
    (first, _), (last, _) = sample_joint_states(mobility, 2, np.random.default_rng(0), like_release=True)
    drawer, door = 1, 3
    assert (first[door], last[door]) == pytest.approx((math.radians(-90), math.radians(30)))
    assert (first[drawer], last[drawer]) == pytest.approx((0.0, 0.4))


def test_without_limits_a_hinge_turns_a_quarter_and_a_slider_stays() -> None:
    free = replace(hinge((0.0, 0.0, 0.0)), lower=None, upper=None, rest=1.0)
    assert joint_range(free) == pytest.approx((1.0 - math.pi / 2, 1.0 + math.pi / 2))
    assert joint_range(replace(slider(), lower=None, upper=None, rest=0.2)) == (0.2, 0.2)


def test_a_screw_slides_and_turns() -> None:
    turns = [turns for _, turns in sample_joint_states(cupboard_object().mobility, 5, np.random.default_rng(1))]
    assert all(set(own) == {2} for own in turns)
    assert len({own[2] for own in turns}) == 5
