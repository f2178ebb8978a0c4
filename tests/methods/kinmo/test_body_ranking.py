"""Ranking of the candidate joints of bodies: known kinds, bodies at rest, and bodies that were not prepared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from groupings import grouped_without_network
from rankers import FeatureRanker, UniformRanker

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.body_ranking import rank_bodies

HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.3, 0.0, 0.1]))


@pytest.fixture(scope="module")
def box_with_lid() -> PreparedShape:
    boxes = [((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1))]
    return prepare_shape(shape_of_boxes(boxes, (Body(0, "box", (1,)), Body(1, "lid", (2,), 0, HINGE))), points=64)


def moving_bodies(shape: PreparedShape, bodies: list[tuple[int, ...]], rest: tuple[float, ...], may_rest: str) -> list[int]:
    """Bodies that get a joint."""
    ranked = rank_bodies(grouped_without_network(shape), None, bodies, UniformRanker(rest), may_rest=may_rest)
    return [index for index, found in enumerate(ranked) if found[0].joint is not None]


@pytest.mark.parametrize("kind", list(JointKind))
def test_a_body_of_known_kind_gets_a_joint_of_that_kind(box_with_lid: PreparedShape, kind: JointKind) -> None:
    grouped, bodies = grouped_without_network(box_with_lid), box_with_lid.body_leaves
    predicted = rank_bodies(grouped, None, bodies, UniformRanker())
    given = rank_bodies(grouped, None, bodies, UniformRanker(), kinds=[None, kind])
    assert predicted[1][0].joint is None and given[1][0].joint.kind is kind
    assert given[0][0].joint is None and given[0][0].score == predicted[0][0].score


@pytest.mark.parametrize(
    ("may_rest", "rest", "moving"),
    [
        ("any", (0.8, 0.9), []),
        ("one", (0.8, 0.9), [0]),
        ("one", (0.9, 0.8), [1]),
        ("one", (0.4, 0.3), [0, 1]),
    ],
)
def test_only_bodies_that_may_rest_do(
    box_with_lid: PreparedShape, may_rest: str, rest: tuple[float, float], moving: list[int]
) -> None:
    assert moving_bodies(box_with_lid, list(box_with_lid.body_leaves), rest, may_rest) == moving


def test_a_body_without_parts_rests(box_with_lid: PreparedShape) -> None:
    assert moving_bodies(box_with_lid, [(), (0,), (1,)], (0.1, 0.9), "any") == [1]


def test_results_do_not_depend_on_the_bodies_that_the_shape_was_prepared_with() -> None:
    boxes = [((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1)), ((0.4, 1.1, 0.9), (0.6, 1.2, 1))]
    annotated = shape_of_boxes(boxes, (Body(0, "box", (1,)), Body(1, "lid", (2, 3), 0, HINGE)))
    known, unknown = prepare_shape(annotated, points=64), prepare_shape(replace(annotated, mobility=None), points=64)
    unannotated = replace(known, mobility=None, body_boxes=None, body_types={}, edge_labels=None)
    assert (1, 2) not in unknown.leaves_below
    with pytest.raises(ValueError, match="geometry: needed"):
        rank_bodies(grouped_without_network(unknown), None, known.body_leaves, FeatureRanker())
    expected, found, again = (
        rank_bodies(
            grouped_without_network(shape),
            ShapeGeometry.of_prepared(shape, leaf_meshes(annotated, shape)),
            known.body_leaves,
            FeatureRanker(),
        )
        for shape in (known, unknown, unannotated)
    )
    for one, other in zip(expected * 2, found + again, strict=True):
        assert [estimate.type for estimate in one] == [estimate.type for estimate in other]
        assert [estimate.score for estimate in one] == [estimate.score for estimate in other]
        for a, b in zip(one, other, strict=True):
            if a.joint is not None:
                np.testing.assert_array_equal(a.joint.direction, b.joint.direction)
                np.testing.assert_array_equal(a.joint.pivot, b.joint.pivot)
