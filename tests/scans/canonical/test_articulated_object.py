"""Parts of articulated objects: which bodies are parts, and their canonical order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scanned_objects import cupboard, cupboard_object, hinge, slider
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, Shape
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.canonical.part_order import HEIGHT_WEIGHT, spatial_order


def rack(columns: int, rows: int) -> Shape:
    """A board with drawers in columns and rows, shuffled."""
    boxes = [((0.0, 0.0, 0.0), (columns, rows, 0.2))]
    boxes += [((x + 0.1, y + 0.1, 0.2), (x + 0.9, y + 0.9, 1.0)) for x in range(columns) for y in range(rows)]
    leaves = np.random.default_rng(0).permutation(np.arange(2, len(boxes) + 1))
    bodies = [Body(0, "board", (1,)), *(Body(i, "drawer", (int(leaf),), 0, slider()) for i, leaf in enumerate(leaves, 1))]
    return shape_of_boxes(boxes, bodies)


def test_a_small_part_is_fixed_to_its_parent() -> None:
    target = cupboard_object()
    assert [body.name for body in target.mobility.bodies] == ["base", "drawer", "lid", "door"]
    assert target.structure.kinds == (JointKind.PRISMATIC, JointKind.SCREW, JointKind.REVOLUTE)
    assert target.structure.parents == (0, 0, 0)
    assert len(target.meshes[3].vertices) == 16, "door and knob are one mesh"
    assert len(articulated_object(cupboard(), min_part_size=0.0).meshes) == 5


def test_the_axis_aligned_share_of_boxes_a_turned_box_and_a_tube() -> None:
    np.testing.assert_allclose(cupboard_object().axis_aligned_shares, 1.0)
    shape = shape_of_boxes(
        [((-1.0, -1.0, -1.0), (1.0, 0.0, 1.0)), ((-1.0, 0.0, -1.0), (1.0, 1.0, 1.0))],
        [Body(0, "base", (1,)), Body(1, "turned", (2,), 0, hinge((0.0, 0.0, 0.0)))],
    )
    turned, parts = Rotation.from_euler("y", 40.0, degrees=True), list(shape.parts)
    mesh = parts[2].mesh
    assert mesh is not None
    parts[2] = replace(parts[2], mesh=Mesh(turned.apply(mesh.vertices), mesh.faces))
    found = articulated_object(replace(shape, parts=tuple(parts))).axis_aligned_shares
    np.testing.assert_allclose(found, [1.0, 2 * 4 / (2 * 4 + 4 * 2)])
    angles = np.linspace(0.0, 2 * np.pi, 64, endpoint=False) + np.radians(2.0)
    ring = np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=1)
    low, high = np.arange(64), np.roll(np.arange(64), -1)
    tube = Mesh(
        np.concatenate([ring, ring + [0.0, 2.0, 0.0]]),
        np.concatenate([np.stack([low, high, low + 64], 1), np.stack([high, high + 64, low + 64], 1)]).astype(np.uint32),
    )
    parts[2] = replace(parts[2], mesh=tube)
    assert articulated_object(replace(shape, parts=tuple(parts))).axis_aligned_shares[1] < 0.2


def test_the_object_is_centered_and_has_the_diagonal_one() -> None:
    target = cupboard_object()
    corners = np.concatenate([mesh.vertices for mesh in target.meshes])
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert np.linalg.norm(high - low) == pytest.approx(1.0)
    assert low + high == pytest.approx(np.zeros(3), abs=1e-12)
    assert target.joints[0].upper == pytest.approx(0.6 / np.linalg.norm([2.0, 2.4, 2.0]), rel=0.03)


@pytest.mark.parametrize(("columns", "rows"), [(1, 3), (3, 1), (2, 2), (3, 2), (2, 3)])
def test_equal_parts_are_ordered_by_rows_from_the_top_left(columns: int, rows: int) -> None:
    centers = articulated_object(rack(columns, rows)).part_extents.centers[1:]
    right, up = (np.unique(np.round(centers[:, axis], 3), return_inverse=True)[1] for axis in (0, 1))
    is_by_column = HEIGHT_WEIGHT * (rows - 1) < columns - 1
    expected = sorted(zip(right, -up, strict=True), key=None if is_by_column else lambda place: place[::-1])
    assert list(zip(right, -up, strict=True)) == expected


@pytest.mark.parametrize(
    "places",
    [
        [(0.0, 0.2, 0.3), (0.0, -0.2, 0.3), (0.0, 0.0, -0.3)],
        [(0.0, y, z) for z in (0.2, 0.0, -0.2) for y in (0.2, 0.0, -0.2)],
        [(0.0, y, z) for y in (0.4, 0.0, -0.4) for z in (0.1, -0.1)],
        [(0.0, y, z) for y in (0.1, -0.1) for z in np.linspace(0.1, -0.1, 11)],
        [(x, y, 0.0) for y in (0.2, -0.2) for x in (-0.1, 0.1)],
    ],
    ids=["two doors above one", "three by three", "wide", "thin ones in two columns", "lying"],
)
@given(data=st.data())
def test_the_spatial_order_ignores_the_order_of_the_file_and_small_offsets(
    places: list[tuple[float, float, float]], data: st.DataObject
) -> None:
    order = data.draw(st.permutations(range(len(places))))
    noise = data.draw(arrays(np.float64, (len(places), 3), elements=st.floats(-0.004, 0.004)))
    found = spatial_order((np.array(places) + noise)[order])
    assert [order[row] for row in found] == list(range(len(places)))


def test_the_order_of_parts_ignores_the_order_of_the_file() -> None:
    shape = cupboard()
    assert shape.mobility is not None
    expected = articulated_object(shape)
    order = [4, 2, 0, 3, 1]
    place = {old: new for new, old in enumerate(order)}
    bodies = [shape.mobility.bodies[old] for old in order]
    bodies = [replace(body, parent=None if body.parent is None else place[body.parent]) for body in bodies]
    found = articulated_object(replace(shape, mobility=Mobility(tuple(bodies))))
    assert found.structure == expected.structure
    np.testing.assert_array_equal(found.part_extents.centers, expected.part_extents.centers)


def test_a_part_on_a_moving_part_follows_it() -> None:
    boxes = [((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((0.0, 0.0, 1.0), (1.0, 1.0, 1.1)), ((0.2, 0.2, 1.1), (0.8, 0.8, 1.2))]
    bodies = [
        Body(0, "flap", (3,), 1, hinge((0.2, 0.2, 1.1))),
        Body(1, "door", (2,), 2, hinge((0.0, 0.0, 1.0))),
        Body(2, "frame", (1,)),
    ]
    target = articulated_object(shape_of_boxes(boxes, bodies))
    assert target.structure.parents == (0, 1)
    assert str(target.structure) == "3 parts (R on 0, R on 1)"
    assert target.structure.in_words == "3 parts (revolute on part 0, revolute on part 1)"


def test_junk_is_left_out() -> None:
    cupboard_, far = cupboard(), ((40.0, 0.0, 0.0), (41.0, 1.0, 1.0))
    clean = articulated_object(cupboard_)
    assert cupboard_.mobility is not None
    low_high = [(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for mesh in cupboard_.meshes()]
    bodies = [*cupboard_.mobility.bodies, Body(5, "junk", (6,))]
    target = articulated_object(shape_of_boxes([*low_high, far], bodies, junk=frozenset({6})))
    assert target.structure == clean.structure
    np.testing.assert_allclose(target.part_extents.sizes, clean.part_extents.sizes)
    np.testing.assert_allclose(target.part_extents.centers, clean.part_extents.centers)
    everything = shape_of_boxes([far], [Body(0, "junk", (1,))], junk=frozenset({1}))
    with pytest.raises(InputError, match="all of it is marked as junk"):
        articulated_object(everything)


@pytest.mark.parametrize(
    ("bodies", "message"),
    [
        ([Body(0, "all", (1, 2))], "no part of it moves"),
        ([Body(0, "all", (1, 2), None, hinge((0.0, 0.0, 0.0)))], "nothing stands still"),
    ],
)
def test_an_object_without_a_moving_part_or_a_base_is_an_error(bodies, message) -> None:
    boxes = [((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((1.0, 0.0, 0.0), (2.0, 1.0, 1.0))]
    with pytest.raises(InputError, match=message):
        articulated_object(shape_of_boxes(boxes, bodies))
    with pytest.raises(InputError, match="no joints are known"):
        articulated_object(replace(shape_of_boxes(boxes, bodies), mobility=None))
