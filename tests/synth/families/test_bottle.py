"""Bottles: caps, pumps and triggers move as on real bottles."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, link_pieces, moving_and_other_pieces, moving_links


def test_caps_screw_about_their_own_axis_and_come_off_away_from_the_body() -> None:
    turned = 0
    for seed in range(40):
        shape = build_object("bottle", seed)
        body = np.mean(bounds_of(link_pieces(shape.links[0])), axis=0)
        for link in moving_links(shape):
            if not link.motion.rotates:
                continue
            turned += 1
            low, high = bounds_of(link_pieces(link))
            middle = 0.5 * (low + high) - link.motion.origin
            assert np.linalg.norm(middle[[0, 2]]) < 1e-6
            outwards = np.sign((low + high)[1] - 2 * body[1])
            ends = sorted(outwards * link.motion.direction[1] * value for value in (link.motion.a, link.motion.b))
            assert ends[0] == 0.0
            assert ends[1] > 0.0
    assert turned > 10


def test_pump_heads_slide_down_and_are_children_of_the_collar() -> None:
    pumps = [link for seed in range(60) for link in moving_links(build_object("bottle", seed)) if link.name == "pump"]
    assert pumps
    for link in pumps:
        assert link.parent.name == "closure"
        assert min(link.motion.a * link.motion.direction[1], link.motion.b * link.motion.direction[1]) < 0.0


def test_bottles_have_closures_of_all_proportions() -> None:
    ratios = []
    for seed in range(150):
        shape = build_object("bottle", seed)
        for link in moving_links(shape):
            if link.name in ("lid", "closure") and link.parent is shape.links[0]:
                size = np.ptp(bounds_of(link_pieces(link)), axis=0)
                ratios.append(size[1] / size[0])
    assert np.quantile(ratios, 0.1) < 0.4
    assert np.quantile(ratios, 0.9) > 1.2


def test_a_lid_is_lower_than_its_bottle() -> None:
    for seed in range(20):
        shape = build_object("bottle", seed)
        own, rest = moving_and_other_pieces(shape, next(moving_links(shape)))
        assert np.ptp(bounds_of(own), axis=0)[1] < np.ptp(bounds_of(rest), axis=0)[1]


def test_triggers_turn_about_a_horizontal_line_or_slide_along_z() -> None:
    triggers = [link for seed in range(120) for link in moving_links(build_object("bottle", seed)) if link.name == "trigger"]
    assert triggers
    for link in triggers:
        np.testing.assert_allclose(np.abs(link.motion.direction), (1, 0, 0) if link.motion.is_hinge else (0, 0, 1))
