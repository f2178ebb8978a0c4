"""Faucets: switches turn about their stems, some spouts swivel, some switches screw."""

from __future__ import annotations

import numpy as np
from synth_objects import axis_distances, build_object, moving_and_other_pieces, moving_links

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
                corners = np.concatenate([piece.vertices for piece in own])
                assert axis_distances(corners, link).min() < 0.03


def test_some_spouts_swivel_and_some_switches_screw() -> None:
    links = [link for seed in SEEDS for link in moving_links(build_object("faucet", seed))]
    assert any(link.name == "spout" for link in links)
    assert any(link.motion is not None and link.motion.rotates for link in links)


def _switches(seed: int) -> list:
    return [link for link in moving_links(build_object("faucet", seed)) if link.name == "switch"]
