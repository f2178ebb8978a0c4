"""Arrays of any memory layout are read as what they hold, and what is no such array is refused by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from calls import ARGUMENTS, CALLS
from numpy.typing import NDArray
from solids import BOX, meshes

from kinmo import _core

Array = NDArray[Any]


def _reversed(array: Array) -> Array:
    return array[tuple([slice(None, None, -1)] * array.ndim)].copy()[tuple([slice(None, None, -1)] * array.ndim)]


def _every_second(array: Array) -> Array:
    wide = np.repeat(array, 2, axis=-1)
    wide[..., 1::2] = 0
    return wide[..., ::2]


def _field_of_records(array: Array, *, before: int) -> Array:
    """A field after `before` bytes of packed records: strides, and with `before` the first byte, fit no whole value."""
    fields = [("pad", "u1", before)] if before else []
    records = np.zeros(len(array), np.dtype([*fields, ("value", array.dtype, array.shape[1:]), ("end", "u1", 3)]))
    records["value"] = array
    return records["value"]


def _read_only(array: Array) -> Array:
    array = array.copy()
    array.flags.writeable = False
    return array


LAYOUTS: dict[str, Callable[[Array], Array]] = {
    "Fortran order": np.asfortranarray,
    "negative strides": _reversed,
    "every second value": _every_second,
    "aligned field of records": lambda array: _field_of_records(array, before=0),
    "unaligned field of records": lambda array: _field_of_records(array, before=1),
    "read-only": _read_only,
}


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
@pytest.mark.parametrize(("name", "argument"), ARGUMENTS)
def test_the_memory_layout_changes_nothing(name: str, argument: str, layout: Callable[[Array], Array]) -> None:
    call = CALLS[name]
    laid_out = layout(call.arrays[argument])
    np.testing.assert_array_equal(laid_out, call.arrays[argument])
    for expected, found in zip(call.outcome(), call.outcome(**{argument: laid_out}), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(("name", "argument"), ARGUMENTS)
def test_another_type_of_value_is_refused(name: str, argument: str) -> None:
    array = CALLS[name].arrays[argument]
    for wrong in (
        array.astype(np.float16),
        array.astype(np.int64),
        array.astype(array.dtype.newbyteorder("S")),
        array.tolist(),
    ):
        if getattr(wrong, "dtype", None) == array.dtype:
            continue  # single bytes have no order
        with pytest.raises(TypeError, match=r"^expected an array of ((u?int|float)\d+|bool), not "):
            CALLS[name].outcome(**{argument: wrong})


@pytest.mark.parametrize(("name", "argument"), ARGUMENTS)
def test_another_shape_is_refused_by_name(name: str, argument: str) -> None:
    array = CALLS[name].arrays[argument]
    for wrong in (array[None], array.reshape(1, 1, *array.shape), array[(None,) * 40], np.array(array.flat[0])):
        with pytest.raises(ValueError, match=rf"^{argument}\b.*: shape "):
            CALLS[name].outcome(**{argument: wrong})


@pytest.mark.parametrize(("name", "argument"), [pair for pair in ARGUMENTS if CALLS[pair[0]].arrays[pair[1]].dtype.kind == "f"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e61])
def test_what_is_not_finite_or_overflows_is_refused_by_name(name: str, argument: str, value: float) -> None:
    array = CALLS[name].arrays[argument].copy()
    with np.errstate(over="ignore"):
        array.reshape(-1)[-1] = value
    with pytest.raises(ValueError, match=rf"^{argument}\b.*(not finite|beyond|expected radians that rise)"):
        CALLS[name].outcome(**{argument: array})


def test_an_array_to_write_to_must_be_writable() -> None:
    call = CALLS["move_points"]
    expected = call.outcome()[0]
    with pytest.raises(ValueError, match=r"^out: not writable"):
        call.outcome(out=_read_only(np.zeros_like(expected)))


def test_points_that_leave_single_precision_are_refused() -> None:
    call = CALLS["move_points"]
    with pytest.raises(ValueError, match=r"^points: beyond"):
        call.outcome(points=np.full((1, 3), 3e38, np.float32))
    with pytest.raises(ValueError, match=r"^pivots: row 0"):
        call.outcome(pivots=np.full((3, 3), 1e39))


HUGE = 10**30


@pytest.mark.parametrize("count", [0, -1, 10**9, HUGE, -HUGE])
def test_counts_out_of_range_are_refused_by_name(count: int) -> None:
    parts = meshes(BOX, (BOX[0] + 4.0, BOX[1]))
    joint = np.zeros(1, np.uint8), np.eye(3)[:1], np.zeros((1, 3)), np.zeros(1), np.ones(1)
    with pytest.raises(ValueError, match=r"^count: .*expected an integer from 1 to"):
        _core.sample_surface(parts, count)
    for find in (_core.fit_symmetric_boxes, _core.find_symmetries, _core.find_round_pieces):
        with pytest.raises(ValueError, match=r"^samples: .*expected an integer from 1 to"):
            find(parts, samples=count)
    for name in ("probes", "steps"):
        with pytest.raises(ValueError, match=rf"^{name}: .*expected an integer from 1 to"):
            _core.sweep(parts, [0], [1], *joint, **{name: count})  # type: ignore[arg-type]


@pytest.mark.parametrize("axes", [32, 33, 64])
def test_arrays_of_more_axes_than_any_argument_has_are_refused_by_name(axes: int) -> None:
    shape = ", ".join(["1"] * axes)
    with pytest.raises(ValueError, match=rf"^points: shape \[{shape}\], expected \[F, N, 3\]$"):
        _core.manhattan_frames(np.zeros((1,) * axes, np.float32), np.ones((1, 1), bool))
    with pytest.raises(ValueError, match=rf"^out: shape \[{shape}\], expected "):
        CALLS["move_points"].outcome(out=np.zeros((1,) * axes, np.float32))


@pytest.mark.parametrize("index", [-1, 2, 2**63, HUGE, -HUGE])
def test_indices_out_of_range_are_refused_by_name(index: int) -> None:
    parts = meshes(BOX, (BOX[0] + 4.0, BOX[1]))
    joint = np.zeros(1, np.uint8), np.eye(3)[:1], np.zeros((1, 3)), np.zeros(1), np.ones(1)
    pairs = np.zeros((0, 2), np.uint32)
    for group in (
        lambda groups: _core.fit_boxes(parts, groups),
        lambda groups: _core.fit_aligned_boxes(parts, np.eye(3), groups),
        lambda groups: _core.fit_symmetric_boxes(parts, groups),
        lambda groups: _core.find_symmetries(parts, groups),
        lambda groups: _core.part_distances(parts, groups),
        lambda groups: _core.interaction_regions(np.zeros((2, 5, 3)), pairs, groups),
    ):
        with pytest.raises(ValueError, match=r"^groups\[1\]: index .* is outside 0\.\.2$"):
            group([[0], [1, index]])
    with pytest.raises(ValueError, match=r"^group: index .* is outside 0\.\.2$"):
        _core.closest_points(parts, [0, index], np.zeros((1, 3)))
    with pytest.raises(ValueError, match=r"^moving: index .* is outside 0\.\.2$"):
        _core.sweep(parts, [index], [1], *joint)
    with pytest.raises(ValueError, match=r"^obstacles: index .* is outside 0\.\.2$"):
        _core.sweep(parts, [0], [index], *joint)


def test_numbers_beyond_all_floats_are_infinite() -> None:
    parts = meshes(BOX, (BOX[0] + 4.0, BOX[1]))
    joint = np.zeros(1, np.uint8), np.eye(3)[:1], np.zeros((1, 3)), np.zeros(1), np.ones(1)
    assert len(_core.part_distances(parts, max_distance=10**400)[0]) == 1
    with pytest.raises(ValueError, match=r"^max_distance: -inf"):
        _core.part_distances(parts, max_distance=-(10**400))
    for find in (_core.fit_symmetric_boxes, _core.find_symmetries, _core.find_round_pieces):
        with pytest.raises(ValueError, match=r"^tolerance: inf"):
            find(parts, tolerance=10**400)
    for name in ("tolerance", "ignored_share"):
        with pytest.raises(ValueError, match=rf"^{name}: inf"):
            _core.sweep(parts, [0], [1], *joint, **{name: 10**400})  # type: ignore[arg-type]
    points = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(1, np.int64)
    with pytest.raises(ValueError, match=r"^threshold: inf"):
        _core.find_similarities(*points, hypotheses=1, threshold=10**400, seed=0)
    transforms = np.tile(np.eye(4), (1, 2, 1, 1))
    with pytest.raises(ValueError, match=r"^near: .* with far inf"):
        _core.render(parts, transforms, (4, 4), np.ones(2), np.ones(2), near=0.1, far=10**400)


def test_many_meshes_get_fewer_points_each_at_the_most() -> None:
    parts = meshes(*[BOX] * 200)
    with pytest.raises(ValueError, match=r"^count: 1000000, expected an integer from 1 to 500000$"):
        _core.sample_surface(parts, 1_000_000)


@pytest.mark.parametrize("seed", [-1, HUGE, -HUGE])
def test_seeds_out_of_range_are_refused_by_name(seed: int) -> None:
    for draw in (
        lambda: _core.sample_surface(meshes(BOX), 5, seed),
        lambda: _core.find_symmetries(meshes(BOX), seed=seed),
        lambda: _core.find_round_pieces(meshes(BOX), seed=seed),
    ):
        with pytest.raises(ValueError, match=r"^seed: "):
            draw()


def test_a_result_without_room_is_a_memory_error() -> None:
    point = np.broadcast_to(np.zeros((1, 3), np.float32), (10**6, 3))
    many = 1000
    joints = np.zeros(many, np.uint8), np.eye(3)[np.zeros(many, int)], np.zeros((many, 3))
    with pytest.raises(MemoryError, match="Unable to allocate"):
        _core.move_points(point, *joints, np.zeros((many, many)), np.zeros((many, many)))
    with pytest.raises(MemoryError, match="Unable to allocate"):
        _core.nearest_neighbours(np.zeros((1, 10**7, 3), np.float32), 10**7)
    with pytest.raises(MemoryError, match="Unable to allocate"):
        _core.neighbour_argmax(np.zeros((1, 1, 10**7), np.float32), np.zeros((1, 10**7, 1), np.int64))


def test_no_parts_give_results_without_rows() -> None:
    nothing = _core.Meshes([], [])
    assert nothing.areas().shape == (0,)
    assert [a.shape for a in _core.sample_surface(nothing, 5)] == [(0, 5, 3), (0, 5, 3), (0, 5)]
    for parts, groups in ((nothing, None), (meshes(BOX), [])):
        assert [a.shape for a in _core.fit_boxes(parts, groups)] == [(0, 3), (0, 3, 3), (0, 3)]
        assert _core.fit_symmetric_boxes(parts, groups)[3].shape == (0,)
        assert [len(a) for a in _core.find_symmetries(parts, groups)] == [0] * 6
        assert [len(a) for a in _core.part_distances(parts, groups)] == [0] * 4
    assert [len(a) for a in _core.find_round_pieces(nothing)] == [0] * 5
    regions = _core.interaction_regions(np.zeros((0, 5, 3)), np.zeros((0, 2), np.uint32))
    assert (regions.centroids.shape, regions.offsets.tolist(), regions.samples.shape) == ((0, 3), [0], (0, 2))
    none = np.zeros(0, np.uint8), np.zeros((0, 3)), np.zeros((0, 3))
    assert _core.move_points(np.zeros((4, 3), np.float32), *none, np.zeros((0, 2)), np.zeros((0, 2))).shape == (0, 2, 4, 3)
    travels = _core.sweep(meshes(BOX, BOX), [0], [1], *none, np.zeros(0), np.zeros(0))
    assert [a.shape for a in travels] == [(0,), (0,), (0, 2)]
    assert _core.box_iou(*[np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 3))] * 2).shape == (0,)
    assert [a.shape for a in _core.closest_points(meshes(BOX), [0], np.zeros((0, 3)))] == [(0,), (0, 3), (0, 3)]


def test_truth_values_of_any_byte_but_0_are_true() -> None:
    call = CALLS["refine_poses"]
    odd = (call.arrays["axis_aligned"].astype(np.uint8) * 6).view(bool)
    for expected, found in zip(call.outcome(), call.outcome(axis_aligned=odd), strict=True):
        np.testing.assert_array_equal(found, expected)
