"""The depth buffer against casting one ray a pixel."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.view.picture_camera import Camera, front_left
from kinmo.view.picture_raster import shade, visible_faces

UP = np.array([0.0, 1.0, 0.0])


def seen_by_rays(camera: Camera, triangles: np.ndarray) -> np.ndarray:
    """The nearest triangle at every pixel centre, by Moeller and Trumbore's test along the view direction."""
    faces = np.full((camera.size, camera.size), -1)
    half = 0.5 * camera.size
    for row in range(camera.size):
        for column in range(camera.size):
            offset = np.array([column + 0.5 - half, half - row - 0.5]) / camera.scale
            origin = camera.center + offset @ camera.rows[:2]
            best = -np.inf
            for index, (a, b, c) in enumerate(triangles):
                system = np.column_stack([b - a, c - a, -camera.rows[2]])
                if abs(np.linalg.det(system)) < 1e-9:
                    continue
                u, v, t = np.linalg.solve(system, origin - a)
                if u >= 0 and v >= 0 and u + v <= 1 and t > best:
                    best, faces[row, column] = t, index
    return faces


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 12))
def test_every_pixel_shows_the_triangle_that_a_ray_meets_first(seed: int, count: int) -> None:
    triangles = np.random.default_rng(seed).uniform(-1, 1, (count, 3, 3))
    camera = front_left(triangles.reshape(-1, 3), UP, 24)
    drawn, cast = visible_faces(camera, triangles), seen_by_rays(camera, triangles)
    assert np.mean(drawn == cast) > 0.995  # a pixel centre on an edge may go either way


@pytest.mark.parametrize("limit", [1, 50, 10_000])
def test_what_is_seen_does_not_depend_on_how_much_is_tested_at_once(limit: int, monkeypatch: pytest.MonkeyPatch) -> None:
    triangles = np.random.default_rng(0).uniform(-1, 1, (20, 3, 3))
    camera = front_left(triangles.reshape(-1, 3), UP, 40)
    whole = visible_faces(camera, triangles)
    monkeypatch.setattr("kinmo.view.picture_raster.SAMPLES_AT_ONCE", limit)
    np.testing.assert_array_equal(visible_faces(camera, triangles), whole)


def test_degenerate_triangles_leave_the_picture_empty() -> None:
    triangles = np.array([[[0.0, 0, 0]] * 3, [[0.0, 0, 0], [1, 1, 1], [2, 2, 2]]])
    camera = front_left(triangles.reshape(-1, 3), UP, 16)
    picture = shade(camera, triangles, np.ones((2, 3)), np.array([0, 1]))
    assert picture.shape == (16, 16, 4)
    assert not picture[..., 3].any()


def test_a_nearer_part_hides_a_farther_one_whatever_the_order() -> None:
    camera = Camera(np.eye(3), np.zeros(3), 10.0, 20)
    far = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]])
    near = far + np.array([0, 0, 0.5])
    assert visible_faces(camera, np.stack([far, near]))[10, 10] == 1
    assert visible_faces(camera, np.stack([near, far]))[10, 10] == 0


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000), z_up=st.booleans())
def test_the_camera_sees_every_point_with_up_pointing_up(seed: int, z_up: bool) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(50, 3)) * rng.uniform(0.01, 100, 3) + rng.normal(size=3) * 1000
    up = np.array([0.0, 0.0, 1.0]) if z_up else UP
    camera = front_left(points, up, 100)
    pixels, _ = camera.project(points)
    assert pixels.min() >= 9.9 and pixels.max() <= 90.1
    np.testing.assert_allclose(camera.rows @ camera.rows.T, np.eye(3), atol=1e-12)
    foot, top = camera.project(np.stack([points[0], points[0] + up]))[0]
    assert top[1] < foot[1]
    assert abs(top[0] - foot[0]) < 1e-6
