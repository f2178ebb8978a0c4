"""The merge tree of leaves."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from kinmo.methods.kinmo.grouping.merge_tree import clusters_above, merge_leaves


def all_pairs(count: int) -> np.ndarray:
    return np.array([(i, j) for i in range(count) for j in range(i + 1, count)], np.int64).reshape(-1, 2)


def test_certain_pairs_are_joined_first() -> None:
    pairs = np.array([[0, 1], [1, 2], [2, 3]])
    merges = merge_leaves(4, pairs, np.array([3.0, -2.0, 5.0]))
    assert [merge.leaves for merge in merges] == [(2, 3), (0, 1), (0, 1, 2, 3)]
    assert [merge.logit for merge in merges] == [5.0, 3.0, -2.0]
    assert clusters_above(4, merges) == [(0, 1), (2, 3)]


def test_leaves_without_a_pair_stay_apart() -> None:
    merges = merge_leaves(4, np.array([[0, 1]]), np.array([1.0]))
    assert clusters_above(4, merges) == [(0, 1), (2,), (3,)]


@given(count=st.integers(2, 9), seed=st.integers(0, 2**31))
def test_on_a_complete_graph_scipy_finds_the_same_clusters(count: int, seed: int) -> None:
    logits = np.random.default_rng(seed).normal(size=count * (count - 1) // 2)
    ours = clusters_above(count, merge_leaves(count, all_pairs(count), logits))
    assert squareform(logits, checks=False).shape == (count, count)
    theirs = fcluster(linkage(10.0 - logits, "average"), 10.0, "distance")
    assert sorted(map(sorted, ours)) == sorted(sorted(np.flatnonzero(theirs == label).tolist()) for label in set(theirs))


@given(count=st.integers(1, 9), seed=st.integers(0, 2**31))
def test_clusters_are_a_partition_whatever_the_threshold(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs = all_pairs(count)[rng.random(count * (count - 1) // 2) < 0.5]
    merges = merge_leaves(count, pairs, rng.normal(size=len(pairs)))
    for threshold in (-10.0, 0.0, 10.0):
        clusters = clusters_above(count, merges, threshold)
        assert sorted(leaf for cluster in clusters for leaf in cluster) == list(range(count))
