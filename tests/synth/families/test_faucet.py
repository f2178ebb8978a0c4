"""Faucets: switches turn about their stems, some spouts swivel, some switches screw."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, moving_and_other_pieces, moving_links

SEEDS = range(60)


def test_axes_of_switches_are_vertical_horizontal_or_leaning() -> None:
    rises = np.array([abs(link.motion.direction[1]) for s in SEEDS for link in _switches(s) if link.motion is not None])
    assert np.mean(rises > 0.999) > 0.4
    assert np.mean(rises < 0.001) > 0.1
    assert np.any((rises > 0.1) & (rises < 0.999))


def test_the_axis_of_a_switch_runs_through_its_stem() -> None:
    for seed in SEEDS:
        shape = build_object("faucet", seed)
        for link in moving_links(shape):
            if link.name == "switch":
                own, _ = moving_and_other_pieces(shape, link)
                low, high = bounds_of(own)
                unit = link.motion.direction / np.linalg.norm(link.motion.direction)
                nearest = link.motion.origin + unit * ((0.5 * (low + high) - link.motion.origin) @ unit)
                assert np.all(nearest > low - 0.03) and np.all(nearest < high + 0.03)


def test_some_spouts_swivel_and_some_switches_screw() -> None:
    links = [link for seed in SEEDS for link in moving_links(build_object("faucet", seed))]
    assert any(link.name == "spout" for link in links)
    assert any(link.motion is not None and link.motion.rotates for link in links)


def test_heads_pull_out_of_their_spout_and_sticks_tip_on_caps() -> None:
    links = [link for seed in range(150) for link in moving_links(build_object("faucet", seed))]
    heads = [link for link in links if link.name == "head"]
    assert heads and not any(link.motion.is_hinge for link in heads)
    assert any(link.parent.name == "spout" for link in heads)
    assert any(link.name == "lever" and link.parent.name == "switch" for link in links)


def _switches(seed: int) -> list:
    return [link for link in moving_links(build_object("faucet", seed)) if link.name == "switch"]
