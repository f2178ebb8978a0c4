"""Mobility trees from edge predictions: merging, references, and cycles (paper, section 3.3)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from edge_predictions import predictions_from_labels
from small_shapes import box_mesh, cabinet, prepare_boxes

from kinmo.core.mobility import has_cycle
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape import Part, Shape
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.paper.mobility_tree import tree_with_given_bodies, tree_with_predicted_bodies, with_true_types


def plain_shape(sizes: list[float], names: list[str] | None = None) -> PreparedShape:
    """A root with boxes in a row, of the given half sizes."""
    count = len(sizes)
    specs = {i + 1: ((3.0 * i, 0.0, 0.0), (s, s, s)) for i, s in enumerate(sizes)}
    parts = [Part(0, "root", None, tuple(range(1, count + 1)))]
    parts += [
        Part(i, f"part {i}" if names is None else names[i - 1], 0, (), box_mesh(np.array(specs[i][0]), np.array(specs[i][1])))
        for i in specs
    ]
    return prepare_boxes(Shape("plain", "Test", tuple(parts), Path(), "test"), specs, points=16)


def predictions_of(shape: PreparedShape, motions: dict[tuple[int, int], tuple[MotionType, float]]) -> EdgePredictions:
    """Predictions of given types and probabilities by pair of parts, NONE for other edges. FIXED holds in both directions."""
    both = motions | {pair[::-1]: value for pair, value in motions.items() if value[0] is MotionType.FIXED}
    probabilities = np.zeros((len(shape.edges), 10))
    for row, pair in zip(probabilities, map(tuple, shape.edges.tolist()), strict=True):
        motion, probability = both.get(pair, (MotionType.NONE, 0.9))
        row[:] = (1 - probability) / 9
        row[motion] = probability
    directions = np.tile([0.0, 1.0, 0.0], (len(shape.edges), 1))
    return EdgePredictions(probabilities, directions, shape.edges[:, :1] * np.array([1.0, 0.0, 0.0]))


@pytest.mark.parametrize("seed", range(6))
def test_true_labels_give_the_true_bodies(seed: int) -> None:
    shape = cabinet(seed)
    tree = tree_with_predicted_bodies(shape, predictions_from_labels(shape))
    truth = {frozenset(body.leaves): body for body in shape.mobility.bodies}
    assert {frozenset(body.leaves) for body in tree.bodies} == set(truth)
    for body, estimate in zip(tree.bodies, tree.estimates, strict=True):
        true = truth[frozenset(body.leaves)]
        assert (estimate is None) == (true.joint is None)
        if true.joint is not None:
            assert estimate.type.kind is true.joint.kind
            np.testing.assert_allclose(np.abs(estimate.direction @ true.joint.direction), 1)
            assert set(tree.bodies[body.parent].leaves) == set(shape.mobility.bodies[true.parent].leaves)


@pytest.mark.parametrize("seed", range(3))
def test_given_bodies_have_the_mean_motion_of_their_edges(seed: int) -> None:
    shape = cabinet(seed)
    tree = tree_with_given_bodies(shape, predictions_from_labels(shape))
    assert [body.leaves for body in tree.bodies] == [body.leaves for body in shape.mobility.bodies]
    for index, body in shape.mobility.movable():
        assert tree.estimates[index].type == shape.body_types[index]
        np.testing.assert_allclose(tree.estimates[index].direction, body.joint.direction)
        np.testing.assert_allclose(tree.estimates[index].pivot, body.joint.pivot, atol=1e-12)


def test_joints_of_the_annotation_are_not_used() -> None:
    shape = cabinet(0)
    predictions = predictions_from_labels(shape)
    bodies = tuple(replace(body, joint=None, parent=None) for body in shape.mobility.bodies)
    without_joints = replace(shape, mobility=replace(shape.mobility, bodies=bodies), edge_labels=None, body_types={})
    for one, other in zip(
        tree_with_given_bodies(shape, predictions).estimates,
        tree_with_given_bodies(without_joints, predictions).estimates,
        strict=True,
    ):
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_array_equal(one.probabilities, other.probabilities)


def test_one_given_body_rests_even_if_every_edge_is_none() -> None:
    shape = cabinet(0)
    tree = tree_with_given_bodies(shape, predictions_of(shape, {}))
    assert sum(estimate is None for estimate in tree.estimates) == 1
    assert not has_cycle([body.parent for body in tree.bodies])
    assert all(estimate.type < MotionType.FIXED for estimate in tree.estimates if estimate is not None)


def test_a_given_body_without_an_edge_has_no_estimate() -> None:
    shape = cabinet(0)
    no_edges = EdgePredictions(np.zeros((0, 10)), np.zeros((0, 3)), np.zeros((0, 3)))
    assert set(tree_with_given_bodies(replace(shape, edges=shape.edges[:0]), no_edges).estimates) == {None}


def test_bodies_with_a_wrong_type_get_the_true_one() -> None:
    shape = cabinet(3)
    tree = tree_with_given_bodies(shape, predictions_from_labels(shape))
    types = {body: estimate.type for body, estimate in enumerate(tree.estimates) if estimate is not None}
    assert types and set(with_true_types(tree, types).estimates) == {None}
    body, other = next(iter(types)), MotionType.PR_V
    (corrected,) = (found for found in with_true_types(tree, {**types, body: other}).estimates if found is not None)
    assert corrected.type is other
    assert corrected.direction is tree.estimates[body].direction and corrected.pivot is tree.estimates[body].pivot


def test_fixed_parts_with_the_same_reference_merge_with_the_motion_of_the_larger_part() -> None:
    shape = plain_shape([1.0, 0.3, 0.6])
    motions = {
        (2, 1): (MotionType.P_H, 0.9),
        (3, 1): (MotionType.R_V_S, 0.6),
        (2, 3): (MotionType.FIXED, 0.9),
    }
    tree = tree_with_predicted_bodies(shape, predictions_of(shape, motions))
    assert [body.leaves for body in tree.bodies] == [(1,), (2, 3)]
    assert tree.estimates[1].type is MotionType.R_V_S
    assert tree.bodies[1].name == "part 3"
    assert tree.estimates[1].pivot[0] == 3.0


def test_merging_is_transitive_and_treats_merged_references_as_one() -> None:
    shape = plain_shape([1.0, 1.0, 0.3, 0.3, 0.3])
    fixed = {(1, 2), (3, 4), (4, 5)}
    motions = dict.fromkeys(fixed, (MotionType.FIXED, 0.9))
    motions |= {(3, 1): (MotionType.P_H, 0.9), (4, 2): (MotionType.P_H, 0.9), (5, 1): (MotionType.P_H, 0.9)}
    assert [body.leaves for body in tree_with_predicted_bodies(shape, predictions_of(shape, motions)).bodies] == [
        (1, 2),
        (3, 4, 5),
    ]


def test_fixed_parts_with_different_references_stay_apart() -> None:
    shape = plain_shape([1.0, 1.0, 0.3, 0.3])
    motions = {
        (3, 1): (MotionType.P_H, 0.9),
        (4, 2): (MotionType.P_H, 0.9),
        (2, 1): (MotionType.P_H, 0.9),
        (3, 4): (MotionType.FIXED, 0.9),
    }
    tree = tree_with_predicted_bodies(shape, predictions_of(shape, motions))
    assert [body.leaves for body in tree.bodies] == [(1,), (2,), (3,), (4,)]
    assert [body.parent for body in tree.bodies] == [None, 0, 0, 1]


def test_a_cycle_is_cut_at_its_least_probable_edge() -> None:
    shape = plain_shape([0.5, 0.5, 0.5])
    motions = {(1, 2): (MotionType.P_H, 0.8), (2, 3): (MotionType.P_H, 0.6), (3, 1): (MotionType.P_H, 0.9)}
    tree = tree_with_predicted_bodies(shape, predictions_of(shape, motions))
    assert [body.leaves for body in tree.bodies] == [(2,), (1,), (3,)]
    assert [body.parent for body in tree.bodies] == [None, 0, 1]


def test_a_part_fixed_to_a_moving_part_moves_with_it() -> None:
    shape = plain_shape([1.0, 0.5, 0.1])
    motions = {(2, 1): (MotionType.R_V_S, 0.9), (3, 2): (MotionType.FIXED, 0.9)}
    assert [body.leaves for body in tree_with_predicted_bodies(shape, predictions_of(shape, motions)).bodies] == [(1,), (2, 3)]


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("classes", [10, 5])
def test_every_leaf_has_one_body_and_parents_form_no_cycle_for_any_predictions(seed: int, classes: int) -> None:
    rng = np.random.default_rng(seed)
    shape = cabinet(seed)
    count = len(shape.edges)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    favoured = rng.dirichlet(np.full(classes, 0.3))
    motions = EdgePredictions(rng.dirichlet(favoured * 2 + 1e-2, count), directions, rng.normal(size=(count, 3)))
    tree = tree_with_predicted_bodies(shape, motions)
    assert sorted(leaf for body in tree.bodies for leaf in body.leaves) == sorted(shape.leaves)
    assert not has_cycle([body.parent for body in tree.bodies])
    for body, estimate in zip(tree.bodies, tree.estimates, strict=True):
        assert body.leaves
        if estimate is not None:
            assert body.parent is not None
            assert estimate.type < (MotionType.FIXED if classes == 10 else CoarseType.FIXED)
