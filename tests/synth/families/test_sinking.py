"""No moving part enters the other parts, by winding numbers, which need no convex pieces."""

from __future__ import annotations

import numpy as np
import pytest
from synth_objects import bounds_of, build_object, moving_and_other_pieces, moving_links, sinking_share

from kinmo.synth.families import family_names

RETRACTING = {"button", "key", "lens", "interface", "blade", "head", "press"}
"""Links that retract into solid bodies: keys, plugs, blades and lenses."""

LEANING = {"box", "suitcase", "toilet"}
"""Families whose flaps, handles and lids end up against the housing. `test_clearance` measures their depth."""


@pytest.mark.parametrize("name", sorted(set(family_names()) - LEANING))
def test_moving_parts_do_not_enter_other_parts(name: str) -> None:
    sunk = []
    for seed in range(3):
        shape = build_object(name, seed)
        for link in moving_links(shape):
            low, high = bounds_of(moving_and_other_pieces(shape, link)[0])
            if link.name not in RETRACTING and np.linalg.norm(high - low) > 0.15:
                sunk.append(sinking_share(shape, link))
    assert not sunk or np.mean(sunk) < 0.15
    assert all(share < 0.6 for share in sunk)
