"""The contact graph of the leaves of a shape."""

from __future__ import annotations

import numpy as np
import trimesh
from cabinet_geometry import geometry_of
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.features.contact_graph import NEAREST, REACH, close_pairs, compute_contact_graph


def boards(turn: float = 0.0) -> list[trimesh.Trimesh]:
    """A box of four boards, a knob on one of them, and a far block."""
    sizes = [(1.0, 0.02, 1.0), (0.02, 0.5, 1.0), (0.02, 0.5, 1.0), (0.96, 0.5, 0.02), (0.05, 0.05, 0.05), (0.2, 0.3, 0.2)]
    centers = [(0, 0, 0), (-0.49, 0.26, 0), (0.49, 0.26, 0), (0, 0.26, 0.49), (0, 0.3, 0.525), (3, 0, 0)]
    matrix = trimesh.transformations.rotation_matrix(turn, [0.0, 1.0, 0.0])
    pairs = zip(sizes, centers, strict=True)
    return [trimesh.creation.box(size).apply_translation(center).apply_transform(matrix) for size, center in pairs]


def test_touching_leaves_are_pairs_and_every_leaf_has_some() -> None:
    pairs, gaps = close_pairs(geometry_of(boards()))
    touching = {tuple(pair) for pair, gap in zip(pairs.tolist(), gaps, strict=True) if gap < REACH}
    assert touching >= {(0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (3, 4)}
    assert (3, 5) not in touching
    assert (np.bincount(pairs.ravel()) >= NEAREST).all()


def test_the_second_half_has_the_pairs_of_the_first_reversed() -> None:
    graph = compute_contact_graph(geometry_of(boards()))
    half = len(graph) // 2
    assert np.array_equal(graph.pairs[:half], graph.pairs[half:, ::-1])
    assert np.isfinite(graph.features).all()


def test_one_leaf_has_no_pairs() -> None:
    graph = compute_contact_graph(geometry_of(boards()[:1]))
    assert len(graph) == 0
    assert graph.features.shape[1] == compute_contact_graph(geometry_of(boards())).features.shape[1]


@settings(max_examples=10)
@given(turn=st.sampled_from([np.pi / 2, np.pi, -np.pi / 2]), seed=st.integers(0, 1000))
def test_features_do_not_depend_on_the_order_of_parts_or_a_turn_about_up(turn: float, seed: int) -> None:
    order = np.random.default_rng(seed).permutation(6)
    plain = compute_contact_graph(geometry_of(boards()))
    turned = boards(turn)
    other = compute_contact_graph(geometry_of([turned[i] for i in order]))
    rows = {tuple(pair): row for pair, row in zip(plain.pairs.tolist(), plain.features, strict=True)}
    assert {(order[a], order[b]) for a, b in other.pairs.tolist()} == rows.keys()
    for (first, second), row in zip(other.pairs.tolist(), other.features, strict=True):
        # samples differ, so that shares of samples and the middle of the contact differ a little
        assert np.median(np.abs(row - rows[order[first], order[second]])) < 0.02
