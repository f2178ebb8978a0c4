"""Chests of drawers and cupboards: fronts side by side, which all open to the front."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from synth_objects import bounds_of, build_object, moving_links

FRONTS = {"drawer_front", "cabinet_door_surface"}


def test_fronts_do_not_overlap() -> None:
    for seed in range(60):
        boxes = [
            bounds_of(leaf.pieces)
            for link in moving_links(build_object("chest", seed))
            for leaf in link.leaves()
            if leaf.name in FRONTS and link.motion is not None and link.motion.rest == 0.0
        ]
        for one, other in combinations(boxes, 2):
            shared = np.minimum(one[1], other[1]) - np.maximum(one[0], other[0])
            assert shared.min() < 1e-9


def test_slides_are_level_and_hinges_upright() -> None:
    links = [link for seed in range(40) for link in moving_links(build_object("chest", seed))]
    motions = [link.motion for link in links if link.motion is not None]
    assert all(abs(motion.direction[1]) == 1.0 for motion in motions if motion.is_hinge)
    assert all(motion.direction[1] == 0.0 for motion in motions if not motion.is_hinge)
    assert 0.2 < np.mean([motion.is_hinge for motion in motions]) < 0.8
