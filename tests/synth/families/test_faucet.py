from __future__ import annotations

import numpy as np
from built import built, from_axis, movable, pieces_of

SEEDS = range(60)


def test_switches_turn_about_lines_that_are_upright_level_and_leaning() -> None:
    rises = np.array([abs(link.motion.direction[1]) for s in SEEDS for link in _switches(s) if link.motion is not None])
    assert np.mean(rises > 0.999) > 0.4
    assert np.mean(rises < 0.001) > 0.1
    assert np.any((rises > 0.1) & (rises < 0.999))


def test_a_switch_s_line_runs_through_its_stem() -> None:
    for seed in SEEDS:
        shape = built("faucet", seed)
        for link in movable(shape):
            if link.name == "switch":
                own, _ = pieces_of(shape, link)
                corners = np.concatenate([piece.vertices for piece in own])
                assert from_axis(corners, link).min() < 0.03


def test_some_spouts_swivel_and_some_switches_screw() -> None:
    links = [link for seed in SEEDS for link in movable(built("faucet", seed))]
    assert any(link.name == "spout" for link in links)
    assert any(link.motion is not None and link.motion.rotates for link in links)


def _switches(seed: int) -> list:
    return [link for link in movable(built("faucet", seed)) if link.name == "switch"]
