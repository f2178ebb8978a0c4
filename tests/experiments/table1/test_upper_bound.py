"""The upper bound of Table 1."""

import numpy as np
from articulated import articulated_shapes, prepared_from
from hypothesis import given, settings

from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.upper_bound import upper_bound


@settings(max_examples=15)
@given(articulated_shapes())
def test_the_upper_bound_is_right_if_the_truth_is_among_the_candidates(shape):
    truth = prepared_from(shape)
    rng = np.random.default_rng(0)
    candidates = {}
    for index, body in truth.mobility.movable():
        directions = np.vstack([np.linalg.qr(rng.normal(size=(3, 3)))[0], body.joint.direction])
        candidates[index] = directions, np.vstack([rng.normal(size=(3, 3)), body.joint.pivot])
    score = score_parts_given(truth, upper_bound(truth, candidates))
    assert all(record.is_ok for record in score.records)


@settings(max_examples=5)
@given(articulated_shapes())
def test_a_body_without_candidates_is_missed_even_by_the_upper_bound(shape):
    assert upper_bound(prepared_from(shape), {}) == {}
