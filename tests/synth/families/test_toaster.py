from __future__ import annotations

import numpy as np
from built import box_of, built, movable, named, pieces_of


def test_levers_go_down_and_stay_within_the_height_of_the_body() -> None:
    for seed in range(30):
        shape = built("toaster", seed)
        _, rest = pieces_of(shape, next(movable(shape)))
        low, high = box_of(rest)
        levers = [link for link in movable(shape) if link.name == "slider" and abs(link.motion.direction[1]) > 0.9]
        assert levers
        for lever in levers:
            own, _ = pieces_of(shape, lever)
            for value in (lever.motion.a, lever.motion.b):
                moved = np.concatenate([piece.vertices for piece in own]) + value * lever.motion.direction
                assert moved[:, 1].max() < high[1] + 0.1
                assert moved[:, 1].min() > low[1] - 0.1


def test_dials_turn_about_their_own_middle() -> None:
    for seed in range(40):
        shape = built("toaster", seed)
        for knob in (link for link in movable(shape) if link.motion.is_hinge):
            low, high = box_of(pieces_of(shape, knob)[0])
            offset = 0.5 * (low + high) - knob.motion.origin
            across = offset - knob.motion.direction * (offset @ knob.motion.direction)
            assert np.linalg.norm(across) < 0.03


def test_racks_are_wire_that_stays_between_the_body_s_ends_and_comes_out_at_the_top() -> None:
    found = 0
    for seed in range(40):
        shape = built("toaster", seed)
        for rack in named(shape, "slot"):
            own, rest = pieces_of(shape, rack)
            low, high = box_of(own)
            filled = sum(np.prod(np.ptp(piece.vertices, axis=0)) for piece in own) / np.prod(high - low)
            assert filled < 0.2
            first, last = box_of(rest)
            assert first[2] < low[2] and high[2] < last[2]
            assert abs(high[1] - last[1]) < 0.15 and rack.motion.direction[1] > 0.99
            found += 1
    assert found > 10
