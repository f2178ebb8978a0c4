"""Stretched objects: joints stay where they were in their parts, and what turns about itself stays round."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from synth_objects import axis_distances, link_vertices, moving_links, sinking_share

from kinmo.synth.draw import Draw
from kinmo.synth.families import family_builder, family_names
from kinmo.synth.proportions import stretch_object
from kinmo.synth.synth_object import SynthObject


def before_and_after(name: str, seed: int) -> tuple[SynthObject, SynthObject]:
    before = family_builder(name)(Draw(np.random.default_rng(seed)))
    after = deepcopy(before)
    stretch_object(after, Draw(np.random.default_rng(seed)))
    return before, after


def place_in_box(obj: SynthObject, point: np.ndarray) -> np.ndarray:
    low, high = obj.bounds()
    return (point - low) / (high - low)


@pytest.mark.parametrize("name", family_names())
def test_joints_keep_their_place_in_the_object(name: str) -> None:
    for seed in range(4):
        before, after = before_and_after(name, seed)
        for link, stretched in zip(before.links, after.links, strict=True):
            if link.motion is not None:
                assert stretched.motion is not None
                np.testing.assert_allclose(stretched.motion.direction, link.motion.direction)
                places = [place_in_box(obj, at.motion.origin) for obj, at in ((before, link), (after, stretched))]
                np.testing.assert_allclose(*places, atol=1e-9)


@pytest.mark.parametrize("name", ["bottle", "chair", "faucet", "oven", "safe", "camera", "mechanism"])
def test_what_turns_about_itself_stays_round(name: str) -> None:
    for seed in range(8):
        before, after = before_and_after(name, seed)
        for link, stretched in zip(before.links, after.links, strict=True):
            if link.motion is not None and (link.motion.no_limit or link.motion.rotates):
                distances, widened = (
                    axis_distances(link_vertices(link), link),
                    axis_distances(link_vertices(stretched), stretched),
                )
                factors = widened[distances > 1e-3] / distances[distances > 1e-3]
                assert np.ptp(factors) < 1e-6 * factors.max()


@pytest.mark.parametrize("name", ["storage_furniture", "refrigerator", "window", "oven"])
def test_stretched_parts_enter_others_no_more_than_before(name: str) -> None:
    shares: list[list[float]] = [[], []]
    for seed in range(6):
        for found, obj in zip(shares, before_and_after(name, seed), strict=True):
            obj.apply_rest_pose()
            found += [sinking_share(obj, link) for link in moving_links(obj)]
    assert np.mean(shares[1]) < np.mean(shares[0]) + 0.05


def test_half_of_the_cabinets_are_stretched() -> None:
    changed = 0
    for seed in range(60):
        before, after = before_and_after("storage_furniture", seed)
        (low, high), (new_low, new_high) = before.bounds(), after.bounds()
        changed += bool(np.ptp((new_high - new_low) / (high - low)) > 0.05)
    assert 10 < changed < 40
