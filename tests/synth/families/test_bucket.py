"""Buckets: the bow turns about the line through its ends."""

from __future__ import annotations

import numpy as np
from synth_objects import axis_distances, build_object, link_vertices, links_with_leaf


def test_the_ends_of_a_bow_are_on_its_axis() -> None:
    for seed in range(30):
        for bow in links_with_leaf(build_object("bucket", seed), "handle"):
            corners = link_vertices(bow)
            reach = np.abs(corners[:, 0])
            distances = axis_distances(corners, bow)
            ends = reach > 0.97 * reach.max()
            assert distances[ends].min() < 0.04
            assert distances.max() > 0.1


def test_some_bows_stand_and_some_lie() -> None:
    tops = []
    for seed in range(60):
        shape = build_object("bucket", seed)
        bow = next(links_with_leaf(shape, "handle"))
        assert bow.motion is not None
        tops.append(max(p.vertices[:, 1].max() for leaf in bow.leaves() for p in leaf.pieces) - bow.motion.origin[1])
    assert np.mean(np.array(tops) > 0.1) > 0.25
    assert np.mean(np.array(tops) < 0.08) > 0.2
