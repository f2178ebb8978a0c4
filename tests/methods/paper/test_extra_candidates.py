"""Candidate axes beyond the paper's: selection by source and orientation, and merging."""

from __future__ import annotations

import numpy as np

from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.oriented_box import Box
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.candidate_lines import LineSource, candidate_lines
from kinmo.methods.paper.extra_candidates import line_candidates, merge_candidates

UP = np.array([0.0, 1.0, 0.0])


def candidates(kinds: list[int], directions: list[list[float]], pivots: list[list[float]]) -> CandidateJoints:
    return CandidateJoints(
        np.array(kinds, np.uint8), np.array(directions, float), np.array(pivots, float), ("test",) * len(kinds)
    )


def test_merging_keeps_one_of_equal_axes_whatever_their_sense_and_pivot() -> None:
    once = candidates([0, 0, 0, 1, 1], [[1, 0, 0]] * 5, [[0, 0, 0], [5, 0, 0], [0, 0.01, 0], [0, 0, 0], [0, 1, 0]])
    again = candidates([0], [[-1, 0, 0]], [[2, 0.0001, 0]])
    found = merge_candidates(once, again)
    assert found.kinds.tolist() == [0, 0, 1]
    np.testing.assert_array_equal(found.pivots, [[0, 0, 0], [0, 0.01, 0], [0, 0, 0]])


def test_lines_are_selected_by_source_and_orientation() -> None:
    box = Box(np.zeros(3), np.eye(3), np.array([0.3, 0.2, 0.1]))
    contact = np.array([[x, 0.2, 0.0] for x in np.linspace(-0.3, 0.3, 7)])
    symmetry = {LineSource.SYMMETRY_AXIS: np.array([[[0.0, 0, 0], [0.0, 1, 0]]])}
    lines = candidate_lines(box, box, contact, np.full(7, 1 / 7), symmetry)
    symmetric = line_candidates(MotionType.R_V_C, lines, UP, [LineSource.SYMMETRY_AXIS])
    assert len(symmetric) == 1
    np.testing.assert_allclose(np.abs(symmetric.directions @ UP), 1)
    touching = line_candidates(MotionType.R_H_S, lines, UP, [LineSource.CONTACT_LINE, LineSource.CONTACT_CENTER])
    assert len(touching) >= 1
    assert (np.abs(touching.directions @ UP) < 0.1).all()
    slides = line_candidates(CoarseType.P, lines, UP, list(LineSource))
    assert len(slides) == 3
