"""Dishwashers: racks slide out of the body, and their wheels and baskets slide along."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, link_pieces, links_with_leaf


def test_racks_slide_forward_within_the_sides_of_the_body() -> None:
    racks = 0
    for seed in range(50):
        shape = build_object("dishwasher", seed)
        low, high = bounds_of(link_pieces(shape.links[0]))
        for rack in links_with_leaf(shape, "shelf"):
            first, last = bounds_of(link_pieces(rack))
            assert rack.motion is not None and np.allclose(rack.motion.direction, (0, 0, 1))
            assert np.all(first[:2] > low[:2] - 0.01) and np.all(last[:2] < high[:2] + 0.01)
            racks += 1
    assert racks > 15


def test_a_rack_is_out_only_behind_an_open_door() -> None:
    for seed in range(150):
        shape = build_object("dishwasher", seed)
        door = next(links_with_leaf(shape, "door_frame"))
        for rack in links_with_leaf(shape, "shelf"):
            assert rack.motion is not None and door.motion is not None
            assert rack.motion.a == 0.0 or door.motion.a < -60.0
