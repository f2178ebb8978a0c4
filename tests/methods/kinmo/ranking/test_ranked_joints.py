"""Ranked joints of one part, from the probabilities of its candidate joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cabinet_geometry import DOOR, UP, cabinet_geometry

from kinmo.core.joint import Joint, JointKind
from kinmo.core.oriented_box import Box
from kinmo.core.shape_estimate import JointEstimate
from kinmo.features.candidate_features import compute_candidate_features
from kinmo.methods.kinmo.ranking.ranked_joints import agreement, rank_joints, same_joint
from kinmo.methods.kinmo.ranking.shape_views import candidate_costs

FEATURES = compute_candidate_features(cabinet_geometry(), [(DOOR,)])
BOX = Box(FEATURES.centers[0], np.eye(3), np.array([0.23, 0.2, 0.01]))
HINGE = Joint(JointKind.REVOLUTE, UP, np.array([-0.23, 0.0, 0.155]))
LIFT = Joint(JointKind.PRISMATIC, UP, np.zeros(3))
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3))


def ranked(best: int, probability: float, rest: float) -> tuple[JointEstimate, ...]:
    """Ranked joints if one candidate has the given probability, and all others share what remains."""
    count = len(FEATURES.kinds)
    probabilities = np.full(count, (1 - rest - probability) / (count - 1))
    probabilities[best] = probability
    return rank_joints(FEATURES, 0, probabilities, rest, BOX, UP)


def test_the_most_probable_axis_comes_first_and_the_others_differ_from_it() -> None:
    best = int(np.argmin(candidate_costs(FEATURES, 0, HINGE)))
    found = ranked(best, 0.7, 0.1)
    assert found[0].joint is not None
    np.testing.assert_allclose(found[0].joint.pivot, FEATURES.pivots[best])
    assert found[0].type.name == "R_V_S"
    assert 0.7 <= found[0].score <= 1.0
    assert found[-1].joint is None
    joints = [estimate.joint for estimate in found if estimate.joint is not None]
    kinds = np.array([joint.kind.code for joint in joints])
    agree = agreement(kinds, np.array([j.direction for j in joints]), np.array([j.pivot for j in joints]))
    assert agree.sum() == len(joints)


def test_uncertain_hinges_with_one_direction_outweigh_a_more_probable_hinge_across() -> None:
    turning = FEATURES.kinds == JointKind.REVOLUTE.code
    upright = turning & (np.abs(FEATURES.directions @ UP) > 0.999)
    edges = np.flatnonzero(upright)[[0, -1]]
    across = int(np.flatnonzero(turning & (np.abs(FEATURES.directions @ UP) < 0.1))[0])
    assert not agreement(FEATURES.kinds, FEATURES.directions, FEATURES.pivots)[edges[0], edges[1]]
    probabilities = np.zeros(len(FEATURES.kinds))
    probabilities[edges], probabilities[across] = (0.3, 0.25), 0.35
    first = rank_joints(FEATURES, 0, probabilities, 0.1, BOX, UP)[0]
    assert first.joint is not None
    np.testing.assert_allclose(first.joint.pivot, FEATURES.pivots[edges[0]])
    assert first.score == pytest.approx(0.3)


def test_a_part_that_rests_has_no_joint_first() -> None:
    found = ranked(0, 0.2, 0.7)
    assert found[0].joint is None
    assert found[1].joint is not None


def test_the_same_joint_may_have_another_sense_and_pivot_along_the_axis() -> None:
    moved_along = replace(HINGE.reversed(), pivot=HINGE.pivot + 7.0 * HINGE.direction)
    assert same_joint(HINGE, moved_along)
    assert not same_joint(HINGE, replace(HINGE, pivot=HINGE.pivot + [0.06, 0.0, 0.0]))
    assert not same_joint(HINGE, LIFT)
    assert same_joint(SLIDE, replace(SLIDE, pivot=np.ones(3)))
