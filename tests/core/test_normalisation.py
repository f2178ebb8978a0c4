"""The normalised frame."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import articulated_shapes
from hypothesis import given, settings

from kinmo.core.kinematics import forward
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape import Shape, bounds_of


@settings(max_examples=25)
@given(articulated_shapes())
def test_a_normalised_shape_is_centred_and_has_diagonal_1(shape: Shape) -> None:
    frame = Normalisation.of(shape)
    low, high = bounds_of(map(frame.mesh, shape.meshes()))
    assert low + high == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.linalg.norm(high - low) == pytest.approx(1.0)


@settings(max_examples=25)
@given(articulated_shapes())
def test_normalised_joints_move_points_in_the_same_way(shape: Shape) -> None:
    frame = Normalisation.of(shape)
    normalised = frame.mobility(shape.mobility)
    at_limit = {i: body.joint.upper for i, body in shape.mobility.movable() if body.joint.is_limited}
    normalised_limit = {i: normalised.bodies[i].joint.upper for i in at_limit}
    poses, others = forward(shape.mobility, at_limit), forward(normalised, normalised_limit)
    for pose, other in zip(poses, others, strict=True):
        moved = frame.points(pose[:3, :3] @ shape.center + pose[:3, 3])
        assert other[:3, 3] == pytest.approx(moved, abs=1e-9), "the centre is the origin of the normalised frame"


@settings(max_examples=25)
@given(articulated_shapes())
def test_undoing_the_normalisation_gives_back_the_joints(shape: Shape) -> None:
    frame = Normalisation.of(shape)
    back = frame.undo_mobility(frame.mobility(shape.mobility))
    for body, other in zip(shape.mobility.bodies, back.bodies, strict=True):
        if body.joint is not None:
            assert other.joint.pivot == pytest.approx(body.joint.pivot)
            if body.joint.is_limited:
                assert (other.joint.lower, other.joint.upper) == pytest.approx((body.joint.lower, body.joint.upper))
