from __future__ import annotations

import numpy as np
from built import built, from_axis, named


def test_the_bow_ends_on_the_line_about_which_it_turns() -> None:
    for seed in range(30):
        for bow in named(built("bucket", seed), "handle"):
            corners = np.concatenate([piece.vertices for leaf in bow.leaves() for piece in leaf.pieces])
            reach = np.abs(corners[:, 0])
            distances = from_axis(corners, bow)
            ends = reach > 0.97 * reach.max()
            assert distances[ends].min() < 0.04
            assert distances.max() > 0.1


def test_bows_stand_lean_and_lie() -> None:
    tops = []
    for seed in range(60):
        shape = built("bucket", seed)
        bow = next(named(shape, "handle"))
        assert bow.motion is not None
        tops.append(max(p.vertices[:, 1].max() for leaf in bow.leaves() for p in leaf.pieces) - bow.motion.origin[1])
    assert np.mean(np.array(tops) > 0.1) > 0.25
    assert np.mean(np.array(tops) < 0.08) > 0.2
