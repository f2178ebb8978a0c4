from __future__ import annotations

import numpy as np
from built import box_of, built, named, pieces_of


def test_the_screen_turns_about_a_level_line_near_the_rear_edge_of_the_base() -> None:
    for seed in range(30):
        shape = built("laptop", seed)
        (screen,) = named(shape, "screen")
        assert screen.motion is not None
        assert np.allclose(np.abs(screen.motion.direction), (1, 0, 0))
        base = [piece for leaf in shape.links[0].leaves() if leaf.name == "base_frame" for piece in leaf.pieces]
        low, high = box_of(base)
        depth = high[2] - low[2]
        assert abs(screen.motion.origin[2] - low[2]) < 0.1 * depth
        assert low[1] < screen.motion.origin[1] < high[1] + 0.5 * (high[1] - low[1])


def test_the_closed_screen_lies_over_the_base() -> None:
    for seed in range(30):
        shape = built("laptop", seed)
        (screen,) = named(shape, "screen")
        assert screen.motion is not None
        frame = [piece for leaf in screen.leaves() if leaf.name in ("screen", "screen_frame") for piece in leaf.pieces]
        closed = screen.motion.at(screen.motion.b)
        corners = np.concatenate([piece.vertices for piece in frame]) @ closed[:3, :3].T + closed[:3, 3]
        _, top = box_of([p for leaf in shape.links[0].leaves() if leaf.name == "base_frame" for p in leaf.pieces])
        assert np.ptp(corners[:, 1]) < 0.1
        assert corners[:, 1].min() > top[1] - 0.005


def test_laptops_are_shown_open_mostly_and_closed_at_times() -> None:
    heights = []
    for seed in range(80):
        shape = built("laptop", seed)
        (screen,) = named(shape, "screen")
        heights.append(np.ptp(np.concatenate([p.vertices for p in pieces_of(shape, screen)[0]])[:, 1]))
    share_open = np.mean(np.array(heights) > 0.2)
    assert 0.7 < share_open < 1.0
