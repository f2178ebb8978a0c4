"""Boosted trees on features of any kind."""

import numpy as np

from kinmo.evaluation.trees import choices, fit_kinds, fit_rank
from kinmo.joint import CoarseType


def test_the_best_row_of_a_group_is_chosen_and_ties_go_to_the_first():
    groups, values = np.array([4, 4, 7, 7, 4]), np.array([0.1, 0.9, 0.5, 0.5, 0.2])
    assert choices(groups, values) == {4: 1, 7: 2}


def test_trees_learn_to_pick_and_to_class_what_features_show():
    rng = np.random.default_rng(0)
    groups = np.repeat(np.arange(60), 8)
    right = np.zeros(480, bool)
    right[np.arange(60) * 8 + rng.integers(0, 8, 60)] = True
    features = rng.normal(size=(480, 5)) + 6.0 * right[:, None] * [1, 0, 0, 0, 0]
    train = groups < 40
    picks = fit_rank(features[train], groups[train], right[train], iterations=30).pick(features[~train], groups[~train])
    assert np.mean([right[~train][row] for row in picks.values()]) > 0.8
    kinds = np.where(features[:, 0] > 3.0, CoarseType.R, CoarseType.FIXED)
    found = fit_kinds(features[train], kinds[train], iterations=30).probabilities(features[~train], len(CoarseType))
    assert np.mean(found.argmax(axis=1) == kinds[~train]) > 0.95
    assert np.all(found[:, CoarseType.PR] == 0)
