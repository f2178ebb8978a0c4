"""Toasters: levers, dials and racks move within the body's bounds."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, links_with_leaf, moving_and_other_pieces, moving_links


def test_levers_move_within_the_height_of_the_body() -> None:
    for seed in range(30):
        shape = build_object("toaster", seed)
        _, rest = moving_and_other_pieces(shape, next(moving_links(shape)))
        low, high = bounds_of(rest)
        levers = [link for link in moving_links(shape) if link.name == "slider" and abs(link.motion.direction[1]) > 0.9]
        assert levers
        for lever in levers:
            own, _ = moving_and_other_pieces(shape, lever)
            for value in (lever.motion.a, lever.motion.b):
                moved = np.concatenate([piece.vertices for piece in own]) + value * lever.motion.direction
                assert moved[:, 1].max() < high[1] + 0.1
                assert moved[:, 1].min() > low[1] - 0.1


def test_crumb_trays_slide_out_level_at_an_end_or_a_side() -> None:
    trays = [link for seed in range(80) for link in links_with_leaf(build_object("toaster", seed), "tray")]
    assert len(trays) > 10
    ways = np.array([link.motion.direction for link in trays])
    assert np.allclose(ways[:, 1], 0.0) and np.any(np.abs(ways[:, 0]) > 0.9) and np.any(np.abs(ways[:, 2]) > 0.9)
    assert all(link.motion.a <= 0.0 < link.motion.b for link in trays)


def test_dials_turn_about_their_own_centre() -> None:
    for seed in range(40):
        shape = build_object("toaster", seed)
        for knob in (link for link in moving_links(shape) if link.name == "knob"):
            low, high = bounds_of(moving_and_other_pieces(shape, knob)[0])
            offset = 0.5 * (low + high) - knob.motion.origin
            across = offset - knob.motion.direction * (offset @ knob.motion.direction)
            assert np.linalg.norm(across) < 0.03


def test_racks_are_wire_between_the_ends_of_the_body_and_slide_up() -> None:
    found = 0
    for seed in range(40):
        shape = build_object("toaster", seed)
        for rack in links_with_leaf(shape, "slot"):
            own, rest = moving_and_other_pieces(shape, rack)
            low, high = bounds_of(own)
            filled = sum(np.prod(np.ptp(piece.vertices, axis=0)) for piece in own) / np.prod(high - low)
            assert filled < 0.2
            first, last = bounds_of(rest)
            assert first[2] < low[2] and high[2] < last[2]
            assert abs(high[1] - last[1]) < 0.15 and rack.motion.direction[1] > 0.99
            found += 1
    assert found > 10
