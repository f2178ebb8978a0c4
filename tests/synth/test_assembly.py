"""Assembly: pieces are joined, split or refitted without changing which link they belong to."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
from synth_objects import bounds_of, link_pieces

from kinmo.synth.assembly import MAX_FIT, assemble, connected_pieces
from kinmo.synth.draw import Draw
from kinmo.synth.families import family_builder
from kinmo.synth.primitives import box, cylinder, join, move


def test_a_mesh_splits_into_its_connected_surfaces() -> None:
    parts = [box((1, 1, 1)), move(cylinder(0.2, 1.0), (3, 0, 0)), move(box((1, 2, 1)), (0, 3, 0))]
    found = connected_pieces(join(*parts))
    assert sorted(len(piece.faces) for piece in found) == sorted(len(piece.faces) for piece in parts)
    assert sorted(len(piece.vertices) for piece in found) == sorted(len(piece.corners) for piece in parts)


def test_links_keep_their_shape_up_to_the_fit_of_their_boards() -> None:
    forms = set()
    for seed in range(40):
        before = family_builder(["storage_furniture", "dishwasher"][seed % 2])(Draw(np.random.default_rng(seed)))
        after = deepcopy(before)
        assemble(after, Draw(np.random.default_rng(seed)))
        after.check()
        low, high = before.bounds()
        tolerance = MAX_FIT * np.linalg.norm(high - low)
        for link, changed in zip(before.links, after.links, strict=True):
            offsets = np.abs(np.array(bounds_of(link_pieces(link))) - bounds_of(link_pieces(changed)))
            assert offsets.max() <= tolerance + 1e-9
            assert sum(len(p.faces) for p in link_pieces(link)) == sum(len(p.faces) for p in link_pieces(changed))
            forms.add(np.sign(len(link_pieces(changed)) - len(link_pieces(link))))
    assert forms == {-1, 0, 1}
