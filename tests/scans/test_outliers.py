"""Points far from all others."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinmo.scans.outliers import are_strays

F64 = NDArray[np.float64]


def strays(points: F64) -> NDArray[np.bool_]:
    return are_strays(points, points)


def surface(count: int, seed: int = 0) -> F64:
    """Points on two sides of a box of 1 by 1 by 2, two away from the camera."""
    rng = np.random.default_rng(seed)
    points = rng.random((count, 3)) * [1.0, 1.0, 2.0]
    points[: count // 2, 0], points[count // 2 :, 2] = 0.0, 0.0
    return points + [0.0, 0.0, 2.0]


@pytest.mark.parametrize("count", [64, 200, 1024])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_points_diagonals_away_are_strays_and_no_others_whatever_the_size_and_density(count: int, size: float) -> None:
    own = surface(count)
    far = np.array([[8.0, 0.0, 2.0], [0.5, -9.0, 3.0]])
    np.testing.assert_array_equal(strays(np.vstack([own, far]) * size), [False] * count + [True] * 2)


def test_nothing_of_a_surface_is_a_stray() -> None:
    assert not any(strays(surface(count, seed)).any() for count in (1, 63, 100, 1024) for seed in range(10))


def test_a_second_piece_of_many_points_is_seen_wherever_it_is() -> None:
    assert not strays(np.vstack([surface(900), surface(100) + [5.0, 0.0, 0.0]])).any()


def test_a_few_points_near_the_rest_are_the_edge_of_something_and_no_strays() -> None:
    edge = np.array([[1.4, 0.5, 2.5], [1.4, 0.6, 2.5]])  # the diagonal is 2.4
    assert not strays(np.vstack([surface(1000), edge])).any()
    assert strays(np.vstack([surface(1000), edge + [1.0, 0.0, 0.0]])).sum() == 2


def test_flying_points_are_strays_even_in_a_row() -> None:
    row = np.array([[0.5, 0.5, 6.0]]) + np.arange(5)[:, None] * [0.0, 0.0, 0.1]
    np.testing.assert_array_equal(np.flatnonzero(strays(np.vstack([surface(1000), row]))), np.arange(1000, 1005))


def test_what_is_evenly_scattered_has_no_strays() -> None:
    assert not strays(np.random.default_rng(0).random((100, 3))).any()


def test_some_of_the_points_tell_which_of_all_are_strays() -> None:
    own, far = surface(5000), np.array([[8.0, 0.0, 2.0]])
    np.testing.assert_array_equal(are_strays(np.vstack([own, far]), own[::5]), [False] * 5000 + [True])
