"""Normalisation of scans for the networks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo.scans.preprocessing.input_frame import MIN_BASE_POINTS, InputFrame, base_axes, manhattan_axes, two_pass_axes
from kinmo.scans.rendering.pinhole_camera import Viewpoints

UP = np.array([0.0, 1.0, 0.0])


def seen_box(sizes, seed, points=1024):
    """Visible points of a box in the camera frame, and the rotation to that frame; +y is up."""
    rng = np.random.default_rng(seed)
    pose = Viewpoints().sample(rng, np.zeros(3), 0.5 * float(np.linalg.norm(sizes)), UP)
    eye = -pose[:3, :3].T @ pose[:3, 3]
    sides = [(axis, sign) for axis in range(3) for sign in (-1, 1) if sign * eye[axis] > 0.5 * sizes[axis]]
    places = (rng.uniform(size=(points, 3)) - 0.5) * sizes
    for row, which in enumerate(rng.integers(len(sides), size=points)):
        axis, sign = sides[which]
        places[row, axis] = 0.5 * sign * sizes[axis]
    return places @ pose[:3, :3].T + pose[:3, 3], pose[:3, :3]


@given(st.integers(0, 10_000))
def test_the_manhattan_axes_of_a_box_are_its_sides_and_upright(seed):
    points, turn = seen_box((0.6, 1.0, 0.5), seed)
    up = turn @ UP
    is_frontal = np.abs(turn[0, [0, 2]]).min() < 0.05
    assume(not is_frontal or 0.1 < -up[2] < 0.99)  # a side seen frontally may be the front or the top
    (found,) = manhattan_axes(points[None])
    assert np.linalg.det(found) == pytest.approx(1.0)
    assert up @ -found[:, 1] > 0.999, "down is the second axis"
    assert np.abs(turn.T @ found).max(axis=0).min() > 0.999, "each axis is one of the box"
    seen = points @ found
    assert seen[:, 2].mean() >= np.abs(seen[:, 0].mean()) - 0.05, "forward is the third"


@given(st.integers(0, 10_000), st.sampled_from(["object", "scan"]))
def test_an_input_frame_can_be_undone(seed, normalised):
    rng = np.random.default_rng(seed)
    points, rotation = rng.normal(size=(20, 3)), Rotation.random(random_state=seed).as_matrix()
    frame = InputFrame.of(points, normalised, 2.0, rotation)
    np.testing.assert_allclose(frame.undo(frame.apply(points).astype(float)), points, atol=1e-5)
    turned = Rotation.random(random_state=seed + 1).as_matrix()
    there = frame.apply(points @ turned.T).astype(float) - frame.apply(np.zeros((1, 3)))
    np.testing.assert_allclose(there, points @ (frame.rotation.T @ turned).T * frame.scale, atol=1e-5)
    np.testing.assert_allclose(frame.undo_rotations(frame.rotation.T @ turned), turned, atol=1e-9)


def test_a_scan_is_normalised_by_its_box_along_the_input_axes():
    points, _ = seen_box((0.6, 1.0, 0.5), 3)
    (rotation,) = manhattan_axes(points[None])
    seen = InputFrame.of(points, "scan", rotation=rotation).apply(points)
    np.testing.assert_allclose(seen.min(axis=0), -seen.max(axis=0), atol=1e-6)
    assert np.linalg.norm(np.ptp(seen, axis=0)) == pytest.approx(1.0, abs=1e-6)


def test_the_base_decides_the_axes_behind_a_large_open_door():
    box, turn = seen_box((0.6, 1.0, 0.5), 3)
    about_up = Rotation.from_rotvec(0.5 * turn @ UP).as_matrix()
    door = (box - box.mean(axis=0)) @ about_up.T + box.mean(axis=0) - 2.0 * turn[:, 0]
    points = np.concatenate([box[:300], door])
    is_base = np.arange(len(points)) < 300
    (first,) = manhattan_axes(points[None])
    assert np.abs(turn.T @ first).max(axis=0).min() < 0.95
    few = np.arange(len(points)) < MIN_BASE_POINTS - 1
    second, still = base_axes(np.stack([points] * 2), np.stack([is_base, few]), np.stack([first] * 2))
    assert np.abs(turn.T @ second).max(axis=0).min() > 0.999
    np.testing.assert_array_equal(second, manhattan_axes(points[None, is_base])[0])
    np.testing.assert_array_equal(still, first)


def test_the_first_pass_uses_the_whole_scan_and_the_second_the_base():
    box, turn = seen_box((0.6, 1.0, 0.5), 3)
    about_up = Rotation.from_rotvec(0.5 * turn @ UP).as_matrix()
    door = (box - box.mean(axis=0)) @ about_up.T + box.mean(axis=0) - 2.0 * turn[:, 0]
    scan, parts = np.concatenate([box[:300], door]), (np.arange(300 + len(door)) >= 300).astype(np.int16)
    (first, second), (alike, still) = two_pass_axes(np.stack([scan, scan]), np.stack([parts, np.ones_like(parts)]))
    assert np.abs(turn.T @ first).max(axis=0).min() < 0.95, "the door decides"
    assert np.abs(turn.T @ second).max(axis=0).min() > 0.999, "the box does"
    np.testing.assert_array_equal(alike, first)
    np.testing.assert_array_equal(still, first)
    assert two_pass_axes(scan[None][:0], parts[None][:0]).shape == (0, 2, 3, 3)
