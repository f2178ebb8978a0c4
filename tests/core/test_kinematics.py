"""Forward kinematics of joints and mobility trees."""

import math

import numpy as np
import pytest
from articulated import articulated_shapes, joints, rotations, vectors
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import forward, joint_motion
from kinmo.core.mobility import Body, Mobility


def apply(pose, point):
    return pose[:3, :3] @ point + pose[:3, 3]


@given(joints((JointKind.REVOLUTE, JointKind.SCREW)), st.floats(-3, 3), st.floats(-3, 3))
def test_points_of_a_hinge_axis_do_not_move(joint, angle, along):
    point = joint.pivot + along * joint.direction
    moved = apply(joint_motion(joint, angle if joint.kind is JointKind.REVOLUTE else joint.rest, angle), point)
    assert moved == pytest.approx(point, abs=1e-9)


@given(joints(), st.floats(-2, 2), st.floats(-2, 2), vectors)
def test_a_reversed_joint_with_the_opposite_value_moves_the_same(joint, value, screw_angle, point):
    there, back = joint_motion(joint, value, screw_angle), joint_motion(joint.reversed(), -value, -screw_angle)
    assert apply(there, point) == pytest.approx(apply(back, point), abs=1e-12)


@settings(max_examples=25)
@given(articulated_shapes())
def test_without_values_all_bodies_stay_in_the_pose_of_the_file(shape):
    poses = forward(shape.mobility, {})
    assert poses == pytest.approx(np.broadcast_to(np.eye(4), poses.shape), abs=1e-15)


@settings(max_examples=25)
@given(articulated_shapes(), st.data())
def test_a_joint_moves_its_descendants_and_no_other_body(shape, data):
    movable = [index for index, _ in shape.mobility.movable()]
    if not movable:
        return
    index = data.draw(st.sampled_from(movable))
    poses = forward(shape.mobility, {index: shape.mobility.bodies[index].joint.rest + 0.5})
    moved = {i for i, pose in enumerate(poses) if not np.allclose(pose, np.eye(4))}
    assert moved == set(shape.mobility.descendants(index))
    assert all(np.allclose(poses[i], poses[index]) for i in moved)


def test_a_knob_turns_with_its_door():
    door = Joint(JointKind.REVOLUTE, np.array([0.0, 1, 0]), np.zeros(3))
    knob = Joint(JointKind.PRISMATIC, np.array([1.0, 0, 0]), np.zeros(3))
    mobility = Mobility((Body(0, "knob", (1,), 1, knob), Body(1, "door", (2,), 2, door), Body(2, "frame", (3,))))
    poses = forward(mobility, {0: 0.25, 1: math.pi / 2})
    assert apply(poses[0], np.array([1.0, 0, 0])) == pytest.approx([0, 0, -1.25])
    assert poses[2] == pytest.approx(np.eye(4))


@settings(max_examples=25)
@given(articulated_shapes(), rotations, st.floats(-2, 2))
def test_a_rotated_shape_moves_like_the_original(shape, rotation, offset):
    rotated = shape.rotated(rotation)
    values = {index: body.joint.rest + offset for index, body in shape.mobility.movable()}
    before, after = forward(shape.mobility, values), forward(rotated.mobility, values)
    assert rotated.up == pytest.approx(rotation @ shape.up)
    for pose, other, body in zip(before, after, shape.mobility.bodies, strict=True):
        for leaf in body.leaves:
            placed, seen = shape.parts[leaf].mesh.vertices, rotated.parts[leaf].mesh.vertices
            moved = placed @ pose[:3, :3].T + pose[:3, 3]
            assert seen @ other[:3, :3].T + other[:3, 3] == pytest.approx(moved @ rotation.T, abs=1e-9)
