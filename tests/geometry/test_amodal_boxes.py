"""Boxes of parts, their sides moved to where scans show them; `rust/geometry/src/seen_box.rs` tests one box at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from kinmo import _core

F64 = NDArray[np.float64]
MIDDLE, HALF = np.array([0.0, 0.0, 3.0]), np.array([0.3, 0.2, 0.25])
SIDES = 30
"""Points along an edge."""


def scan(turn: float = 0.6) -> tuple[F64, F64]:
    """A box as a camera at the origin sees it from a corner: points and axes (rows)."""
    x, y = np.array([np.cos(turn), 0.0, -np.sin(turn)]), np.array([0.0, 1.0, 0.0])
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(turn), -np.sin(turn)], [0.0, np.sin(turn), np.cos(turn)]])
    axes = np.stack([x, y, np.cross(x, y)]) @ tilt.T
    toward = np.sign(-axes @ MIDDLE)
    along = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, SIDES)] * 2), axis=-1).reshape(-1, 2)
    points = []
    for axis in range(3):
        places = np.insert(along, axis, toward[axis], axis=1)
        points.append(MIDDLE + (places * HALF) @ axes)
    return np.concatenate(points), axes


def arguments(points: F64, axes: F64, half: F64, copies: int = 1) -> dict[str, Any]:
    return {
        "points": np.tile(points, (copies, 1)),
        "offsets": np.arange(copies + 1) * len(points),
        "owners": np.zeros(copies * len(points), np.int64),
        "cameras": np.zeros((copies, 3)),
        "centers": np.tile(MIDDLE, (copies, 1)),
        "axes": np.tile(axes, (copies, 1, 1)),
        "half": np.tile(half, (copies, 1)),
        "frames": np.arange(copies + 1),
    }


@pytest.mark.parametrize("factor", [0.7, 1.0, 2.5])
def test_a_box_that_is_seen_from_a_corner_is_the_one_that_it_is_but_for_its_far_side(factor: float) -> None:
    points, axes = scan(turn=0.2)
    far, too_far = -np.sign(-axes[2] @ MIDDLE), max(factor - 1.0, 0.0) * HALF[2]
    for copies in (1, 3):
        centers, same, half = _core.adjust_amodal_boxes(**arguments(points, axes, factor * HALF, copies))
        np.testing.assert_allclose(centers, np.tile(MIDDLE + 0.5 * far * too_far * axes[2], (copies, 1)), atol=1e-9)
        np.testing.assert_allclose(half, np.tile(HALF + [0.0, 0.0, 0.5 * too_far], (copies, 1)), atol=1e-9)
        np.testing.assert_allclose(same, np.tile(axes, (copies, 1, 1)))


def test_points_that_are_of_no_box_move_none() -> None:
    points, axes = scan()
    told = arguments(points, axes, 2.0 * HALF)
    told["owners"][:] = -1
    centers, _, half = _core.adjust_amodal_boxes(**told)
    np.testing.assert_array_equal(centers, [MIDDLE])
    np.testing.assert_array_equal(half, [2.0 * HALF])


def test_without_scans_there_are_no_boxes() -> None:
    none = np.zeros((0, 3))
    start = np.zeros(1, np.int64)
    found = _core.adjust_amodal_boxes(none, start, np.zeros(0, np.int64), none, none, np.zeros((0, 3, 3)), none, frames=start)
    assert [values.shape for values in found] == [(0, 3), (0, 3, 3), (0, 3)]


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("owners", np.full(3 * SIDES**2, 1), r"owners: row 0 is no box of its scan, which has 1"),
        ("owners", np.zeros(2, np.int64), r"owners: shape \[2\], expected \[2700\]"),
        ("offsets", np.array([0, 7, 2700]), r"offsets: 2 scans, but frames has 1"),
        ("frames", np.array([0, 2]), r"frames: expected numbers that rise from 0 to 1"),
        ("cameras", np.zeros((2, 3)), r"cameras: shape \[2, 3\], expected \[1, 3\]"),
        ("axes", 2.0 * np.eye(3)[None], r"axes: row 0 is not orthonormal"),
        ("points", np.full((2700, 3), np.nan), r"points: not finite"),
    ],
)
def test_what_does_not_go_together_is_refused_by_name(name: str, value: NDArray[Any], problem: str) -> None:
    points, axes = scan()
    with pytest.raises(ValueError, match=problem):
        _core.adjust_amodal_boxes(**arguments(points, axes, HALF) | {name: value})
