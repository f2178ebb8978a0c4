"""Boosted trees on any features."""

import numpy as np

from kinmo.core.motion_types import CoarseType
from kinmo.experiments.table1.trees import fit_kinds, fit_rank


def test_trees_learn_to_rank_and_to_classify():
    rng = np.random.default_rng(0)
    groups = np.repeat(np.arange(60), 8)
    right = np.zeros(480, bool)
    right[np.arange(60) * 8 + rng.integers(0, 8, 60)] = True
    features = rng.normal(size=(480, 5)) + 6.0 * right[:, None] * [1, 0, 0, 0, 0]
    train = groups < 40
    likelihoods = fit_rank(features[train], groups[train], right[train], iterations=30).likelihoods(features[~train])
    best = likelihoods.reshape(-1, 8).argmax(axis=1)
    assert np.mean(right[~train].reshape(-1, 8)[np.arange(len(best)), best]) > 0.8
    kinds = np.where(features[:, 0] > 3.0, CoarseType.R, CoarseType.FIXED)
    found = fit_kinds(features[train], kinds[train], iterations=30).probabilities(features[~train], len(CoarseType))
    assert np.mean(found.argmax(axis=1) == kinds[~train]) > 0.95
    assert np.all(found[:, CoarseType.PR] == 0)
