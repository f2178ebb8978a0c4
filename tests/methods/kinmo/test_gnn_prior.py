"""The motion GNN's type probabilities as a prior for ranked candidate joints."""

from __future__ import annotations

import numpy as np
import pytest
from edge_predictions import uniform_predictions
from hypothesis import given
from hypothesis import strategies as st
from small_shapes import cabinet_shape

from kinmo.core.joint import KINDS, Joint
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.gnn_prior import (
    MIN_TYPE_PROBABILITY,
    MOTION_TYPES,
    PRIOR_POWER,
    apply_gnn_prior,
    gnn_estimates,
    motion_type_probabilities,
    outward_edges,
)
from kinmo.methods.kinmo.ranking.ranked_joints import rank_joints
from kinmo.methods.kinmo.ranking.shape_views import body_view

SHAPE = prepare_shape(cabinet_shape()[0], points=64)
FEATURES = CandidateFeatures.of(SHAPE.candidate_features)
GROUPS = body_view(SHAPE, FEATURES).groups
BOX = SHAPE.symmetric_boxes[1]


def types_of(group: int) -> list[MotionType]:
    """Motion types of all candidate joints of a group."""
    rows = FEATURES.rows(group)
    motions = zip(FEATURES.kinds[rows].tolist(), FEATURES.directions[rows], FEATURES.pivots[rows], strict=True)
    return [motion_type(Joint(KINDS[kind], direction, pivot), BOX, SHAPE.up) for kind, direction, pivot in motions]


@given(st.integers(0, len(GROUPS) - 1), st.integers(0, 2**32 - 1), st.floats(0.1, 1.0))
def test_the_prior_weights_candidates_by_type_and_keeps_the_probability_of_each_kind(
    body: int, seed: int, moves: float
) -> None:
    rng = np.random.default_rng(seed)
    own, kinds = types_of(GROUPS[body]), FEATURES.kinds[FEATURES.rows(GROUPS[body])]
    probabilities = rng.dirichlet(np.ones(len(own))) * moves
    types = rng.dirichlet(np.ones(MOTION_TYPES)) + 1e-9
    found = apply_gnn_prior(probabilities, types, FEATURES, GROUPS[body], BOX, SHAPE.up)
    expected = np.array([types[each] ** PRIOR_POWER for each in own])
    for kind in np.unique(kinds):
        of_kind = kinds == kind
        assert found[of_kind].sum() == pytest.approx(probabilities[of_kind].sum())
        gains = found[of_kind] / probabilities[of_kind] / expected[of_kind]
        np.testing.assert_allclose(gains, gains[0], rtol=1e-9)


def test_a_uniform_prior_changes_nothing() -> None:
    probabilities = np.random.default_rng(0).dirichlet(np.ones(len(types_of(GROUPS[1]))))
    alike = motion_type_probabilities(SHAPE, SHAPE.body_leaves[1], uniform_predictions(SHAPE, FIXED=1.0))
    assert alike is not None
    np.testing.assert_allclose(apply_gnn_prior(probabilities, alike, FEATURES, GROUPS[1], BOX, SHAPE.up), probabilities)
    assert apply_gnn_prior(probabilities, None, FEATURES, GROUPS[1], BOX, SHAPE.up) is probabilities
    nothing = np.zeros_like(probabilities)
    np.testing.assert_array_equal(apply_gnn_prior(nothing, alike, FEATURES, GROUPS[1], BOX, SHAPE.up), nothing)


def test_the_prior_decides_between_equally_probable_candidates() -> None:
    kinds = FEATURES.kinds[FEATURES.rows(GROUPS[1])]
    for wanted in (MotionType.R_V_S, MotionType.R_H_S, MotionType.P_H, MotionType.P_V):
        types = motion_type_probabilities(
            SHAPE, SHAPE.body_leaves[1], uniform_predictions(SHAPE, **{wanted.name: 0.6, "FIXED": 0.4})
        )
        known = np.array([KINDS[int(kind)] is wanted.kind for kind in kinds])
        probabilities = apply_gnn_prior(known / known.sum(), types, FEATURES, GROUPS[1], BOX, SHAPE.up)
        assert rank_joints(FEATURES, GROUPS[1], probabilities, 0.0, BOX, SHAPE.up)[0].type is wanted


def test_type_probabilities_come_from_the_edges_that_leave_a_body() -> None:
    edges = uniform_predictions(SHAPE, P_H=0.3, R_V_S=0.5, NONE=0.2)
    for leaves in SHAPE.body_leaves:
        outward = outward_edges(SHAPE, leaves)
        types = motion_type_probabilities(SHAPE, leaves, edges)
        if not len(outward):
            assert types is None
            continue
        assert types is not None
        assert types.sum() == pytest.approx(1.0)
        ratio = (0.5 + MIN_TYPE_PROBABILITY) / (0.3 + MIN_TYPE_PROBABILITY)
        assert types[MotionType.R_V_S] / types[MotionType.P_H] == pytest.approx(ratio)
    assert motion_type_probabilities(SHAPE, tuple(range(len(SHAPE.leaves))), edges) is None, "the whole shape has no sibling"


def test_the_gnns_own_joints_have_its_types_and_directions() -> None:
    edges = uniform_predictions(SHAPE, R_V_S=0.7, FIXED=0.3)
    whole = tuple(range(len(SHAPE.leaves)))
    *bodies, root = gnn_estimates(SHAPE, [*SHAPE.body_leaves, whole], edges)
    for estimate in bodies:
        assert estimate.type is MotionType.R_V_S
        np.testing.assert_allclose(estimate.joint.direction, [0.0, 1.0, 0.0])
    assert root.joint is None
