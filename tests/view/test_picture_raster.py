"""Shaded pictures: what the camera sees, which part is in front, how bright it is, and where lines are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.shape import Mesh
from kinmo.view.picture_raster import AMBIENT, DISTANCE, LIGHT, OUTLINE, Camera, front_left, shade

Y_UP, Z_UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
RED, GREEN = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
SQUARE = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
SIZE = 40


def square(center: np.ndarray, scale: float = 1.0) -> Mesh:
    """A square that faces +z."""
    return Mesh(scale * SQUARE + center, FACES)


def frontal(size: int = SIZE) -> Camera:
    """A camera that looks along -z."""
    rotation = np.diag([1.0, -1.0, -1.0])
    return Camera(rotation, np.zeros(3), 1.0, 2.0 * size, np.full(2, 0.5 * size), size)


@pytest.mark.parametrize("is_reversed", [False, True])
def test_a_nearer_part_hides_a_farther_one_whatever_the_order(is_reversed: bool) -> None:
    meshes = [square(np.array([0.0, 0.0, 0.5]), 0.5), square(np.zeros(3))]
    colors = np.stack([RED, GREEN])
    order = slice(None, None, -1 if is_reversed else 1)
    picture = shade(frontal(), meshes[order], colors[order])
    assert picture[SIZE // 2, SIZE // 2, 0] and not picture[SIZE // 2, SIZE // 2, 1], "the small square is in front"
    edge = SIZE // 2 - int(0.8 * 2 * SIZE / 6)
    assert picture[edge, edge, 1] and not picture[edge, edge, 0]


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000))
def test_brightness_follows_the_angle_to_the_light(seed: int) -> None:
    rng = np.random.default_rng(seed)
    camera = frontal(60)
    slopes = rng.uniform(-1.0, 1.0, 2)
    plane = 0.5 * SQUARE
    plane[:, 2] = plane[:, :2] @ slopes
    normal = np.append(-slopes, 1.0) / np.linalg.norm([*slopes, 1.0])
    picture = shade(camera, [Mesh(plane, FACES)], np.ones((1, 3)))
    expected = AMBIENT + (1.0 - AMBIENT) * abs(camera.rotation @ normal @ LIGHT)
    assert picture[30, 30, :3] == pytest.approx(np.full(3, 255.0 * expected), abs=2.0)


def test_both_sides_of_a_triangle_are_lit_alike() -> None:
    front = Mesh(SQUARE, FACES)
    back = Mesh(SQUARE, FACES[:, ::-1])
    pictures = [shade(frontal(), [mesh], np.ones((1, 3))) for mesh in (front, back)]
    np.testing.assert_array_equal(*pictures)


def test_dark_lines_run_between_parts_but_not_within_them() -> None:
    halves = [Mesh(SQUARE * [0.5, 1.0, 1.0] + [side, 0.0, 0.0], FACES) for side in (-0.5, 0.5)]
    row = shade(frontal(), halves, np.ones((2, 3)))[SIZE // 2, :, 0].astype(float)
    inside = row[SIZE // 2 - 4]
    middle = row[SIZE // 2 - 1 : SIZE // 2 + 1]
    assert middle.min() == pytest.approx(0.5 * (1.0 + OUTLINE) * inside, abs=2.0), "one of two samples is dark"
    assert row[SIZE // 2 - 6 : SIZE // 2 - 2] == pytest.approx(np.full(4, inside))


def test_degenerate_triangles_leave_the_picture_empty() -> None:
    point = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.uint32))
    line = Mesh(np.array([[0.0, 0, 0], [1, 1, 1], [2, 2, 2]]), np.array([[0, 1, 2]], np.uint32))
    camera = front_left(np.concatenate([point.vertices, line.vertices]), Y_UP, 16)
    picture = shade(camera, [point, line], np.ones((2, 3)))
    assert picture.shape == (16, 16, 4)
    assert not picture[..., 3].any()


def test_empty_pixels_are_transparent_and_borders_are_smooth() -> None:
    triangle = Mesh(SQUARE, FACES[:1])
    alpha = shade(frontal(), [triangle], np.ones((1, 3)))[..., 3]
    assert alpha[0, 0] == 0 and alpha.max() == 255
    assert set(np.unique(alpha)) > {0, 255}


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
