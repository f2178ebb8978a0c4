"""Pinhole cameras and viewpoints."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import directions, vectors
from hypothesis import given
from hypothesis import strategies as st

from kinmo.scans.rendering.pinhole_camera import Camera, Viewpoints, look_at


def test_back_projected_points_project_to_their_pixels() -> None:
    camera = Camera(7, 5, np.array([4.0, 3.0]), np.array([3.2, 2.9]), 0.1, 10.0)
    depths = np.random.default_rng(0).uniform(1.0, 3.0, (5, 7))
    points = camera.back_project(depths)
    columns = camera.focal[0] * points[..., 0] / points[..., 2] + camera.center[0]
    rows = camera.focal[1] * points[..., 1] / points[..., 2] + camera.center[1]
    np.testing.assert_allclose(columns, np.broadcast_to(np.arange(7) + 0.5, (5, 7)))
    np.testing.assert_allclose(rows, np.broadcast_to(np.arange(5)[:, None] + 0.5, (5, 7)))
    some = np.array([3, 20, 34])
    np.testing.assert_array_equal(camera.back_project(depths.ravel()[some], some), points.reshape(-1, 3)[some])


def test_the_field_of_view_is_vertical() -> None:
    camera = Camera.from_field_of_view(512, 512, 75.0, 0.01, 10.0)
    assert 2 * np.degrees(np.arctan(256 / camera.focal[1])) == pytest.approx(75.0)


@given(vectors, vectors, directions)
def test_a_camera_looks_at_its_target_with_up_above(eye, target, up) -> None:
    if np.linalg.norm(target - eye) < 1e-3:
        return
    pose = look_at(eye, target, up)
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(pose[:3, :3] @ target + pose[:3, 3], [0.0, 0.0, np.linalg.norm(target - eye)], atol=1e-9)
    np.testing.assert_allclose(pose[:3, :3] @ eye + pose[:3, 3], np.zeros(3), atol=1e-9)
    shown = pose[:3, :3] @ up
    assert shown[1] <= 1e-6, "y points down in the picture"


@given(st.integers(0, 2**32 - 1), directions)
def test_viewpoints_are_within_their_ranges(seed, up) -> None:
    center, radius = np.array([1.0, -2.0, 0.5]), 0.7
    views = Viewpoints(target_offset=0.0)
    pose = views.sample(np.random.default_rng(seed), center, radius, up)
    eye = -pose[:3, :3].T @ pose[:3, 3]
    unit = radius * np.tan(np.radians(37.5))
    distance = np.linalg.norm(eye - center)
    assert 2.3 * unit - 1e-9 <= distance <= 3.3 * unit + 1e-9
    height = np.degrees(np.arcsin(np.clip((eye - center) @ up / distance, -1, 1)))
    assert -5.0 - 1e-6 <= height <= 90.0 + 1e-6
