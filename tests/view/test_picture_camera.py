"""The camera of pictures sees the whole object, from the front left, with up pointing up."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.view.picture_camera import DISTANCE, front_left

Y_UP, Z_UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def random_points(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(50, 3)) * rng.uniform(0.01, 100, 3) + rng.normal(size=3) * 1000


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000), z_up=st.booleans())
def test_the_camera_sees_every_point_with_up_pointing_up(seed: int, z_up: bool) -> None:
    points, up = random_points(seed), Z_UP if z_up else Y_UP
    camera = front_left(points, up, 100)
    pixels = camera.project(points)
    assert pixels.min() >= 9.9 and pixels.max() <= 90.1
    assert np.ptp(pixels, axis=0).max() == pytest.approx(80.0), "the object fills the picture"
    np.testing.assert_allclose(camera.rotation @ camera.rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(camera.rotation) == pytest.approx(1.0)
    foot, top = camera.project(np.stack([camera.middle, camera.middle + 0.1 * camera.radius * up]))
    assert top[1] < foot[1]
    assert top[0] == pytest.approx(foot[0], abs=1e-6)


@pytest.mark.parametrize(("up", "front"), [(Y_UP, np.array([0.0, 0.0, 1.0])), (Z_UP, np.array([0.0, -1.0, 0.0]))])
def test_the_front_is_nearer_and_the_left_side_is_seen(up: np.ndarray, front: np.ndarray) -> None:
    camera = front_left(random_points(0), up, 100)
    left = np.cross(front, up)
    for side in (front, left, up):
        near, far = camera.to_view(camera.middle + np.stack([side, -side]))[:, 2]
        assert near < DISTANCE < far


def test_a_single_point_is_in_the_middle_of_the_picture() -> None:
    np.testing.assert_allclose(front_left(np.ones((1, 3)), Y_UP, 100).project(np.ones(3)), [50.0, 50.0])


def test_pictures_do_not_depend_on_the_unit_of_length() -> None:
    points = random_points(3)
    pixels = [front_left(scale * points, Y_UP, 100).project(scale * points) for scale in (1.0, 1000.0)]
    np.testing.assert_allclose(pixels[0], pixels[1], rtol=1e-9)
