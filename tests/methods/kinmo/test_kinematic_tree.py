"""Kinematic tree of ranked bodies: parents and joint limits."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import shape_of_boxes
from groupings import grouped_without_network
from rankers import FeatureRanker

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.shape_preparation import prepare_shape
from kinmo.features.travel_features import FREE
from kinmo.methods.kinmo.body_ranking import features_of_groups, rank_bodies
from kinmo.methods.kinmo.kinematic_tree import ShapeLimits
from kinmo.methods.kinmo.limits.travel_examples import TravelExamples

HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.3, 0.0, 0.1]))


class RightAngles:
    """Joints travel one unit to the freer side, and half a unit to the other one."""

    def travel(self, joints: TravelExamples) -> tuple[np.ndarray, np.ndarray]:
        freer = joints.directed[:, 0, FREE] >= joints.directed[:, 1, FREE]
        return np.where(freer[:, None], [1.0, 0.5], [0.5, 1.0]), np.ones(len(joints), bool)


def test_limits_of_the_best_joint_do_not_depend_on_the_others() -> None:
    box, lid = ((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1))
    made = shape_of_boxes([box, lid], (Body(0, "box", (1,)), Body(1, "lid", (2,), 0, HINGE)))
    shape = prepare_shape(made, points=64)
    geometry = ShapeGeometry.of_prepared(shape, leaf_meshes(made, shape))
    kinds = [None, JointKind.REVOLUTE]
    _, ranked = rank_bodies(grouped_without_network(shape), geometry, shape.body_leaves, FeatureRanker(), kinds=kinds)
    limits = ShapeLimits(shape, geometry, features_of_groups(shape, geometry, shape.body_leaves), RightAngles())
    limited, alone = limits.added(ranked, (1,), [1]), limits.added(ranked[:1], (1,), [1])
    assert len(limited) == len(ranked) > 1
    assert (limited[0].joint.lower, limited[0].joint.upper) == (alone[0].joint.lower, alone[0].joint.upper)
    for before, after in zip(ranked, limited, strict=True):
        assert (before.joint is None) == (after.joint is None)
        if before.joint is not None:
            assert "sweep" in after.terms
            assert after.joint.upper == pytest.approx(-2.0 * after.joint.lower), "directions point to the longer side"
