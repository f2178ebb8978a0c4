"""Grouping of moving nodes into rigid bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from edge_predictions import uniform_predictions
from small_shapes import cabinet

from kinmo.core.joint import Joint, JointKind
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.kinmo.body_grouping import group_into_bodies

SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3))
LIFT = Joint(JointKind.PRISMATIC, np.array([0.0, 1.0, 0.0]), np.zeros(3))
HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.3, 0.0, 0.1]))


def bodies_of(shape: PreparedShape, moving: dict[int, Joint], predicted: str = "FIXED") -> list[tuple[int, ...]]:
    """Bodies if the GNN predicts one type for every edge."""
    return group_into_bodies(shape, moving, uniform_predictions(shape, **{predicted: 1.0}))


def with_box(shape: PreparedShape, node: int, center: list[float], half_extents: list[float]) -> PreparedShape:
    """The shape with another, axis-aligned box for one node."""
    boxes = shape.minimum_boxes
    centers, axes, sizes = boxes.centers.copy(), boxes.axes.copy(), boxes.half_extents.copy()
    centers[node], axes[node], sizes[node] = center, np.eye(3), half_extents
    return replace(shape, minimum_boxes=replace(boxes, centers=centers, axes=axes, half_extents=sizes))


def moving_pair(shape: PreparedShape) -> tuple[int, int]:
    """Two leaves below one moving node."""
    node = next(n for n, name in enumerate(shape.part_names) if name in ("door", "drawer"))
    first, second = (n for n, parent in enumerate(shape.parents) if parent == node)
    return first, second


def with_distances(shape: PreparedShape, distance: float) -> PreparedShape:
    """The shape with one distance between all siblings."""
    return replace(shape, edge_distances=np.full(len(shape.edges), distance))


def test_every_leaf_belongs_to_exactly_one_body() -> None:
    shape = cabinet(3)
    first, _ = moving_pair(shape)
    bodies = bodies_of(shape, {first: SLIDE})
    assert sorted(leaf for body in bodies for leaf in body) == list(range(len(shape.leaves)))
    assert bodies[1] == shape.leaves_below[first]


def test_touching_siblings_with_the_same_joint_form_one_body() -> None:
    shape = with_distances(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    assert len(bodies_of(shape, {first: SLIDE, second: SLIDE})) == 2


def test_siblings_with_other_joints_or_a_gap_form_two_bodies() -> None:
    shape = with_distances(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    assert len(bodies_of(shape, {first: SLIDE, second: LIFT})) == 3
    assert len(bodies_of(with_distances(shape, 0.1), {first: SLIDE, second: SLIDE})) == 3


def test_siblings_of_similar_size_form_two_bodies_like_the_keys_of_a_keypad() -> None:
    shape = with_distances(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    sizes = shape.minimum_boxes.half_extents.copy()
    sizes[first] = 1.05 * sizes[second][[2, 0, 1]]
    alike = replace(shape, minimum_boxes=replace(shape.minimum_boxes, half_extents=sizes))
    assert len(bodies_of(alike, {first: SLIDE, second: SLIDE})) == 3


def test_a_shaft_forms_one_body_with_a_part_on_its_axis_whatever_the_gnn_predicts() -> None:
    shape = with_distances(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    turning = {first: HINGE, second: HINGE}
    on_the_axis = (HINGE.pivot + [0.0, 0.4, 0.0]).tolist()
    shaft = with_box(shape, first, on_the_axis, [0.01, 0.3, 0.01])
    assert len(bodies_of(shaft, turning, "NONE")) == 2
    across_the_axis = with_box(shape, first, on_the_axis, [0.3, 0.01, 0.01])
    assert len(bodies_of(across_the_axis, turning, "NONE")) == 3
    off_the_axis = with_box(shape, first, [0.4, 0.4, 0.1], [0.01, 0.3, 0.01])
    assert len(bodies_of(off_the_axis, turning, "NONE")) == 3


def test_a_moving_node_inside_a_moving_node_forms_its_own_body() -> None:
    shape = cabinet(3)
    first, _ = moving_pair(shape)
    node = shape.parents[first]
    bodies = bodies_of(shape, {node: SLIDE, first: HINGE})
    assert len(bodies) == 3
    assert set(bodies[1]) == set(shape.leaves_below[node]) - set(shape.leaves_below[first])
