"""Points moved along candidate joints."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo import _core

REVOLUTE, PRISMATIC, SCREW = 0, 1, 2


def candidates(rng: np.random.Generator, count: int, displacements: int) -> tuple[np.ndarray, ...]:
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    kinds = rng.integers(0, 3, count).astype(np.uint8)
    shape = (count, displacements)
    return kinds, directions, rng.normal(size=(count, 3)), rng.uniform(-7, 7, shape), rng.normal(size=shape)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(0, 9), st.integers(0, 4), st.integers(0, 3))
def test_points_move_as_by_scipys_rotations(seed: int, points: int, count: int, displacements: int) -> None:
    rng = np.random.default_rng(seed)
    cloud = rng.normal(size=(points, 3)).astype(np.float32)
    kinds, directions, pivots, angles, shifts = candidates(rng, count, displacements)
    moved = _core.move_points(cloud, kinds, directions, pivots, angles, shifts)
    assert moved.shape == (count, displacements, points, 3)
    assert moved.dtype == np.float32
    for c in range(count):
        for d in range(displacements):
            turn = Rotation.from_rotvec(directions[c] * angles[c, d] * (kinds[c] != PRISMATIC))
            expected = turn.apply(cloud - pivots[c]) + pivots[c] + directions[c] * shifts[c, d] * (kinds[c] != REVOLUTE)
            np.testing.assert_allclose(moved[c, d], expected, atol=5e-6)


def test_the_line_of_a_hinge_stays_where_it_is() -> None:
    direction, pivot = np.array([[0.6, 0.0, 0.8]]), np.array([[1.0, 2.0, 3.0]])
    line = (pivot + np.linspace(-2, 2, 7)[:, None] * direction).astype(np.float32)
    moved = _core.move_points(line, np.zeros(1, np.uint8), direction, pivot, np.array([[0.5, 3.0]]), np.ones((1, 2)))
    np.testing.assert_allclose(moved, np.broadcast_to(line, moved.shape), atol=1e-6)


def test_a_screw_turns_and_slides() -> None:
    pivot, shift = np.zeros((1, 3)), np.array([[0.25]])
    point = np.array([[1.0, 0.0, 0.0]], np.float32)
    moved = _core.move_points(point, np.full(1, SCREW, np.uint8), np.eye(3)[2:], pivot, np.array([[np.pi / 2]]), shift)
    np.testing.assert_allclose(moved[0, 0, 0], [0.0, 1.0, 0.25], atol=1e-6)


def test_the_result_can_be_written_to_a_given_array() -> None:
    rng = np.random.default_rng(0)
    cloud, joints = rng.normal(size=(10, 3)).astype(np.float32), candidates(rng, 3, 2)
    out = np.full((3, 2, 10, 3), np.nan, np.float32)
    assert _core.move_points(cloud, *joints, out=out) is out
    np.testing.assert_array_equal(out, _core.move_points(cloud, *joints))
    with pytest.raises(ValueError, match=r"^out: shape"):
        _core.move_points(cloud, *joints, out=out[:2])
    with pytest.raises(ValueError, match=r"^out: not contiguous"):
        _core.move_points(cloud, *joints, out=np.zeros((3, 2, 10, 6), np.float32)[..., ::2])


@pytest.mark.parametrize("shape", [(2, 3, 5, 3), (2, 1, 1, 3)])
def test_a_given_array_in_fortran_order_is_refused(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    cloud, joints = rng.normal(size=shape[2:]).astype(np.float32), candidates(rng, *shape[:2])
    out = np.zeros(shape, np.float32, order="F")
    with pytest.raises(ValueError, match=r"^out: not contiguous in the order of C$"):
        _core.move_points(cloud, *joints, out=out)
    assert not out.any()


def test_a_given_array_that_has_the_points_in_it_is_refused() -> None:
    rng = np.random.default_rng(0)
    out = np.zeros((2, 3, 5, 3), np.float32)
    with pytest.raises(ValueError, match=r"^out: overlaps an input"):
        _core.move_points(out[1, 2], *candidates(rng, 2, 3), out=out)


def test_a_given_array_that_is_not_aligned_is_refused() -> None:
    rng = np.random.default_rng(0)
    cloud, joints = rng.normal(size=(5, 3)).astype(np.float32), candidates(rng, 2, 3)
    out = np.zeros(90 * 4 + 1, np.uint8)[1:].view(np.float32).reshape(2, 3, 5, 3)
    with pytest.raises(ValueError, match=r"^out: not aligned"):
        _core.move_points(cloud, *joints, out=out)


def test_arguments_are_refused_by_name() -> None:
    rng = np.random.default_rng(0)
    cloud, joints = rng.normal(size=(4, 3)).astype(np.float32), candidates(rng, 3, 2)
    names = ("kinds", "directions", "pivots", "angles", "shifts")
    bad = {
        "kinds": np.array([0, 1, 3], np.uint8),
        "directions": joints[1] * 2,
        "pivots": np.full((3, 3), np.inf),
        "angles": np.full((3, 2), np.nan),
        "shifts": np.zeros((2, 2)),
    }
    for index, name in enumerate(names):
        changed = [bad[name] if i == index else value for i, value in enumerate(joints)]
        with pytest.raises(ValueError, match=rf"^{name}: "):
            _core.move_points(cloud, *changed)
    with pytest.raises(ValueError, match=r"^angles: shape \[3\], expected \[3, D\]"):
        _core.move_points(cloud, *joints[:3], np.zeros(3), joints[4])
    with pytest.raises(ValueError, match=r"^points: shape"):
        _core.move_points(cloud[:, :2], *joints)
    with pytest.raises(ValueError, match=r"^points: not finite"):
        _core.move_points(cloud * np.nan, *joints)
