"""Rotations between frames."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import rotations
from hypothesis import given
from scipy.spatial.transform import Rotation

from kinmo.core.frames import AXIS_VECTORS, USUAL_FRONT, Y_UP_TO_Z_UP, Axis, roll_pitch_yaw, y_up_rotation, z_up_rotation


@given(rotations)
def test_up_is_rotated_to_z(rotation: np.ndarray) -> None:
    up = rotation[:, 1]
    to_z_up = z_up_rotation(up)
    assert to_z_up @ up == pytest.approx([0, 0, 1], abs=1e-9)
    assert to_z_up @ to_z_up.T == pytest.approx(np.eye(3), abs=1e-9)
    assert np.linalg.det(to_z_up) == pytest.approx(1)


def test_y_up_shapes_are_rotated_as_in_partnet_mobility() -> None:
    assert np.array_equal(z_up_rotation(np.array([0.0, 1, 0])), Y_UP_TO_Z_UP)


AXES = [np.array(vector) for vector in AXIS_VECTORS.values()]


@pytest.mark.parametrize(("up", "front"), [(up, front) for up in AXES for front in AXES if up @ front == 0.0])
def test_up_and_front_become_y_and_z(up: np.ndarray, front: np.ndarray) -> None:
    rotation = y_up_rotation(up, front)
    assert np.array_equal(rotation @ up, (0, 1, 0))
    assert np.array_equal(rotation @ front, (0, 0, 1))
    assert np.linalg.det(rotation) == pytest.approx(1)


@pytest.mark.parametrize(("up", "front"), USUAL_FRONT.items())
def test_the_usual_front_is_used_if_none_is_known(up: Axis, front: Axis) -> None:
    rotation = y_up_rotation(np.array(AXIS_VECTORS[up]))
    assert np.array_equal(rotation, y_up_rotation(np.array(AXIS_VECTORS[up]), np.array(AXIS_VECTORS[front])))


@given(rotations)
def test_a_front_along_the_up_direction_counts_as_unknown(rotation: np.ndarray) -> None:
    up = rotation[:, 1]
    assert np.array_equal(y_up_rotation(up, up), y_up_rotation(up))
    assert y_up_rotation(up) @ up == pytest.approx([0, 1, 0], abs=1e-9)


@given(rotations)
def test_roll_pitch_and_yaw_give_back_the_rotation(rotation: np.ndarray) -> None:
    roll, pitch, yaw = roll_pitch_yaw(rotation)
    about = Rotation.from_rotvec
    found = about([0, 0, yaw]) * about([0, pitch, 0]) * about([roll, 0, 0])
    assert found.as_matrix() == pytest.approx(rotation, abs=1e-6)
