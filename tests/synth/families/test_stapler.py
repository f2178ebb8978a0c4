from __future__ import annotations

import numpy as np
from built import built, from_axis, movable


def test_magazine_and_lid_turn_about_one_line_near_an_end() -> None:
    for seed in range(30):
        body, lid = movable(built("stapler", seed))
        assert from_axis(body.motion.origin[None], lid)[0] < 1e-9
        corners = np.concatenate([piece.vertices for leaf in lid.leaves() for piece in leaf.pieces])
        distances = from_axis(corners, lid)
        assert distances.min() < 0.25 * distances.max()
