"""Rotations between frames."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import rotations
from hypothesis import given
from scipy.spatial.transform import Rotation

from kinmo.core.frames import TO_Y_UP, Y_UP_TO_Z_UP, Up, roll_pitch_yaw, z_up_rotation


@given(rotations)
def test_up_is_rotated_to_z(rotation: np.ndarray) -> None:
    up = rotation[:, 1]
    to_z_up = z_up_rotation(up)
    assert to_z_up @ up == pytest.approx([0, 0, 1], abs=1e-9)
    assert to_z_up @ to_z_up.T == pytest.approx(np.eye(3), abs=1e-9)
    assert np.linalg.det(to_z_up) == pytest.approx(1)


def test_y_up_shapes_are_rotated_as_in_partnet_mobility() -> None:
    assert np.array_equal(z_up_rotation(np.array([0.0, 1, 0])), Y_UP_TO_Z_UP)


@pytest.mark.parametrize(("up", "direction", "front"), [("y", (0, 1, 0), (0, 0, 1)), ("z", (0, 0, 1), (0, -1, 0))])
def test_up_and_front_of_a_file_become_y_and_z(up: Up, direction: tuple[int, ...], front: tuple[int, ...]) -> None:
    assert np.array_equal(TO_Y_UP[up] @ direction, (0, 1, 0))
    assert np.array_equal(TO_Y_UP[up] @ front, (0, 0, 1))


@given(rotations)
def test_roll_pitch_and_yaw_give_back_the_rotation(rotation: np.ndarray) -> None:
    roll, pitch, yaw = roll_pitch_yaw(rotation)
    about = Rotation.from_rotvec
    found = about([0, 0, yaw]) * about([0, pitch, 0]) * about([roll, 0, 0])
    assert found.as_matrix() == pytest.approx(rotation, abs=1e-6)
