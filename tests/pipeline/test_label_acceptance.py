"""Acceptance of predictions as pseudo labels, and the counts in its report."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.pipeline.label_acceptance import (
    SCORE_STEPS,
    acceptance_report,
    count_accepted,
    count_by_type,
    decide,
    decision_from_data,
)

scores = st.lists(st.floats(0.0, 1.0), max_size=5)


def prediction(*found: float) -> ShapeEstimate:
    """A base, and a hinged or sliding body for each score."""
    kinds = [(JointKind.REVOLUTE, MotionType.R_V_S), (JointKind.PRISMATIC, MotionType.P_H)]
    bodies = [Body(0, "base", (1,))]
    estimates = [JointEstimate(None, MotionType.FIXED, 1.0)]
    for index, score in enumerate(found):
        kind, motion = kinds[index % 2]
        joint = Joint(kind, np.array([0.0, 1.0, 0.0]), np.zeros(3))
        bodies.append(Body(index + 1, f"door {index}", (index + 2,), 0, joint))
        estimates.append(JointEstimate(joint, motion, score))
    ranked = tuple((estimate,) for estimate in estimates)
    return ShapeEstimate("7", "Door", Mobility(tuple(bodies)), ranked, tuple(estimates), "paper")


@given(scores, st.floats(0.0, 1.0))
def test_a_shape_is_accepted_exactly_if_all_its_joints_pass(found: list[float], threshold: float) -> None:
    decision = decide(prediction(*found), "partnet", threshold)
    assert decision.is_accepted == (bool(found) and all(score > threshold for score in found))
    assert decision.is_accepted == (decision.refusal == "")
    assert len(decision.joints) == len(found)
    assert decision.score == (min(found) if found else None)


@given(scores, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_shape_is_refused_if_a_resting_part_may_well_move(found: list[float], doubt: float, most: float) -> None:
    doubtful = replace(prediction(*found), missed_motion_probability=doubt)
    decision = decide(doubtful, "partnet", 0.6, most)
    assert decision.is_accepted == (decide(doubtful, "partnet", 0.6).is_accepted and doubt <= most)
    assert decision.doubt == doubt


@given(scores, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_higher_threshold_never_accepts_more(found: list[float], one: float, other: float) -> None:
    low, high = sorted((one, other))
    if decide(prediction(*found), "partnet", high).is_accepted:
        assert decide(prediction(*found), "partnet", low).is_accepted


@given(st.lists(scores, max_size=6))
def test_counts_by_type_add_up_to_the_counts_of_all(shapes: list[list[float]]) -> None:
    decisions = [decide(prediction(*found), "partnet", 0.6) for found in shapes]
    whole, parts = count_accepted(decisions), count_by_type(decisions)
    assert whole.shapes == len(shapes)
    assert whole.joints == sum(map(len, shapes)) == sum(part.joints for part in parts.values())
    assert whole.accepted_joints == sum(part.accepted_joints for part in parts.values())
    for step, count in enumerate(whole.above):
        assert count == sum(score > SCORE_STEPS[step] for found in shapes for score in found)
        assert count == sum(part.above[step] for part in parts.values())


def test_a_shape_without_moving_parts_is_refused() -> None:
    assert decide(prediction(), "partnet", 0.0).refusal == "no moving part was found"


@given(scores, st.floats(0.0, 1.0))
def test_a_decision_survives_its_plain_data(found: list[float], threshold: float) -> None:
    decision = decide(prediction(*found), "partnet", threshold)
    assert decision_from_data(json.loads(json.dumps(asdict(decision)))) == decision


@pytest.mark.parametrize("data", [{}, {"joints": [{}]}, {"joints": [], "shape": 3}])
def test_other_data_is_no_decision(data: dict[str, object]) -> None:
    with pytest.raises((KeyError, TypeError)):
        decision_from_data(data)


def test_the_report_lists_refusals_by_reason() -> None:
    decisions = [decide(prediction(*found), "partnet", 0.5) for found in ((0.9, 0.8), (0.4,), (), ())]
    report = acceptance_report(decisions, "paper", 3)
    assert report["text"] == (
        "Accepted 1 of 4 shapes (all joints above 0.5, by paper) and 2 of 3 joints; skipped 3 copies of labelled shapes."
    )
    reasons = {reason: len(ids) for reason, ids in report["refused"].items()}
    assert reasons == {"no moving part was found": 2, "a joint scores no more than 0.5: R_V_S": 1}
    assert report["tables"][2]["rows"][0] == ["no moving part was found", "2", "7"], "the most frequent reason comes first"
