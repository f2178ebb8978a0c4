"""Parents of bodies: contact, chains, sliders side by side."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import pytest
from articulated import shape_of_boxes
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.body_parents import REST, best_tree, find_parents

X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
HINGE, SLIDE = Joint(JointKind.REVOLUTE, Y, np.zeros(3)), Joint(JointKind.PRISMATIC, Y, np.zeros(3))
CASE = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
Boxes = Sequence[tuple[tuple[float, float, float], tuple[float, float, float]]]


def parents_in(boxes: Boxes, joints: Sequence[Joint | None], known: Sequence[int | None] | None = None) -> list[int | None]:
    """Parents of bodies that are one box each."""
    made = shape_of_boxes(boxes, [Body(index, "", (index + 1,)) for index in range(len(boxes))])
    shape = prepare_shape(made, points=64)
    geometry = ShapeGeometry.of_prepared(shape, leaf_meshes(made, shape))
    return find_parents(geometry, [(index,) for index in range(len(boxes))], joints, known)


def test_the_parent_is_the_body_with_most_contact() -> None:
    boxes = [CASE, ((0, 1, 0), (1, 1.1, 1)), ((0.4, 1.1, 0.4), (0.6, 1.2, 0.6)), ((2, 0, 0), (3, 1, 1))]
    assert parents_in(boxes, [None, HINGE, HINGE, None]) == [None, 0, 1, None]


def test_known_parents_stay() -> None:
    boxes = [CASE, ((0, 1, 0), (1, 1.1, 1)), ((0.4, 1.1, 0.4), (0.6, 1.2, 0.6))]
    assert parents_in(boxes, [None, HINGE, HINGE], [None, None, 0]) == [None, 0, 0]


def test_a_fork_is_no_child_of_its_wheel() -> None:
    fork, wheel = ((0.45, -0.3, 0.4), (0.55, 0.0, 0.6)), ((0.3, -0.45, 0.4), (0.45, -0.15, 0.6))
    axle = Joint(JointKind.REVOLUTE, X, np.array([0.4, -0.3, 0.5]))
    assert parents_in([CASE, fork, wheel], [None, HINGE, axle]) == [None, 0, 1]


def test_keys_side_by_side_do_not_carry_each_other() -> None:
    keys = [((0.1 * place, 1.0, 0.4), (0.1 * place + 0.1, 1.4, 0.5)) for place in range(5)]
    assert parents_in([CASE, *keys], [None, *[SLIDE] * 5]) == [None, *[0] * 5]


def test_a_slider_carries_the_one_behind_it() -> None:
    tubes = [((0.4, 1.0, 0.4), (0.6, 1.5, 0.6)), ((0.42, 1.5, 0.42), (0.58, 2.0, 0.58))]
    assert parents_in([CASE, *tubes], [None, SLIDE, SLIDE]) == [None, 0, 1]


@pytest.mark.parametrize("count", [1, 3])
def test_bodies_in_a_ring_get_a_root(count: int) -> None:
    boxes = [((place, 0, 0), (place + 1, 1, 1)) for place in range(count)]
    found = parents_in(boxes, [HINGE] * count)
    assert found.count(None) == 1


def is_tree(parents: Sequence[int]) -> bool:
    """True if all bodies hang on `REST`."""
    nodes = range(len(parents))
    above = list(nodes)
    for _ in nodes:
        above = [REST if node == REST else parents[node] for node in above]
    return all(node == REST for node in above)


@given(st.data(), st.integers(1, 5))
def test_no_tree_has_a_larger_sum_of_weights(data: st.DataObject, count: int) -> None:
    nodes = [REST, *range(count)]
    chosen = st.dictionaries(st.sampled_from(nodes), st.floats(-5.0, 0.0), max_size=4)
    weights = [
        {parent: weight for parent, weight in data.draw(chosen).items() if parent != child} | {REST: -1e3}
        for child in range(count)
    ]
    found = best_tree(weights)
    trees = [each for each in product(*weights) if is_tree(each)]
    assert is_tree(found)
    total = max(sum(own[parent] for own, parent in zip(weights, tree, strict=True)) for tree in trees)
    assert sum(own[parent] for own, parent in zip(weights, found, strict=True)) == pytest.approx(total)
