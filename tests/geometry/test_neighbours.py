"""Nearest points of small clouds, and the largest of their features."""

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


@given(st.integers(0, 3), st.integers(1, 9), st.integers(1, 19), st.integers(1, 6), st.integers(0, 1000))
def test_the_largest_neighbours_are_those_of_numpy(clouds: int, size: int, width: int, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    features = rng.integers(-2, 3, (clouds, size, width)).astype(np.float32)
    features[rng.random(features.shape) < 0.1] = np.nan
    index = rng.integers(size, size=(clouds, 5, count))
    gathered = features[np.arange(clouds)[:, None, None], index]  # [B, m, k, C]
    expected = np.take_along_axis(index, gathered.argmax(axis=2), axis=2)
    np.testing.assert_array_equal(_core.neighbour_argmax(features, index), expected)
    backwards = np.ascontiguousarray(features[..., ::-1])[..., ::-1]
    np.testing.assert_array_equal(_core.neighbour_argmax(backwards, np.asfortranarray(index)), expected)


@pytest.mark.parametrize(
    ("features", "index", "problem"),
    [
        ((4, 3), (1, 4, 2), r"features: shape \[4, 3\], expected \[B, N, C\]"),
        ((2, 4, 3), (1, 4, 2), r"index: shape \[1, 4, 2\], expected \[2, M, K\] with K > 0"),
        ((1, 4, 3), (1, 4, 0), r"index: shape \[1, 4, 0\], expected \[1, M, K\] with K > 0"),
        ((1, 0, 3), (1, 4, 2), "index: expected integers from 0, below 0"),
    ],
)
def test_features_and_index_that_do_not_fit_are_refused_by_name(
    features: tuple[int, ...], index: tuple[int, ...], problem: str
) -> None:
    with pytest.raises(ValueError, match=problem):
        _core.neighbour_argmax(np.zeros(features, np.float32), np.zeros(index, np.int64))


@pytest.mark.parametrize("number", [-1, 4, 2**32])
def test_points_that_there_are_not_are_refused(number: int) -> None:
    with pytest.raises(ValueError, match="index: expected integers from 0, below 4"):
        _core.neighbour_argmax(np.zeros((1, 4, 3), np.float32), np.full((1, 4, 2), number))
