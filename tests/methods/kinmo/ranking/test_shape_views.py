"""Views of bodies and of proposals, and their targets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from groupings import grouped_without_network
from small_shapes import cabinet_shape

from kinmo.core.mobility import Mobility
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.body_ranking import features_of_groups
from kinmo.methods.kinmo.ranking.shape_views import (
    view_of_bodies,
    view_of_proposals,
    with_targets_of_bodies,
    with_targets_of_proposals,
)

SHAPE = cabinet_shape(1)[0]
PREPARED = prepare_shape(SHAPE, points=64)
FEATURES = CandidateFeatures.of(PREPARED.candidate_features)


def shares_of(proposals: list[tuple[int, ...]], shape: PreparedShape = PREPARED) -> list[float]:
    """Target probability that each proposal moves."""
    features = features_of_groups(shape, ShapeGeometry.of_prepared(shape, leaf_meshes(SHAPE, shape)), proposals)
    view = view_of_proposals(grouped_without_network(shape), features, proposals)
    return [float(target.sum()) for target in with_targets_of_proposals(view, shape, proposals).targets]


def test_bodies_that_move_have_targets_and_others_rest() -> None:
    mobility, _ = PREPARED.annotation
    view = view_of_bodies(grouped_without_network(PREPARED), FEATURES, PREPARED.body_leaves)
    assert not view.has_joints
    known = with_targets_of_bodies(view, mobility)
    assert [bool(target.any()) for target in known.targets] == [body.joint is not None for body in mobility.bodies]
    assert known.weights.sum() == pytest.approx(np.sqrt(len(mobility.bodies)))


def test_the_best_proposal_for_a_body_moves_surely_and_others_less() -> None:
    mobility, _ = PREPARED.annotation
    index, _ = next(mobility.movable())
    body, base = PREPARED.body_leaves[index], PREPARED.body_leaves[0]
    largest = max(body, key=lambda leaf: PREPARED.leaf_areas[leaf])
    exact, part, at_rest = shares_of([body, (largest,), base])
    assert exact == pytest.approx(1.0)
    assert at_rest == 0.0
    if len(body) > 1:
        assert 0.0 < part < 1.0
        assert shares_of([(largest,)]) == [pytest.approx(1.0)], "the best there is"


def test_proposals_of_junk_alone_do_not_count() -> None:
    mobility, _ = PREPARED.annotation
    leaf = PREPARED.leaves[PREPARED.body_leaves[0][0]]
    junk = replace(PREPARED, mobility=Mobility(mobility.bodies, frozenset([leaf])))
    proposals = [(PREPARED.body_leaves[0][0],), PREPARED.body_leaves[0]]
    view = view_of_proposals(grouped_without_network(junk), FEATURES, proposals)
    weights = with_targets_of_proposals(view, junk, proposals).weights
    assert weights[0] == 0.0 < weights[1]


def test_hidden_names_leave_no_words_but_the_category_stays() -> None:
    hidden = replace(grouped_without_network(PREPARED), shows_names=False)
    view = view_of_bodies(hidden, FEATURES, PREPARED.body_leaves)
    assert not any(view.words) and view.category


def test_without_the_hierarchy_only_names_of_leaves_count() -> None:
    body = next(body for body in PREPARED.body_leaves if len(body) > 1)
    shown, flat = (
        view_of_bodies(grouped_without_network(PREPARED, shows_hierarchy=shows), FEATURES, [body]).words[0]
        for shows in (True, False)
    )
    assert set(flat) != set(shown)
    names = tuple(name if i in PREPARED.leaves else "x" for i, name in enumerate(PREPARED.part_names))
    renamed = replace(PREPARED, part_names=names)
    again = view_of_bodies(grouped_without_network(renamed, shows_hierarchy=False), FEATURES, [body]).words[0]
    assert again == flat
