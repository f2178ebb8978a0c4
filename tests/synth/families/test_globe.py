"""Globes: the ball has a bearing at each pole."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, moving_links


def test_a_ball_has_a_pin_at_both_poles() -> None:
    for seed in range(30):
        shape = build_object("globe", seed)
        ball = next(link for link in moving_links(shape) if link.name == "sphere")
        low, high = bounds_of(ball.nodes[0].pieces[:1])
        middle = 0.5 * (low + high)
        radius = np.linalg.norm(ball.nodes[0].pieces[0].vertices - middle, axis=1).max()
        ring = next(leaf for link in shape.links for leaf in link.leaves() if leaf.name == "circle")
        spans = [(pin.vertices - middle) @ ball.motion.direction for pin in ring.pieces[1:]]
        for pole in (-radius, radius):
            assert any(span.min() <= pole <= span.max() for span in spans)
