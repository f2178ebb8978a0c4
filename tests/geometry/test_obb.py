"""`fit_boxes` and its kin: around everything, no larger than need be, moving with the part."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from solids import (
    BOX,
    CYLINDER,
    DEGENERATE,
    F64,
    LINE,
    POINT,
    RECTANGLE,
    TETRAHEDRON,
    TRIANGLE,
    MeshArrays,
    arrays,
    clouds,
    meshes,
    moved,
    rotation,
    seeds,
)

from kinmo import _core

Boxes = tuple[F64, F64, F64]


def check_boxes(boxes: Boxes, parts: list[F64]) -> None:
    """Finite, right-handed, around the vertices of the parts, and touched by them on every side."""
    for center, axes, half_extents, vertices in zip(*boxes, parts, strict=True):
        assert np.isfinite(center).all()
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(axes) > 0
        # Rounding of the vertices' own coordinates, and of the axes over the size of the part.
        margin = 1e-15 * np.abs(vertices).max() + 1e-12 * np.ptp(vertices, axis=0).max()
        along = (vertices - center) @ axes.T
        assert (np.abs(along) <= half_extents + 8 * margin).all()
        np.testing.assert_allclose(along.max(axis=0), half_extents, atol=8 * margin, rtol=0)
        np.testing.assert_allclose(along.min(axis=0), -half_extents, atol=8 * margin, rtol=0)


def ordered(boxes: Boxes) -> bool:
    return bool((np.diff(boxes[2], axis=1) <= 0).all())


@given(part=clouds(), seed=seeds, exponent=st.integers(-8, 8), far=st.booleans())
@settings(max_examples=100)
def test_boxes_hold_their_vertices_and_touch_them(part: MeshArrays, seed: int, exponent: int, far: bool) -> None:
    placed = moved(part, rotation(seed), 1e6 if far else 0.0, 10.0**exponent)
    mesh = meshes(placed)
    boxes = _core.fit_boxes(mesh)
    check_boxes(boxes, [placed[0]])
    assert ordered(boxes)
    check_boxes(_core.fit_symmetric_boxes(mesh)[:3], [placed[0]])
    check_boxes(_core.fit_aligned_boxes(mesh, np.eye(3)), [placed[0]])


@given(part=clouds(), seed=seeds, scale=st.sampled_from([1e-8, 1.0, 1e8]))
@settings(max_examples=60)
def test_volume_moves_with_the_part(part: MeshArrays, seed: int, scale: float) -> None:
    volume = np.prod(2 * _core.fit_boxes(meshes(part))[2])
    turned = np.prod(2 * _core.fit_boxes(meshes(moved(part, rotation(seed), scale * 3.0, scale)))[2])
    diagonal = np.linalg.norm(np.ptp(part[0], axis=0))
    np.testing.assert_allclose(turned / scale**3, volume, rtol=2e-3, atol=1e-9 * diagonal**3)


@given(seed=seeds, count=st.integers(4, 60), flat=st.floats(0.01, 1.0))
@settings(max_examples=60)
def test_volumes_are_no_larger_than_those_of_trimesh(seed: int, count: int, flat: float) -> None:
    rng = np.random.default_rng(seed)
    hull = trimesh.convex.convex_hull(rng.normal(size=(count, 3)) * [1.0, 1.0, flat])
    theirs = np.prod(trimesh.bounds.oriented_bounds(hull)[1])
    assert np.prod(2 * _core.fit_boxes(meshes(arrays(hull)))[2]) <= 1.0001 * theirs


@given(seed=seeds, sides=st.tuples(*[st.floats(0.01, 1.0)] * 3))
@settings(max_examples=60)
def test_a_turned_box_is_found_again(seed: int, sides: tuple[float, float, float]) -> None:
    part = moved(arrays(trimesh.creation.box(sides)), rotation(seed), np.array([1.0, 2.0, 3.0]))
    center, _, half_extents = _core.fit_boxes(meshes(part))
    np.testing.assert_allclose(center[0], [1.0, 2.0, 3.0], atol=1e-9)
    np.testing.assert_allclose(2 * half_extents[0], sorted(sides, reverse=True), rtol=1e-6)


def test_boxes_that_touch_edges_alone_are_found() -> None:
    # The best box of a regular tetrahedron is the cube whose faces hold its edges; boxes on its faces are twice as large.
    for seed in range(5):
        half_extents = _core.fit_boxes(meshes(moved(TETRAHEDRON, rotation(seed))))[2]
        np.testing.assert_allclose(half_extents, [[1.0, 1.0, 1.0]], rtol=1e-9)


def test_of_equal_boxes_the_one_along_the_frame_is_taken() -> None:
    # Turned by half a side, so that two pairs of the cylinder's 32 sides face along the frame.
    half_side = trimesh.transformations.rotation_matrix(np.pi / 32, [0, 0, 1])
    cylinder = trimesh.creation.cylinder(1.0, 3.0, sections=32).apply_transform(half_side)
    for solid in (cylinder, trimesh.creation.box((2.0, 2.0, 1.0))):
        axes = _core.fit_boxes(meshes(arrays(solid)))[1][0]
        np.testing.assert_allclose(np.abs(axes).max(axis=1), 1.0, atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_flat_and_line_like_parts_are_measured_where_they_extend(seed: int) -> None:
    turn, shift = rotation(seed), np.array([5.0, -3.0, 2.0])
    boxes = _core.fit_boxes(meshes(*(moved(part, turn, shift) for part in (RECTANGLE, TRIANGLE, LINE, POINT))))
    diagonal = np.sqrt(54.0)
    expected = [[2.0, 1.0, 0.0], [2.0, 1.0, 0.0], [diagonal, 0.0, 0.0], [0.0, 0.0, 0.0]]
    areas = 2 * boxes[2]
    np.testing.assert_allclose(areas[[0, 2, 3]], np.array(expected)[[0, 2, 3]], atol=1e-12)
    # A right triangle fits a rectangle on its legs and one on its longest side, of equal area.
    np.testing.assert_allclose(areas[1, 0] * areas[1, 1], 2.0, rtol=1e-9)
    np.testing.assert_allclose(np.abs(boxes[1][0, 2] @ turn), [0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(np.abs(boxes[1][2, 0] @ turn), np.array([1, 1, 2]) / np.sqrt(6), atol=1e-9)


@pytest.mark.parametrize("part", DEGENERATE.values(), ids=DEGENERATE)
@pytest.mark.parametrize(("shift", "scale"), [(0.0, 1.0), (1e6, 1.0), (0.0, 1e8), (0.0, 1e-8), (0.0, 1e-150), (0.0, 1e50)])
def test_degenerate_far_huge_and_tiny_parts_have_boxes(part: MeshArrays, shift: float, scale: float) -> None:
    placed = moved(part, rotation(3), shift, scale)
    boxes = _core.fit_boxes(meshes(placed))
    check_boxes(boxes, [placed[0]])
    assert part is POINT or boxes[2][0, 0] >= 0.4 * np.ptp(placed[0], axis=0).max()


def test_a_group_has_the_box_of_its_union() -> None:
    parts = [moved(BOX, rotation(1)), moved(CYLINDER, rotation(2), 2.0), RECTANGLE]
    union = (np.concatenate([v for v, _ in parts[:2]]), np.concatenate([parts[0][1], parts[1][1] + len(parts[0][0])]))
    grouped = _core.fit_boxes(meshes(*parts), [[0, 1], [2]])
    for a, b in zip(grouped, _core.fit_boxes(meshes(union, RECTANGLE)), strict=True):
        np.testing.assert_array_equal(a, b)


def test_aligned_boxes_keep_the_frame() -> None:
    frame = rotation(9)
    boxes = _core.fit_aligned_boxes(meshes(CYLINDER), frame)
    np.testing.assert_array_equal(boxes[1][0], frame)
    np.testing.assert_allclose(2 * boxes[2][0], np.ptp(CYLINDER[0] @ frame.T, axis=0), rtol=1e-12)


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (np.ones((3, 3)), "frame: rows are not"),
        (-np.eye(3), "frame: rows are not"),
        (np.eye(2), "frame: shape"),
        (np.eye(3) * np.nan, "frame"),
    ],
)
def test_a_frame_that_is_none_is_refused(frame: F64, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        _core.fit_aligned_boxes(meshes(BOX), frame)


@pytest.mark.real
@pytest.mark.filterwarnings("ignore::RuntimeWarning:trimesh")
def test_volumes_of_real_parts_are_within_a_thousandth_of_trimesh(real_objects: list[Path]) -> None:
    checked = 0
    for folder in real_objects[::20]:
        for part in leaf_meshes(folder):
            if len(part.vertices) > 3000:
                continue
            center, axes, half_extents = _core.fit_boxes(meshes(arrays(part)))
            check_boxes((center, axes, half_extents), [part.vertices])
            try:
                theirs = np.sort(trimesh.bounds.oriented_bounds(part)[1])
            except (ValueError, IndexError):
                continue  # trimesh has no box for some flat parts
            ours = np.sort(2 * half_extents[0])
            spanned = np.maximum(ours, theirs) > 1e-9 * np.linalg.norm(theirs)
            assert np.prod(ours[spanned]) <= 1.001 * np.prod(theirs[spanned]), folder.name
            checked += 1
    assert checked > 30


def leaf_meshes(folder: Path) -> list[trimesh.Trimesh]:
    """The leaf parts of a real object."""
    pending, parts = json.loads((folder / "result.json").read_text()), []
    while pending:
        node = pending.pop()
        pending.extend(node.get("children", []))
        files = [folder / "textured_objs" / f"{name}.obj" for name in node.get("objs", [])]
        if files and not node.get("children") and all(file.is_file() for file in files):
            loaded = [trimesh.load(file, force="mesh", process=False, skip_materials=True) for file in files]
            parts.append(trimesh.util.concatenate([trimesh.Trimesh(m.vertices, m.faces, process=False) for m in loaded]))
    return parts
