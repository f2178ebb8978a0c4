"""Candidate axes of one part: box lines, merging, and distinct directions."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.oriented_box import Box
from kinmo.features.candidate_lines import LineSource, box_lines, candidate_lines, distinct_directions, merge_lines


def test_a_box_has_twelve_edges_and_three_centre_lines() -> None:
    box = Box(np.array([1.0, 2.0, 3.0]), np.eye(3), np.array([0.5, 0.3, 0.1]))
    directions, pivots, is_edge = box_lines(box)
    assert is_edge.sum() == 12
    assert len(directions) == 15
    corners = box.corners()
    for direction, pivot in zip(directions[is_edge], pivots[is_edge], strict=True):
        offset = corners - pivot
        on_line = np.linalg.norm(offset - np.outer(offset @ direction, direction), axis=1) < 1e-12
        assert on_line.sum() == 2
    np.testing.assert_allclose(pivots[~is_edge], np.tile(box.center, (3, 1)))


@settings(max_examples=50)
@given(st.integers(0, 10_000))
def test_merging_keeps_one_of_equal_lines_and_all_their_sources(seed: int) -> None:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(6, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    pivots = rng.normal(size=(6, 3))
    moved_along = pivots + rng.normal(size=(6, 1)) * directions
    sources = np.concatenate([np.zeros(6, int), np.full(6, LineSource.CONTACT_LINE)])
    merged = merge_lines(np.vstack([directions, -directions]), np.vstack([pivots, moved_along]), sources, np.zeros(3))
    assert len(merged) == 6
    assert merged.sources[:, [0, LineSource.CONTACT_LINE]].all()
    np.testing.assert_allclose(np.sum(merged.pivots * merged.directions, axis=1), 0.0, atol=1e-9)


def test_two_equal_boxes_add_no_candidates() -> None:
    box = Box(np.zeros(3), np.eye(3), np.array([0.5, 0.3, 0.1]))
    contact = np.array([[0.5, -0.3, 0.1], [0.5, 0.3, 0.1]])
    lines = candidate_lines(box, box, contact, np.ones(2) / 2, {})
    edges = lines.sources[:, LineSource.MINIMUM_BOX_EDGE]
    assert edges.sum() == 12
    assert lines.sources[edges][:, LineSource.ALIGNED_BOX_EDGE].all()
    assert lines.sources[edges][:, LineSource.CONTACT_LINE].sum() == 1
    assert len(distinct_directions(lines)) == 3
