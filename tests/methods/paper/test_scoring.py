from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.features.candidate_joints import Candidates
from kinmo.methods.paper.scoring import direction_similarity, position_similarity, score

vectors = st.tuples(*[st.floats(-3, 3, allow_nan=False) for _ in range(3)]).map(np.array)


def some_candidates(count: int = 6, seed: int = 0, kind: int = 0) -> Candidates:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Candidates(np.full(count, kind, np.uint8), directions, rng.normal(size=(count, 3)), ("test",) * count)


DIRECTION, PIVOT = np.array([0.6, 0.0, 0.8]), np.array([0.2, -0.1, 0.3])


@given(st.floats(-5, 5), vectors, st.booleans())
def test_consistency_does_not_change_as_pivots_slide_and_objects_shift_and_axes_flip(slide: float, shift, flip: bool) -> None:
    found = some_candidates()
    sense = -1.0 if flip else 1.0
    other = Candidates(found.kinds, sense * found.directions, found.pivots + slide * found.directions + shift, found.sources)
    np.testing.assert_allclose(position_similarity(PIVOT + shift, other), position_similarity(PIVOT, found), atol=1e-9)
    np.testing.assert_allclose(direction_similarity(DIRECTION, other), direction_similarity(DIRECTION, found), atol=1e-9)


def test_the_predicted_axis_itself_is_fully_consistent() -> None:
    found = Candidates(np.zeros(1, np.uint8), DIRECTION[None], PIVOT[None] + DIRECTION, ("test",))
    assert score(found, DIRECTION, PIVOT, np.ones(1)).total[0] == pytest.approx(1.0)


def test_the_score_is_the_weighted_sum_of_the_paper() -> None:
    found = some_candidates()
    feasibility = np.linspace(0, 1, len(found))
    result = score(found, DIRECTION, PIVOT, feasibility)
    by_hand = 0.5 * feasibility + 0.3 * np.abs(found.directions @ DIRECTION) + 0.2 * position_similarity(PIVOT, found)
    np.testing.assert_allclose(result.total, by_hand)
    np.testing.assert_array_equal(result.terms["feasibility"], feasibility)


def test_sliders_have_no_position_and_the_other_weights_share_its_part() -> None:
    found = some_candidates(kind=1)
    feasibility = np.linspace(0, 1, len(found))
    by_hand = 0.625 * feasibility + 0.375 * np.abs(found.directions @ DIRECTION)
    np.testing.assert_allclose(score(found, DIRECTION, PIVOT, feasibility).total, by_hand)


def test_a_term_that_is_missing_has_no_weight() -> None:
    found = some_candidates()
    consistency = score(found, DIRECTION, PIVOT).total
    np.testing.assert_allclose(
        consistency, 0.6 * direction_similarity(DIRECTION, found) + 0.4 * position_similarity(PIVOT, found)
    )
    swept = score(found, DIRECTION, PIVOT, sweep=np.ones(len(found)), weights=(0.5, 0.3, 0.2, 0.5)).total
    np.testing.assert_allclose(swept, 0.5 * consistency + 0.5)


@pytest.mark.parametrize("kind", [0, 1, 2])
@pytest.mark.parametrize("reading", ["line", "printed"])
def test_scores_lie_between_nought_and_one(kind: int, reading) -> None:
    found = some_candidates(50, kind=kind)
    total = score(found, DIRECTION, PIVOT, np.random.default_rng(1).uniform(size=50), reading=reading).total
    assert ((total >= 0) & (total <= 1)).all()


def test_the_printed_position_depends_on_the_origin_and_survives_a_pivot_there() -> None:
    found = some_candidates()
    printed = position_similarity(PIVOT, found, "printed")
    moved = Candidates(found.kinds, found.directions, found.pivots + 1.0, found.sources)
    assert not np.allclose(printed, position_similarity(PIVOT + 1.0, moved, "printed"))
    assert position_similarity(PIVOT, Candidates(found.kinds, found.directions, 0 * found.pivots, ()), "printed").max() == 0
