"""Lamps: arms form chains and turn where they meet."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, link_pieces, moving_links


def test_arms_form_a_chain_and_turn_where_they_meet() -> None:
    longest = 0
    for seed in range(30):
        shape = build_object("lamp", seed)
        arms = [link for link in moving_links(shape) if link.name == "lamp_arm"]
        longest = max(longest, max(map(shape.depth, arms)))
        for arm in arms:
            low, high = bounds_of(link_pieces(arm))
            assert np.all(arm.motion.origin > low - 0.03)
            assert np.all(arm.motion.origin < high + 0.03)
    assert longest >= 2
