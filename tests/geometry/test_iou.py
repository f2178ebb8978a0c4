"""Intersection of oriented boxes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo import _core

Boxes = tuple[np.ndarray, np.ndarray, np.ndarray]


def upright(center: tuple[float, ...], extents: tuple[float, ...]) -> Boxes:
    return np.array([center], float), np.eye(3)[None], np.array([extents], float) / 2


def random_boxes(rng: np.random.Generator, count: int) -> Boxes:
    axes = Rotation.random(count, random_state=int(rng.integers(2**31))).as_matrix()
    axes[::2, 2] *= -1
    return rng.normal(size=(count, 3)) * 0.3, axes, rng.uniform(0.05, 1, (count, 3))


@pytest.mark.parametrize(("extents", "shift", "expected"), [((0.1, 0.7, 0.7), 0.05, 1 / 3), ((0.6, 0.5, 0.6), 0.1, 5 / 7)])
def test_shifted_boxes_overlap_as_computed_by_hand(extents: tuple[float, ...], shift: float, expected: float) -> None:
    iou = _core.box_iou(*upright((0, 0, 0), extents), *upright((shift, 0, 0), extents))
    assert iou[0] == pytest.approx(expected, abs=1e-14)


def test_volumes_agree_with_random_points() -> None:
    rng = np.random.default_rng(0)
    count, draws = 40, 40_000
    a, b = random_boxes(rng, count), random_boxes(rng, count)
    volumes = _core.box_intersection_volume(*a, *b)
    for index in range(count):
        inside_a = rng.uniform(-1, 1, (draws, 3)) * a[2][index] @ a[1][index] + a[0][index]
        local = (inside_a - b[0][index]) @ b[1][index].T
        share = (np.abs(local) <= b[2][index]).all(axis=1).mean()
        own = 8 * a[2][index].prod()
        assert volumes[index] == pytest.approx(share * own, abs=4 * own * 0.5 / draws**0.5)


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-8, 1.0, 1e8]), st.sampled_from([0.0, 1e6]))
def test_overlap_does_not_depend_on_order_pose_and_scale(seed: int, scale: float, offset: float) -> None:
    rng = np.random.default_rng(seed)
    a, b = random_boxes(rng, 5), random_boxes(rng, 5)
    expected = _core.box_iou(*a, *b)
    assert ((expected >= 0) & (expected <= 1)).all()
    np.testing.assert_allclose(_core.box_iou(*b, *a), expected, atol=1e-12)
    turn = Rotation.random(random_state=seed % 2**31).as_matrix()
    moved = [(((center @ turn.T) + offset) * scale, axes @ turn.T, half * scale) for center, axes, half in (a, b)]
    np.testing.assert_allclose(_core.box_iou(*moved[0], *moved[1]), expected, atol=1e-8 if offset else 1e-12)


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1))
def test_a_box_overlaps_itself_wholly_however_its_axes_are_named(seed: int) -> None:
    center, axes, half = random_boxes(np.random.default_rng(seed), 4)
    order = np.random.default_rng(seed).permutation(3)
    renamed = (center, -axes[:, order], half[:, order])
    np.testing.assert_allclose(_core.box_iou(center, axes, half, *renamed), 1, atol=1e-9)


def test_boxes_that_touch_or_are_flat_share_nothing() -> None:
    unit = upright((0, 0, 0), (1, 1, 1))
    assert _core.box_iou(*unit, *upright((1, 0, 0), (1, 1, 1)))[0] == pytest.approx(0, abs=1e-15)
    assert _core.box_iou(*unit, *upright((3, 3, 3), (1, 1, 1)))[0] == 0
    flat = upright((0, 0, 0), (1, 1, 0))
    assert _core.box_iou(*unit, *flat)[0] == 0
    assert _core.box_iou(*flat, *flat)[0] == 0


def test_arguments_are_refused_by_name() -> None:
    unit = upright((0, 0, 0), (1, 1, 1))
    with pytest.raises(ValueError, match=r"^axes_b: row 0 is not orthonormal"):
        _core.box_iou(*unit, unit[0], 2 * unit[1], unit[2])
    with pytest.raises(ValueError, match=r"^half_a: row 0 has a negative half extent"):
        _core.box_iou(unit[0], unit[1], -unit[2], *unit)
    with pytest.raises(ValueError, match=r"^centers_a: not finite"):
        _core.box_intersection_volume(unit[0] * np.nan, unit[1], unit[2], *unit)
    with pytest.raises(ValueError, match=r"^centers_b: 2 boxes"):
        _core.box_iou(*unit, *(np.concatenate([part, part]) for part in unit))
