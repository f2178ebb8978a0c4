"""Relations of two oriented boxes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinmo.features.prepared_shape import Boxes
from kinmo.learning.motion_gnn.box_relations import (
    SIDES,
    STATES,
    box_sides,
    box_states,
    canonical_boxes,
    object_axes,
)

UP = np.array([0.0, 1.0, 0.0])
PAIR = np.array([[0, 1], [1, 0]])


def boxes_of(*specs: tuple[tuple[float, ...], tuple[float, ...]]) -> Boxes:
    centers, halves = (np.array([spec[i] for spec in specs]) for i in range(2))
    return Boxes(centers, np.tile(np.eye(3), (len(specs), 1, 1)), halves)


@pytest.mark.parametrize(
    ("center", "half", "expected"),
    [
        ((0, 0, 0), (0.5, 0.5, 0.5), ("inside", "around")),
        ((0, 3, 0), (1, 1, 1), ("apart", "apart")),
        ((0, 1, 0), (1, 1, 1), ("crossing", "crossing")),
        ((0, 0, 0), (1, 1, 1), ("inside", "inside")),
        ((0, 0, 0), (0.5, 0.0, 0.5), ("inside", "around")),
    ],
)
def test_states_depend_on_the_share_of_a_box_inside_the_other(center, half, expected) -> None:
    boxes = boxes_of((center, half), ((0, 0, 0), (1, 1, 1)))
    found = box_states(boxes, PAIR)
    if half == (0.5, 0.5, 0.5) or half[1] == 0.0:
        assert STATES[found[0]] == expected[0]
    else:
        assert tuple(STATES[i] for i in found) == expected


@pytest.mark.parametrize("side", range(6))
def test_sides_are_faces_of_the_reference_box(side: int) -> None:
    offset = np.zeros(3)
    offset[side // 2] = 2.0 if side % 2 == 0 else -2.0
    boxes = boxes_of((tuple(offset), (0.1, 0.1, 0.1)), ((0, 0, 0), (1, 1, 1)))
    assert box_sides(canonical_boxes(boxes, UP), PAIR)[0] == side
    assert SIDES[box_sides(canonical_boxes(boxes, UP), PAIR)[1]] == SIDES[side ^ 1]


@pytest.mark.parametrize("seed", range(5))
def test_features_do_not_depend_on_the_order_and_sign_of_box_axes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    axes = Rotation.random(6, rng).as_matrix()
    boxes = Boxes(rng.normal(size=(6, 3)), axes, rng.uniform(0.1, 1, (6, 3)))
    order = np.array([rng.permutation(3) for _ in range(6)])
    rows = np.arange(6)[:, None]
    signs = rng.choice([-1.0, 1.0], (6, 3, 1))
    same = Boxes(boxes.centers, boxes.axes[rows, order] * signs, boxes.half_extents[rows, order])
    edges = np.array([[i, j] for i in range(6) for j in range(6) if i != j])
    one, other = canonical_boxes(boxes, UP), canonical_boxes(same, UP)
    np.testing.assert_allclose(one.axes, other.axes, atol=1e-12)
    np.testing.assert_array_equal(box_sides(one, edges), box_sides(other, edges))
    np.testing.assert_array_equal(box_states(one, edges), box_states(other, edges))


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 0.6, 0.8)])
def test_the_objects_frame_is_right_handed_with_up_in_the_middle(up) -> None:
    frame = object_axes(np.array(up, float))
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    np.testing.assert_allclose(frame[1], up)
