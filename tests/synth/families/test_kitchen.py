"""Kitchens and counters: many joints, on one side or on several."""

from __future__ import annotations

import numpy as np
import pytest
from synth_objects import build_object, moving_links

SEEDS = 30


@pytest.mark.parametrize("name", ["kitchen", "counter"])
def test_most_have_five_to_fifteen_joints(name: str) -> None:
    counts = np.array([len(list(moving_links(build_object(name, seed)))) for seed in range(SEEDS)])
    assert np.mean((counts >= 4) & (counts <= 16)) > 0.6
    assert counts.min() >= 1


def test_all_drawers_of_a_kitchen_slide_out_of_their_row() -> None:
    for seed in range(SEEDS):
        for link in moving_links(build_object("kitchen", seed)):
            if link.name == "drawer" and link.motion is not None:
                assert abs(link.motion.direction[1]) < 0.6
                assert link.motion.b > 0.0


def test_counters_open_to_several_sides() -> None:
    ways = []
    for seed in range(SEEDS):
        drawers = [link.motion for link in moving_links(build_object("counter", seed)) if link.name == "drawer"]
        ways.append({int(np.argmax([d @ m.direction for d in (*np.eye(3), *-np.eye(3))])) for m in drawers if m is not None})
    assert np.mean([len(way) > 1 for way in ways]) > 0.3
    assert set().union(*ways) >= {0, 2, 3, 5}
