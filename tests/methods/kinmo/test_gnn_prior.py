"""The motion GNN's word in how bodies move."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_shapes import cabinet_shape

from kinmo.core.joint import KINDS, Joint
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.features.candidate_features import Evidence
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.kinmo.gnn_prior import LEAST, MOTIONS, SAY, motion_types_of, outward_edges, with_types
from kinmo.methods.kinmo.ranking.ranked_joints import rank_answers
from kinmo.methods.kinmo.ranking.shape_views import body_view

SHAPE = prepare_shape(cabinet_shape()[0], points=64)
EVIDENCE = Evidence.of(SHAPE.evidence)
UNITS = body_view(SHAPE, EVIDENCE).units
BOX = SHAPE.symmetric_boxes[1]


def told(shape: PreparedShape, **odds: float) -> EdgePredictions:
    """A GNN that says the same of every edge."""
    types = np.zeros((len(shape.edges), len(MotionType)))
    for name, chance in odds.items():
        types[:, MotionType[name]] = chance
    return EdgePredictions(types, np.tile([0.0, 1.0, 0.0], (len(types), 1)), np.zeros((len(types), 3)))


def types_of(unit: int) -> list[MotionType]:
    """Of every hypothesis."""
    rows = EVIDENCE.rows(unit)
    motions = zip(EVIDENCE.kinds[rows].tolist(), EVIDENCE.directions[rows], EVIDENCE.pivots[rows], strict=True)
    return [motion_type(Joint(KINDS[kind], direction, pivot), BOX, SHAPE.up) for kind, direction, pivot in motions]


@given(st.integers(0, len(UNITS) - 1), st.integers(0, 2**32 - 1), st.floats(0.1, 1.0))
def test_hypotheses_of_a_kind_gain_by_their_types_and_kinds_stay_as_likely(body: int, seed: int, moves: float) -> None:
    rng = np.random.default_rng(seed)
    own, kinds = types_of(UNITS[body]), EVIDENCE.kinds[EVIDENCE.rows(UNITS[body])]
    odds = rng.dirichlet(np.ones(len(own))) * moves
    types = rng.dirichlet(np.ones(MOTIONS)) + 1e-9
    found = with_types(odds, types, EVIDENCE, UNITS[body], BOX, SHAPE.up)
    expected = np.array([types[each] ** SAY for each in own])
    for kind in np.unique(kinds):
        of_kind = kinds == kind
        assert found[of_kind].sum() == pytest.approx(odds[of_kind].sum())
        gains = found[of_kind] / odds[of_kind] / expected[of_kind]
        np.testing.assert_allclose(gains, gains[0], rtol=1e-9)


def test_where_the_gnn_tells_no_types_apart_the_ranking_decides_alone() -> None:
    odds = np.random.default_rng(0).dirichlet(np.ones(len(types_of(UNITS[1]))))
    alike = motion_types_of(SHAPE, SHAPE.body_leaves[1], told(SHAPE, FIXED=1.0))
    assert alike is not None
    np.testing.assert_allclose(with_types(odds, alike, EVIDENCE, UNITS[1], BOX, SHAPE.up), odds)
    assert with_types(odds, None, EVIDENCE, UNITS[1], BOX, SHAPE.up) is odds
    nothing = np.zeros_like(odds)
    np.testing.assert_array_equal(with_types(nothing, alike, EVIDENCE, UNITS[1], BOX, SHAPE.up), nothing)


def test_a_ranking_that_knows_the_kind_alone_follows_the_gnn() -> None:
    kinds = EVIDENCE.kinds[EVIDENCE.rows(UNITS[1])]
    for wanted in (MotionType.R_V_S, MotionType.R_H_S, MotionType.P_H, MotionType.P_V):
        types = motion_types_of(SHAPE, SHAPE.body_leaves[1], told(SHAPE, **{wanted.name: 0.6, "FIXED": 0.4}))
        known = np.array([KINDS[int(kind)] is wanted.kind for kind in kinds])
        odds = with_types(known / known.sum(), types, EVIDENCE, UNITS[1], BOX, SHAPE.up)
        assert rank_answers(EVIDENCE, UNITS[1], odds, 0.0, BOX, SHAPE.up)[0].type is wanted


def test_types_are_those_of_the_edges_that_lead_out_of_a_body() -> None:
    edges = told(SHAPE, P_H=0.3, R_V_S=0.5, NONE=0.2)
    for leaves in SHAPE.body_leaves:
        outwards = outward_edges(SHAPE, leaves)
        types = motion_types_of(SHAPE, leaves, edges)
        if not len(outwards):
            assert types is None
            continue
        assert types is not None
        assert types.sum() == pytest.approx(1.0)
        ratio = (0.5 + LEAST) / (0.3 + LEAST)
        assert types[MotionType.R_V_S] / types[MotionType.P_H] == pytest.approx(ratio)
    assert motion_types_of(SHAPE, tuple(range(len(SHAPE.leaves))), edges) is None, "the whole has no sibling"
