"""Groups of points of a PointNet++."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from kinmo import _core


@given(st.integers(1, 40), st.integers(1, 12), st.floats(0.2, 2.0), st.integers(1, 9), st.integers(0, 1000))
def test_points_are_grouped_as_numpy_groups_them(size: int, centers: int, radius: float, members: int, seed: int) -> None:
    clouds = np.random.default_rng(seed).normal(size=(3, size, 3)).astype(np.float32)
    found = _core.group_points(clouds, centers, radius, members)
    for cloud, chosen, groups, nearest, distances in zip(clouds.astype(float), *found, strict=True):
        apart = cdist(cloud, cloud)
        expected = [0]
        while len(expected) < min(centers, size):
            expected.append(int(apart[:, expected].min(axis=1).argmax()))
        np.testing.assert_array_equal(chosen, expected)
        for center, group in zip(chosen, groups, strict=True):
            within = np.flatnonzero(apart[center] <= radius)[: min(members, size)]
            np.testing.assert_array_equal(group, np.pad(within, (0, len(group) - len(within)), constant_values=within[0]))
        order = apart[:, chosen].argsort(axis=1, kind="stable")[:, :3]
        np.testing.assert_array_equal(nearest, order)
        np.testing.assert_allclose(distances, np.take_along_axis(apart[:, chosen], order, axis=1), atol=1e-6)


def test_no_clouds_and_no_points_have_no_groups() -> None:
    shapes = [each.shape for each in _core.group_points(np.zeros((0, 5, 3), np.float32), 4, 0.5, 2)]
    assert shapes == [(0, 4), (0, 4, 2), (0, 5, 3), (0, 5, 3)]
    shapes = [each.shape for each in _core.group_points(np.zeros((2, 0, 3), np.float32), 4, 0.5, 2)]
    assert shapes == [(2, 0), (2, 0, 0), (2, 0, 0), (2, 0, 0)]


@pytest.mark.parametrize(
    ("points", "centers", "radius", "members", "problem"),
    [
        (np.zeros((4, 3), np.float32), 2, 0.1, 2, r"points: shape \[4, 3\], expected \[F, N, 3\]"),
        (np.full((1, 4, 3), np.nan, np.float32), 2, 0.1, 2, "points: not finite"),
        (np.zeros((1, 4, 3), np.float32), 0, 0.1, 2, "centers: 0, expected an integer from 1 to 4294967295"),
        (np.zeros((1, 4, 3), np.float32), 2, 0.1, -1, "members: -1, expected an integer from 1 to 4294967295"),
        (np.zeros((1, 4, 3), np.float32), 2, -0.1, 2, "radius: -0.1, expected 0 to"),
        (np.zeros((1, 4, 3), np.float32), 2, np.nan, 2, "radius: NaN, expected 0 to"),
        (np.zeros((1, 4, 3), np.float32), 2, 10**400, 2, "radius: inf, expected 0 to"),
    ],
)
def test_bad_arguments_are_refused_by_name(points: np.ndarray, centers: int, radius: float, members: int, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        _core.group_points(points, centers, radius, members)
