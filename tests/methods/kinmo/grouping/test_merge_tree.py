"""The merge tree of leaves."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from kinmo.methods.kinmo.grouping.merge_tree import Merge, merge_leaves


def all_pairs(count: int) -> np.ndarray:
    return np.array([(i, j) for i in range(count) for j in range(i + 1, count)], np.int64).reshape(-1, 2)


def clusters_above(count: int, merges: list[Merge], logit: float) -> list[list[int]]:
    """Clusters of all leaves after the merges with more than some logit."""
    clusters = {leaf: [leaf] for leaf in range(count)}
    for merge in merges:
        if merge.logit > logit:
            clusters |= {leaf: list(merge.leaves) for leaf in merge.leaves}
    return sorted(cluster for leaf, cluster in clusters.items() if leaf == cluster[0])


def test_certain_pairs_are_joined_first() -> None:
    pairs = np.array([[0, 1], [1, 2], [2, 3]])
    merges = merge_leaves(4, pairs, np.array([3.0, -2.0, 5.0]))
    assert [merge.leaves for merge in merges] == [(2, 3), (0, 1), (0, 1, 2, 3)]
    assert [merge.logit for merge in merges] == [5.0, 3.0, -2.0]


def test_leaves_without_a_pair_stay_apart() -> None:
    merges = merge_leaves(4, np.array([[0, 1]]), np.array([1.0]))
    assert [merge.leaves for merge in merges] == [(0, 1)]


@given(count=st.integers(2, 9), seed=st.integers(0, 2**31))
def test_on_a_complete_graph_scipy_finds_the_same_clusters(count: int, seed: int) -> None:
    logits = np.random.default_rng(seed).normal(size=count * (count - 1) // 2)
    ours = clusters_above(count, merge_leaves(count, all_pairs(count), logits), 0.0)
    assert squareform(logits, checks=False).shape == (count, count)
    theirs = fcluster(linkage(10.0 - logits, "average"), 10.0, "distance")
    assert ours == sorted(sorted(np.flatnonzero(theirs == label).tolist()) for label in set(theirs))
