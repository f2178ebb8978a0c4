"""Scores of single objects that do not depend on networks."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.features.shape_preparation import prepare_shape
from real_scores import best_candidates, turned

HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), 0.0, 1.5)


def cupboard():
    """A box with a door."""
    boxes = [((0.0, 0.0, 0.0), (1.0, 2.0, 1.0)), ((0.0, 0.0, 1.0), (1.0, 2.0, 1.1))]
    bodies = [Body(0, "body", (1,)), Body(1, "door", (2,), 0, HINGE)]
    return shape_of_boxes(boxes, bodies, shape_id="cupboard", category="Safe")


@pytest.mark.parametrize("freely", [False, True])
def test_a_turned_shape_is_the_same_at_every_call_and_turns_as_a_whole(freely):
    shape, found, again = cupboard(), turned(cupboard(), freely=freely), turned(cupboard(), freely=freely)
    old, new = (np.concatenate([mesh.vertices for mesh in each.meshes()]) for each in (shape, found))
    distances = [np.linalg.norm(points[:, None] - points, axis=2) for points in (old, new)]
    assert np.allclose(*distances) and not np.allclose(old, new)
    assert np.allclose(new, np.concatenate([mesh.vertices for mesh in again.meshes()]))
    assert np.allclose(found.up, shape.up) is not freely


def test_the_best_candidates_are_ok():
    shape = prepare_shape(cupboard())
    (record,) = score_parts_given(shape, best_candidates(shape)).records
    assert record.axis_ok and record.line_at_part < 0.05
