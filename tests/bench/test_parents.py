"""The bench of parents counts wrong ones."""

from __future__ import annotations

import numpy as np
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from parents import MOST, TREE, wrong_parents

X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
SWIVEL = Joint(JointKind.REVOLUTE, Y, np.array([0.5, 0.0, 0.5]))
AXLE = Joint(JointKind.REVOLUTE, X, np.array([0.4, -0.3, 0.5]))
CHAIR, FORK, WHEEL = ((0, 0, 0), (1, 1, 1)), ((0.45, -0.3, 0.4), (0.55, 0, 0.6)), ((0.3, -0.45, 0.4), (0.45, -0.15, 0.6))


def test_the_fork_of_a_wheel_tells_both_ways_apart() -> None:
    bodies = [Body(0, "chair", (1,)), Body(1, "fork", (2,), 0, SWIVEL), Body(2, "wheel", (3,), 1, AXLE)]
    assert wrong_parents(shape_of_boxes([CHAIR, FORK, WHEEL], bodies)) == (2, {TREE: 0, MOST: 1})


def test_an_annotation_with_another_parent_counts_as_wrong() -> None:
    bodies = [Body(0, "chair", (1,)), Body(1, "fork", (2,), 0, SWIVEL), Body(2, "wheel", (3,), 0, AXLE)]
    count, wrong = wrong_parents(shape_of_boxes([CHAIR, FORK, WHEEL], bodies))
    assert count == 2 and wrong[TREE] == 1
