"""Outliers of scans."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinmo.scans.preprocessing.outliers import find_outliers

F64 = NDArray[np.float64]


def outliers_of(points: F64) -> NDArray[np.bool_]:
    return find_outliers(points, points)


def surface(count: int, seed: int = 0) -> F64:
    """Points on two sides of a box of 1 x 1 x 2, at distance 2 from the camera."""
    rng = np.random.default_rng(seed)
    points = rng.random((count, 3)) * [1.0, 1.0, 2.0]
    points[: count // 2, 0], points[count // 2 :, 2] = 0.0, 0.0
    return points + [0.0, 0.0, 2.0]


@pytest.mark.parametrize("count", [64, 200, 1024])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_points_diagonals_away_are_outliers_at_any_size_and_density(count: int, size: float) -> None:
    own = surface(count)
    far = np.array([[8.0, 0.0, 2.0], [0.5, -9.0, 3.0]])
    np.testing.assert_array_equal(outliers_of(np.vstack([own, far]) * size), [False] * count + [True] * 2)


def test_a_surface_has_no_outliers() -> None:
    assert not any(outliers_of(surface(count, seed)).any() for count in (1, 63, 100, 1024) for seed in range(10))


def test_a_second_large_cluster_is_kept_anywhere() -> None:
    assert not outliers_of(np.vstack([surface(900), surface(100) + [5.0, 0.0, 0.0]])).any()


def test_a_few_points_near_the_others_are_kept() -> None:
    edge = np.array([[1.4, 0.5, 2.5], [1.4, 0.6, 2.5]])  # the diagonal is 2.4
    assert not outliers_of(np.vstack([surface(1000), edge])).any()
    assert outliers_of(np.vstack([surface(1000), edge + [1.0, 0.0, 0.0]])).sum() == 2


def test_a_row_of_flying_points_are_outliers() -> None:
    row = np.array([[0.5, 0.5, 6.0]]) + np.arange(5)[:, None] * [0.0, 0.0, 0.1]
    np.testing.assert_array_equal(np.flatnonzero(outliers_of(np.vstack([surface(1000), row]))), np.arange(1000, 1005))


def test_evenly_scattered_points_have_no_outliers() -> None:
    assert not outliers_of(np.random.default_rng(0).random((100, 3))).any()


def test_a_sample_of_the_points_is_enough() -> None:
    own, far = surface(5000), np.array([[8.0, 0.0, 2.0]])
    np.testing.assert_array_equal(find_outliers(np.vstack([own, far]), own[::5]), [False] * 5000 + [True])
