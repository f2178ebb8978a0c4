"""Which scans, and which of their points, networks are trained on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.learning.ancsh.data import drawn, odds


def test_objects_with_true_labels_have_their_share_of_a_batch() -> None:
    np.testing.assert_allclose(odds("abcd", [True, False, False, False], 0.5), [1 / 2, 1 / 6, 1 / 6, 1 / 6])
    for trusted in ([True, True, True, False], [True, True], [False, False]):
        np.testing.assert_allclose(odds(range(len(trusted)), trusted, 0.5), 1 / len(trusted))
    np.testing.assert_allclose(odds("abcd", [True, False, False, False], 0.0), 1 / 4)


def test_an_object_is_drawn_as_often_in_few_files_as_in_many() -> None:
    np.testing.assert_allclose(odds("aab", [True] * 3, 0.5), [1 / 4, 1 / 4, 1 / 2])
    np.testing.assert_allclose(odds("aabb", [True, True, False, False], 0.8), [0.4, 0.4, 0.1, 0.1])


@pytest.mark.parametrize(("balance", "shares"), [(0.0, (0.09, 0.9, 0.01)), (0.5, (0.222, 0.703, 0.074)), (1.0, (1 / 3,) * 3)])
def test_of_parts_that_scans_show_little_of_more_points_are_drawn(balance: float, shares: tuple[float, ...]) -> None:
    rng = np.random.default_rng(0)
    parts = rng.permutation(np.repeat([0, 1, -1], [900, 9000, 100]))
    found = [np.bincount(parts[drawn(parts, 20, balance, rng)] + 1, minlength=3) for _ in range(500)]
    none, first, second = np.sum(found, axis=0) / (20 * 500)
    assert (first, second, none) == pytest.approx(shares, abs=0.02)


@given(st.lists(st.integers(-1, 3), min_size=1, max_size=40), st.integers(1, 60), st.floats(0.0, 1.0), st.integers(0, 99))
def test_points_are_drawn_once_where_there_are_as_many(parts: list[int], count: int, balance: float, seed: int) -> None:
    found = drawn(np.array(parts), count, balance, np.random.default_rng(seed))
    assert len(found) == count
    assert set(found) <= set(range(len(parts)))
    assert count > len(parts) or len(set(found)) == count
