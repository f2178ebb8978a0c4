"""Geometry of the leaves of one shape: the object's own axes, and the riders of a part."""

from __future__ import annotations

import numpy as np
from cabinet_geometry import DOOR, DRAWER, FRAME, KNOB, UP, cabinet_geometry
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo.features.shape_geometry import object_frame

angles = st.floats(-np.pi, np.pi)


def cuboid_normals(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Normals and areas of a cuboid that is turned about up."""
    turn = Rotation.from_rotvec(angle * UP).as_matrix()
    axes = np.vstack([np.eye(3), -np.eye(3)]) @ turn.T
    return axes, np.array([3.0, 1.0, 2.0, 3.0, 1.0, 2.0])


@given(angles)
def test_the_objects_axes_follow_its_flat_faces(angle: float) -> None:
    normals, weights = cuboid_normals(angle)
    frame = object_frame(normals, weights, UP)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(frame[2], UP)
    np.testing.assert_allclose(np.sort(np.abs(normals[[0, 2]] @ frame[:2].T), axis=1), [[0, 1], [0, 1]], atol=1e-6)


@given(angles, st.integers(0, 1000))
def test_round_surfaces_do_not_turn_the_objects_axes(angle: float, seed: int) -> None:
    normals, weights = cuboid_normals(angle)
    around = np.random.default_rng(seed).uniform(0, 2 * np.pi, 200)
    round_side = np.column_stack([np.cos(around), np.zeros(200), np.sin(around)])
    frame = object_frame(np.vstack([normals, round_side]), np.concatenate([weights, np.full(200, 0.01)]), UP)
    assert np.abs(normals[0] @ frame[:2].T).max() > np.cos(np.radians(1.0))


def test_a_knob_moves_with_its_door() -> None:
    cabinet = cabinet_geometry()
    assert cabinet.surroundings([DOOR]) == ([FRAME, DRAWER], [KNOB])
    assert cabinet.surroundings([DRAWER]) == ([FRAME, DOOR, KNOB], [])
    assert cabinet.surroundings([KNOB])[1] == []
