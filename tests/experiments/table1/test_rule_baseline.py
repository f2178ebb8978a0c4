"""The baseline without learning."""

import numpy as np
import pytest
from articulated import articulated_shapes, prepared_from, shape_of_boxes
from hypothesis import given, settings

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.evaluation.hierarchy_given import score_hierarchy_given
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.rule_baseline import rule_joints, rule_prediction


def furniture():
    """A closed door, a drawer, a button and an open lid on a cabinet."""
    boxes = [
        ((-0.5, 0, -0.5), (0.5, 2, 0.5)),
        ((0.0, 1, 0.5), (0.5, 2, 0.52)),
        ((-0.4, 0.2, 0.0), (0.4, 0.6, 0.6)),
        ((-0.3, 1.5, 0.5), (-0.28, 1.52, 0.51)),
        ((-0.5, 2.0, -0.5), (0.5, 2.6, -0.48)),
    ]
    up, front = np.array([0.0, 1, 0]), np.array([0.0, 0, 1])
    joints = [
        Joint(JointKind.REVOLUTE, up, np.array([0.5, 0, 0.5])),
        Joint(JointKind.PRISMATIC, front, np.zeros(3)),
        Joint(JointKind.PRISMATIC, front, np.zeros(3)),
        Joint(JointKind.REVOLUTE, np.array([1.0, 0, 0]), np.array([0, 2.0, -0.5])),
    ]
    names = ("door", "drawer", "button", "lid")
    bodies = [Body(i + 1, name, (i + 2,), 0, joint) for i, (name, joint) in enumerate(zip(names, joints, strict=True))]
    return shape_of_boxes(boxes, (Body(0, "body", (1,)), *bodies))


@pytest.mark.parametrize(
    ("evaluate", "rule"),
    [(score_parts_given, rule_joints), (score_hierarchy_given, rule_prediction)],
    ids=["parts", "hierarchy"],
)
def test_the_rule_opens_plain_furniture_with_and_without_given_bodies(evaluate, rule):
    truth = prepared_from(furniture(), points=400)
    score = evaluate(truth, rule(truth))
    assert {record.name: record.is_ok for record in score.records} == dict.fromkeys(("door", "drawer", "button", "lid"), True)
    assert not score.false_alarms


@settings(max_examples=20)
@given(articulated_shapes())
def test_the_rule_predicts_a_unit_axis_for_every_moving_body(shape):
    truth = prepared_from(shape)
    estimates = rule_joints(truth)
    assert set(estimates) == set(range(len(truth.mobility.bodies)))
    for estimate in estimates.values():
        if estimate.joint is not None:
            assert np.linalg.norm(estimate.joint.direction) == pytest.approx(1)
            assert estimate.type.kind is estimate.joint.kind


@settings(max_examples=20)
@given(articulated_shapes())
def test_bodies_from_the_hierarchy_hold_every_leaf_once_and_one_of_them_rests(shape):
    truth = prepared_from(shape)
    found = rule_prediction(truth)
    assert sorted(leaf for body in found.mobility.bodies for leaf in body.leaves) == sorted(truth.leaves)
    resting = [body for body in found.mobility.bodies if body.joint is None]
    assert [body.parent for body in found.mobility.bodies if body.joint is not None] == [resting[0].id] * (
        len(found.mobility.bodies) - len(resting)
    )
