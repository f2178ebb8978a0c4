"""The row without learning."""

import numpy as np
import pytest
from articulated import articulated_shapes, prepared_from, shape_of_boxes
from hypothesis import given, settings

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.experiments.table1.rule_baseline import segmented_without_learning, without_learning


def furniture():
    """A closed door, a drawer, a button and a lid that stands open, on a cabinet."""
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


@pytest.mark.parametrize(("judge", "rule"), [(parts_given, without_learning), (hierarchy_given, segmented_without_learning)])
def test_the_rule_opens_plain_furniture_whether_or_not_its_bodies_are_given(judge, rule):
    truth = prepared_from(furniture(), points=400)
    score = judge(truth, rule(truth))
    assert {record.name: record.is_ok for record in score.records} == dict.fromkeys(("door", "drawer", "button", "lid"), True)
    assert not score.false_alarms


@settings(max_examples=20)
@given(articulated_shapes())
def test_the_rule_answers_every_body_with_a_unit_axis(shape):
    truth = prepared_from(shape)
    answers = without_learning(truth)
    assert set(answers) == set(range(len(truth.mobility.bodies)))
    for answer in answers.values():
        if answer.joint is not None:
            assert np.linalg.norm(answer.joint.direction) == pytest.approx(1)
            assert answer.type.kind is answer.joint.kind


@settings(max_examples=20)
@given(articulated_shapes())
def test_bodies_read_off_the_hierarchy_hold_every_leaf_once_and_rest_on_one(shape):
    truth = prepared_from(shape)
    found = segmented_without_learning(truth)
    assert sorted(leaf for body in found.mobility.bodies for leaf in body.leaves) == sorted(truth.leaves)
    resting = [body for body in found.mobility.bodies if body.joint is None]
    assert [body.parent for body in found.mobility.bodies if body.joint is not None] == [resting[0].id] * (
        len(found.mobility.bodies) - len(resting)
    )
