"""Accepting and counting pseudo labels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.prediction import JointEstimate, ShapeEstimate
from kinmo.pipeline.label_acceptance import STEPS, judge, tally, tally_types

scores = st.lists(st.floats(0.0, 1.0), max_size=5)


def prediction(*found: float) -> ShapeEstimate:
    """A base, and a hinged or sliding body a score."""
    kinds = [(JointKind.REVOLUTE, MotionType.R_V_S), (JointKind.PRISMATIC, MotionType.P_H)]
    bodies = [Body(0, "base", (1,))]
    answers = [JointEstimate(None, MotionType.FIXED, 1.0)]
    for index, score in enumerate(found):
        kind, motion = kinds[index % 2]
        joint = Joint(kind, np.array([0.0, 1.0, 0.0]), np.zeros(3))
        bodies.append(Body(index + 1, f"door {index}", (index + 2,), 0, joint))
        answers.append(JointEstimate(joint, motion, score))
    return ShapeEstimate("7", "Door", Mobility(tuple(bodies)), tuple((answer,) for answer in answers), tuple(answers), "paper")


@given(scores, st.floats(0.0, 1.0))
def test_a_shape_is_accepted_exactly_if_all_its_joints_pass(found: list[float], threshold: float) -> None:
    judgement = judge(prediction(*found), "partnet", threshold)
    assert judgement.is_accepted == (bool(found) and all(score > threshold for score in found))
    assert judgement.is_accepted == (judgement.refusal == "")
    assert len(judgement.joints) == len(found)
    assert judgement.score == (min(found) if found else None)


@given(scores, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_shape_is_refused_if_a_part_that_is_said_to_rest_may_well_move(found: list[float], doubt: float, most: float) -> None:
    doubtful = replace(prediction(*found), missed_motion_probability=doubt)
    judgement = judge(doubtful, "partnet", 0.6, most)
    assert judgement.is_accepted == (judge(doubtful, "partnet", 0.6).is_accepted and doubt <= most)
    assert judgement.doubt == doubt


@given(scores, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_higher_threshold_never_accepts_more(found: list[float], one: float, other: float) -> None:
    low, high = sorted((one, other))
    if judge(prediction(*found), "partnet", high).is_accepted:
        assert judge(prediction(*found), "partnet", low).is_accepted


@given(st.lists(scores, max_size=6))
def test_counts_by_type_add_up_to_the_counts_of_all(shapes: list[list[float]]) -> None:
    judgements = [judge(prediction(*found), "partnet", 0.6) for found in shapes]
    whole, parts = tally(judgements), tally_types(judgements)
    assert whole.shapes == len(shapes)
    assert whole.joints == sum(map(len, shapes)) == sum(part.joints for part in parts.values())
    assert whole.accepted_joints == sum(part.accepted_joints for part in parts.values())
    for step, count in enumerate(whole.at_least):
        assert count == sum(score > STEPS[step] for found in shapes for score in found)
        assert count == sum(part.at_least[step] for part in parts.values())


def test_a_shape_in_which_nothing_moves_is_refused() -> None:
    assert judge(prediction(), "partnet", 0.0).refusal == "no moving part was found"
