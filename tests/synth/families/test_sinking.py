"""MovingPart parts do not go through the rest, by winding numbers, which need no convex pieces."""

from __future__ import annotations

import numpy as np
import pytest
from built import box_of, built, movable, pieces_of, sinking

from kinmo.synth.families import family_names

RETRACTING = {"button", "key", "lens", "interface", "blade", "head", "press"}
"""Keys that press into their housing, plugs and blades that retract into bodies built solid, lenses that go into each other."""

LEANING = {"box", "suitcase", "toilet"}
"""Families whose flaps, handles and lids end up against the housing; how deep is asked elsewhere (`test_clearance`)."""


@pytest.mark.parametrize("name", sorted(set(family_names()) - LEANING))
def test_moving_parts_do_not_sink_into_the_rest(name: str) -> None:
    sunk = []
    for seed in range(5):
        shape = built(name, seed)
        for link in movable(shape):
            low, high = box_of(pieces_of(shape, link)[0])
            if link.name not in RETRACTING and np.linalg.norm(high - low) > 0.15:
                sunk.append(sinking(shape, link))
    assert not sunk or np.mean(sunk) < 0.15
    assert all(share < 0.6 for share in sunk)
