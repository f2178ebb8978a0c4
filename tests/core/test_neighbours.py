"""Nearest points of small clouds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from kinmo import _core


@given(st.integers(1, 60), st.integers(1, 12), st.integers(0, 1000))
def test_neighbours_agree_with_scipy(size: int, count: int, seed: int) -> None:
    clouds = np.random.default_rng(seed).normal(size=(3, size, 3)).astype(np.float32)
    found = _core.nearest_neighbours(clouds, count)
    assert found.shape == (3, size, min(count, size))
    for cloud, rows in zip(clouds.astype(float), found, strict=True):
        expected = cKDTree(cloud).query(cloud, min(count, size))[0].reshape(rows.shape)
        distances = np.linalg.norm(cloud[rows] - cloud[:, None], axis=2)
        np.testing.assert_allclose(distances, expected, atol=1e-6)


def test_no_clouds_and_no_points_have_no_neighbours() -> None:
    assert _core.nearest_neighbours(np.zeros((0, 5, 3), np.float32), 2).shape == (0, 5, 2)
    assert _core.nearest_neighbours(np.zeros((2, 0, 3), np.float32), 2).shape == (2, 0, 0)


@pytest.mark.parametrize(
    ("points", "count", "problem"),
    [
        (np.zeros((4, 3), np.float32), 2, r"points: shape \[4, 3\], expected \[F, N, 3\]"),
        (np.full((1, 4, 3), np.nan, np.float32), 2, "points: not finite"),
        (np.zeros((1, 4, 3), np.float32), 0, "count: 0, expected an integer from 1 to 4294967295"),
    ],
)
def test_bad_arguments_are_refused_by_name(points: np.ndarray, count: int, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        _core.nearest_neighbours(points, count)
