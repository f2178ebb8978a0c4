"""Means over objects and categories, and their bootstrap intervals."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kinmo.evaluation.aggregate import macro, micro, ratios


def test_intervals_cover_the_truth_as_often_as_stated():
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(100):
        successes = rng.binomial(4, 0.7, size=40)
        sums = np.stack([successes, np.full(40, 4)], axis=1)[:, None, :].astype(float)
        found = micro(sums, draws=300)[0]
        hits += found.low <= 0.7 <= found.high
    assert 85 <= hits <= 100


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5), st.sampled_from("abc")), min_size=1, max_size=20))
def test_intervals_contain_their_value_and_are_the_same_in_every_run(rows):
    sums = np.array([[[min(a, b), b]] for a, b, _ in rows], float)
    categories = [name for *_, name in rows]
    for estimate in (*micro(sums, draws=50), *macro(sums, categories)):
        if estimate is not None:
            assert 0 <= estimate.low <= estimate.high <= 1
    assert macro(sums, categories) == macro(sums, categories)


def test_a_figure_without_objects_has_no_value():
    assert np.isnan(ratios(np.array([[0.0, 0.0]])))[0]
    assert micro(np.zeros((0, 2, 2))) == [None, None]
