from __future__ import annotations

import numpy as np
from built import box_of, built, movable


def test_arms_hang_on_each_other_and_turn_where_they_meet() -> None:
    longest = 0
    for seed in range(30):
        shape = built("lamp", seed)
        arms = [link for link in movable(shape) if link.name == "lamp_arm"]
        longest = max(longest, max(map(shape.depth, arms)))
        for arm in arms:
            low, high = box_of([piece for leaf in arm.leaves() for piece in leaf.pieces])
            assert np.all(arm.motion.origin > low - 0.03)
            assert np.all(arm.motion.origin < high + 0.03)
    assert longest >= 2
