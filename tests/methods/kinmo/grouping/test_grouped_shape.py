"""Proposals of bodies, and how well they hold together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from groupings import grouped_without_network
from small_shapes import cabinet_shape

from kinmo.core.shape_forms import flat_parts, flat_shape
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.grouping.grouped_shape import MAX_LOGIT

MADE, ABSORBED, INSIDE, LEAST_INSIDE, OUTSIDE = range(5)
IS_NODE, IS_MERGE = 9, 10


@pytest.fixture(scope="module")
def cabinet() -> PreparedShape:
    return prepare_shape(cabinet_shape(1)[0], points=64)


def bodies_of(shape: PreparedShape) -> tuple[frozenset[int], ...]:
    return tuple(map(frozenset, shape.body_leaves))


def test_proposals_are_leaves_merges_and_nodes_but_not_the_whole_shape(cabinet: PreparedShape) -> None:
    count = len(cabinet.leaves)
    grouped = grouped_without_network(cabinet, bodies_of(cabinet))
    assert {(leaf,) for leaf in range(count)} <= set(grouped.proposals)
    assert set(cabinet.leaves_below[1:]) <= set(grouped.proposals)
    assert {body for body in cabinet.body_leaves if len(body) < count} <= set(grouped.proposals)
    assert all(len(group) < count for group in grouped.proposals)
    assert len(set(grouped.proposals)) == len(grouped.proposals)
    flat = replace(grouped, shows_hierarchy=False)
    assert set(flat.proposals) == {(leaf,) for leaf in range(count)} | {
        merge.leaves for merge in grouped.merges if len(merge.leaves) < count
    }


def test_a_body_holds_together_and_is_set_apart(cabinet: PreparedShape) -> None:
    grouped = grouped_without_network(cabinet, bodies_of(cabinet))
    body = next(cabinet.body_leaves[index] for index, _ in cabinet.annotation[0].movable())
    assert len(body) > 1
    (found,) = grouped.cohesion([body])
    assert found[[MADE, INSIDE, LEAST_INSIDE]].tolist() == [3.0, 3.0, 3.0]
    assert found[[ABSORBED, OUTSIDE]].tolist() == [-3.0, -3.0]
    assert found[IS_MERGE] == 1.0


def test_a_leaf_has_nothing_inside(cabinet: PreparedShape) -> None:
    (found,) = grouped_without_network(cabinet).cohesion([(0,)])
    assert found[[MADE, INSIDE, LEAST_INSIDE]].tolist() == [MAX_LOGIT] * 3


def test_nodes_count_only_where_the_hierarchy_is_shown(cabinet: PreparedShape) -> None:
    node = next(below for below in cabinet.leaves_below[1:] if len(below) > 1)
    shown, hidden = (
        grouped_without_network(cabinet, shows_hierarchy=shows).cohesion([node])[0, IS_NODE] for shows in (True, False)
    )
    assert (shown, hidden) == (1.0, 0.0)
    flat = cabinet_shape(1)[0]
    assert not grouped_without_network(prepare_shape(flat_shape(flat, flat_parts(flat)), points=64)).shows_hierarchy


def test_features_do_not_exceed_the_largest_logit(cabinet: PreparedShape) -> None:
    grouped = grouped_without_network(cabinet)
    sure = replace(grouped, grouping=replace(grouped.grouping, logits=100.0 * grouped.grouping.logits))
    assert np.abs(sure.cohesion(sure.proposals)).max() <= MAX_LOGIT
