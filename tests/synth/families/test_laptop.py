"""Laptops: the screen turns about a line at the rear edge of the base and closes onto it."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, links_with_leaf, moving_and_other_pieces


def test_the_screen_turns_about_a_horizontal_line_near_the_rear_edge_of_the_base() -> None:
    for seed in range(30):
        shape = build_object("laptop", seed)
        (screen,) = links_with_leaf(shape, "screen")
        assert screen.motion is not None
        assert np.allclose(np.abs(screen.motion.direction), (1, 0, 0))
        base = [piece for leaf in shape.links[0].leaves() if leaf.name == "base_frame" for piece in leaf.pieces]
        low, high = bounds_of(base)
        depth = high[2] - low[2]
        assert abs(screen.motion.origin[2] - low[2]) < 0.1 * depth
        assert low[1] < screen.motion.origin[1] < high[1] + 0.5 * (high[1] - low[1])


def test_the_closed_screen_lies_over_the_base() -> None:
    for seed in range(30):
        shape = build_object("laptop", seed)
        (screen,) = links_with_leaf(shape, "screen")
        assert screen.motion is not None
        frame = [piece for leaf in screen.leaves() if leaf.name in ("screen", "screen_frame") for piece in leaf.pieces]
        closed = screen.motion.at(screen.motion.b)
        corners = np.concatenate([piece.vertices for piece in frame]) @ closed[:3, :3].T + closed[:3, 3]
        _, top = bounds_of([p for leaf in shape.links[0].leaves() if leaf.name == "base_frame" for p in leaf.pieces])
        assert np.ptp(corners[:, 1]) < 0.1
        assert corners[:, 1].min() > top[1] - 0.005


def test_most_laptops_are_shown_open_and_some_closed() -> None:
    heights = []
    for seed in range(80):
        shape = build_object("laptop", seed)
        (screen,) = links_with_leaf(shape, "screen")
        heights.append(np.ptp(np.concatenate([p.vertices for p in moving_and_other_pieces(shape, screen)[0]])[:, 1]))
    share_open = np.mean(np.array(heights) > 0.2)
    assert 0.7 < share_open < 1.0
