"""Refrigerators: one to four doors with hinges at either side, drawers, and chests."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, link_pieces, moving_links


def test_fronts_are_of_all_kinds() -> None:
    plans, sides, lids = set(), set(), 0
    for seed in range(120):
        links = list(moving_links(build_object("refrigerator", seed)))
        doors = [link for link in links if link.name == "door"]
        plans.add((len(doors), sum(link.name == "drawer" for link in links)))
        lids += any(link.name == "lid" for link in links)
        for door in doors:
            middle = np.mean(bounds_of(link_pieces(door)), axis=0)
            sides.add(np.sign(door.motion.origin[0] - middle[0]))
    assert {doors for doors, _ in plans} >= {0, 1, 2, 3, 4}
    assert {drawers for _, drawers in plans} >= {0, 1, 2, 3}
    assert sides == {-1.0, 1.0}
    assert lids > 1
