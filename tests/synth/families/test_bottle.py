from __future__ import annotations

import numpy as np
from built import box_of, built, movable, pieces_of


def test_caps_screw_about_their_own_middle_and_come_off_upwards() -> None:
    turned = 0
    for seed in range(40):
        shape = built("bottle", seed)
        for link in movable(shape):
            if not link.motion.rotates:
                continue
            turned += 1
            low, high = box_of([piece for leaf in link.leaves() for piece in leaf.pieces])
            middle = 0.5 * (low + high) - link.motion.origin
            assert np.linalg.norm(middle[[0, 2]]) < 1e-6
            ends = sorted(link.motion.direction[1] * value for value in (link.motion.a, link.motion.b))
            assert ends[0] == 0.0
            assert ends[1] > 0.0
    assert turned > 10


def test_pumps_hang_on_the_collar() -> None:
    pumps = [link for seed in range(60) for link in movable(built("bottle", seed)) if link.parent.name == "closure"]
    assert pumps
    assert all(not link.motion.is_hinge for link in pumps)


def test_a_lid_is_small_beside_its_bottle() -> None:
    for seed in range(20):
        shape = built("bottle", seed)
        own, rest = pieces_of(shape, next(movable(shape)))
        assert np.ptp(box_of(own), axis=0)[1] < np.ptp(box_of(rest), axis=0)[1]


def test_triggers_turn_about_a_level_line_or_slide_to_the_rear() -> None:
    triggers = [link for seed in range(120) for link in movable(built("bottle", seed)) if link.name == "trigger"]
    assert triggers
    for link in triggers:
        np.testing.assert_allclose(np.abs(link.motion.direction), (1, 0, 0) if link.motion.is_hinge else (0, 0, 1))
