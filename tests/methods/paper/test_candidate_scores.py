"""Scores of candidate axes: direction similarity, position similarity, final score (paper, section 3.3, equations 5 to 7)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.features.candidate_joints import CandidateJoints
from kinmo.methods.paper.candidate_scores import direction_similarity, position_similarity, score_candidates

vectors = st.tuples(*[st.floats(-3, 3, allow_nan=False) for _ in range(3)]).map(np.array)


def some_candidates(count: int = 6, seed: int = 0, kind: int = 0) -> CandidateJoints:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return CandidateJoints(np.full(count, kind, np.uint8), directions, rng.normal(size=(count, 3)), ("test",) * count)


DIRECTION, PIVOT = np.array([0.6, 0.0, 0.8]), np.array([0.2, -0.1, 0.3])


@given(st.floats(-5, 5), vectors, st.booleans())
def test_similarities_do_not_change_when_pivots_slide_objects_shift_or_axes_flip(slide: float, shift, flip: bool) -> None:
    found = some_candidates()
    sense = -1.0 if flip else 1.0
    other = CandidateJoints(
        found.kinds, sense * found.directions, found.pivots + slide * found.directions + shift, found.sources
    )
    np.testing.assert_allclose(position_similarity(PIVOT + shift, other), position_similarity(PIVOT, found), atol=1e-9)
    np.testing.assert_allclose(direction_similarity(DIRECTION, other), direction_similarity(DIRECTION, found), atol=1e-9)


def test_the_predicted_axis_itself_is_fully_consistent() -> None:
    found = CandidateJoints(np.zeros(1, np.uint8), DIRECTION[None], PIVOT[None] + DIRECTION, ("test",))
    assert score_candidates(found, DIRECTION, PIVOT, np.ones(1)).total[0] == pytest.approx(1.0)


def test_the_final_score_is_the_papers_weighted_sum() -> None:
    found = some_candidates()
    feasibility = np.linspace(0, 1, len(found))
    result = score_candidates(found, DIRECTION, PIVOT, feasibility)
    by_hand = 0.5 * feasibility + 0.3 * np.abs(found.directions @ DIRECTION) + 0.2 * position_similarity(PIVOT, found)
    np.testing.assert_allclose(result.total, by_hand)
    np.testing.assert_array_equal(result.terms["feasibility"], feasibility)


def test_sliders_have_no_position_term_and_the_other_weights_are_scaled_up() -> None:
    found = some_candidates(kind=1)
    feasibility = np.linspace(0, 1, len(found))
    by_hand = 0.625 * feasibility + 0.375 * np.abs(found.directions @ DIRECTION)
    np.testing.assert_allclose(score_candidates(found, DIRECTION, PIVOT, feasibility).total, by_hand)


def test_a_missing_term_has_no_weight() -> None:
    found = some_candidates()
    consistency = score_candidates(found, DIRECTION, PIVOT).total
    np.testing.assert_allclose(
        consistency, 0.6 * direction_similarity(DIRECTION, found) + 0.4 * position_similarity(PIVOT, found)
    )
    swept = score_candidates(found, DIRECTION, PIVOT, sweep=np.ones(len(found)), weights=(0.5, 0.3, 0.2, 0.5)).total
    np.testing.assert_allclose(swept, 0.5 * consistency + 0.5)


@pytest.mark.parametrize("kind", [0, 1, 2])
@pytest.mark.parametrize("reading", ["line", "printed"])
def test_scores_lie_between_zero_and_one(kind: int, reading) -> None:
    found = some_candidates(50, kind=kind)
    total = score_candidates(found, DIRECTION, PIVOT, np.random.default_rng(1).uniform(size=50), reading=reading).total
    assert ((total >= 0) & (total <= 1)).all()


def test_the_printed_position_similarity_depends_on_the_origin_and_is_zero_there() -> None:
    found = some_candidates()
    printed = position_similarity(PIVOT, found, "printed")
    moved = CandidateJoints(found.kinds, found.directions, found.pivots + 1.0, found.sources)
    assert not np.allclose(printed, position_similarity(PIVOT + 1.0, moved, "printed"))
    assert (
        position_similarity(PIVOT, CandidateJoints(found.kinds, found.directions, 0 * found.pivots, ()), "printed").max() == 0
    )
