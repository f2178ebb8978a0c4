"""Closed pose of objects with known limits, whatever their files show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from scanned_objects import RIGHT, UP, hinge, slider

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Body
from kinmo.core.shape import Mesh, Shape
from kinmo.scans.canonical.articulated_object import articulated_object


def cabinet(knob: Joint | None = None) -> Shape:
    """A closed cabinet with a door, hinged on the left, above a drawer."""
    boxes = [((-1.0, 0.0, -1.0), (1.0, 2.0, 1.0)), ((-1.0, 1.0, 1.0), (1.0, 2.0, 1.1)), ((-0.9, 0.1, -0.9), (0.9, 0.9, 1.1))]
    door = hinge((-1.0, 0.0, 1.0), -UP, 0.0, 1.5)
    bodies = [Body(0, "carcass", (1,)), Body(1, "door", (2,), 0, knob or door), Body(2, "drawer", (3,), 0, slider(upper=1.0))]
    return shape_of_boxes(boxes, bodies)


def cabinet_with_a_flap() -> Shape:
    """The cabinet with a flap in its door that opens outwards about its upper edge."""
    plain = cabinet()
    assert plain.mobility is not None
    flap = Body(3, "flap", (4,), 1, hinge((0.0, 1.6, 1.1), -RIGHT, 0.0, 1.0))
    low_high = [(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for mesh in plain.meshes()]
    boxes = [*((tuple(low), tuple(high)) for low, high in low_high), ((-0.5, 1.2, 1.1), (0.5, 1.6, 1.15))]
    return shape_of_boxes(boxes, [*plain.mobility.bodies, flap])


def opened(shape: Shape, values: dict[int, float], reverse: tuple[int, ...] = ()) -> Shape:
    """The object as another file may show it: joints at `values`, and some joint directions reversed."""
    assert shape.mobility is not None
    poses = forward(shape.mobility, values)
    bodies = []
    for index, body in enumerate(shape.mobility.bodies):
        joint = body.joint
        if joint is not None and body.parent is not None:
            above = poses[body.parent]
            pivot = above[:3, :3] @ joint.pivot + above[:3, 3]
            joint = replace(joint, direction=above[:3, :3] @ joint.direction, pivot=pivot, rest=values.get(index, joint.rest))
            joint = joint.reversed() if index in reverse else joint
        bodies.append(replace(body, joint=joint))
    owner = {leaf: index for index, body in enumerate(shape.mobility.bodies) for leaf in body.leaves}
    parts = list(shape.parts)
    for leaf, mesh in zip(shape.leaves, shape.meshes(), strict=True):
        pose = poses[owner[leaf]]
        parts[leaf] = replace(parts[leaf], mesh=Mesh(mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces))
    return replace(shape, parts=tuple(parts), mobility=replace(shape.mobility, bodies=tuple(bodies)))


@pytest.mark.parametrize("reverse", [(), (1,), (1, 2)])
@pytest.mark.parametrize(
    ("shape", "values"),
    [
        (cabinet(), {}),
        (cabinet(), {1: 1.2}),
        (cabinet(), {1: 0.4, 2: 0.7}),
        (cabinet_with_a_flap(), {1: 1.2}),
        (cabinet_with_a_flap(), {1: 0.9, 2: 0.7, 3: 0.8}),
    ],
)
def test_the_closed_pose_does_not_depend_on_the_pose_in_the_file(shape, values, reverse):
    expected, found = articulated_object(shape), articulated_object(opened(shape, values, reverse))
    for one, other in zip(found.meshes, expected.meshes, strict=True):
        np.testing.assert_allclose(one.vertices, other.vertices, atol=1e-9)
    for one, other in zip(found.joints, expected.joints, strict=True):
        np.testing.assert_allclose(one.direction, other.direction, atol=1e-9)
        assert (one.lower, one.upper, one.rest) == pytest.approx((other.lower, other.upper, other.rest), abs=1e-9)
        assert one.rest == one.lower
        if one.has_pivot:
            off = one.pivot - other.pivot
            np.testing.assert_allclose(off - off @ one.direction * one.direction, 0.0, atol=1e-9)


STACKED = [
    ((-1.0, 0.0, -1.0), (1.0, 2.0, 1.0)),
    ((-1.0, 1.0, 1.0), (1.0, 2.0, 1.1)),
    ((-1.0, 0.0, 1.0), (1.0, 1.0, 1.1)),
]


@pytest.mark.parametrize("values", [(1.0, 1.0), (1.0, 0.9), (0.9, 0.9), (0.6, 0.6)])
@pytest.mark.parametrize("joint", [hinge((-1.0, 0.0, 1.0), -UP, 0.0, 1.5), slider(upper=1.0)])
def test_equal_doors_close_although_the_other_one_is_open(joint, values):
    bodies = [Body(0, "body", (1,)), *(Body(index, "front", (index + 1,), 0, joint) for index in (1, 2))]
    shape = shape_of_boxes(STACKED, bodies)
    shown = opened(shape, {index + 1: share * joint.upper for index, share in enumerate(values)})
    expected, found = articulated_object(shape), articulated_object(shown)
    for one, other in zip(found.meshes, expected.meshes, strict=True):
        np.testing.assert_allclose(one.vertices, other.vertices, atol=1e-9)


def spout(joint: Joint) -> Shape:
    """A tap with a spout that moves equally far to both sides."""
    boxes = [((-0.5, 0.0, -0.5), (0.5, 0.2, 0.5)), ((-0.1, 0.2, -0.1), (0.1, 0.4, 1.0))]
    return shape_of_boxes(boxes, [Body(0, "foot", (1,)), Body(1, "spout", (2,), 0, joint)])


@pytest.mark.parametrize("joint", [hinge((0.0, 0.0, 0.0), UP, -1.2, 1.2), replace(slider(RIGHT), lower=-0.3, upper=0.3)])
def test_a_symmetric_joint_rests_midway_and_keeps_its_direction_when_mirrored(joint):
    mirror = np.diag([-1.0, 1.0, 1.0])
    for target in (
        articulated_object(spout(joint)),
        articulated_object(spout(joint.reversed())),
        articulated_object(spout(joint), variant_matrix=mirror),
    ):
        (found,) = target.joints
        np.testing.assert_allclose(found.direction, joint.direction, atol=1e-12)
        assert found.rest - found.lower == pytest.approx(found.upper - found.rest)
        assert target.meshes[1].vertices.mean(axis=0)[0] == pytest.approx(0.0, abs=1e-9), "it points to the front"


def test_an_object_that_is_not_closed_keeps_the_pose_of_the_file():
    shape = opened(cabinet(), {1: 1.2})
    shown = articulated_object(shape, closes=False)
    assert shown.joints[1].rest == pytest.approx(1.2)
    assert np.ptp(shown.meshes[2].vertices[:, 2]) > 0.2, "the door stands open"


def test_a_joint_without_limits_stays_and_points_up():
    for sign in (1.0, -1.0):
        free = Joint(JointKind.REVOLUTE, sign * UP, np.zeros(3))
        target = articulated_object(cabinet(free))
        turning = next(joint for joint in target.joints if joint.kind is JointKind.REVOLUTE)
        np.testing.assert_allclose(turning.direction, UP)
        assert turning.rest == 0.0


@pytest.mark.parametrize("shown", [0.0, -1.2, 0.7])
@pytest.mark.parametrize("reverse", [(), (1,)])
@pytest.mark.parametrize(("lower", "upper"), [(-1.5, 1.5), (-0.8, 1.5)])
def test_a_swing_door_is_closed_between_its_ends(lower, upper, shown, reverse):
    boxes = [((-1.1, 0.0, -0.1), (-1.0, 2.0, 0.1)), ((-1.0, 0.0, -0.02), (1.0, 2.0, 0.02)), ((1.0, 0.0, -0.1), (1.1, 2.0, 0.1))]
    bodies = [Body(0, "frame", (1, 3)), Body(1, "leaf", (2,), 0, hinge((-1.0, 0.0, 0.0), -UP, lower, upper))]
    shape = shape_of_boxes(boxes, bodies)
    found = articulated_object(opened(shape, {1: max(shown, lower)}, reverse))
    low, high = found.meshes[1].vertices.min(axis=0), found.meshes[1].vertices.max(axis=0)
    assert np.ptp([low, high], axis=0)[2] < 0.021, "the leaf is in its frame"
    (joint,) = found.joints
    ends = sorted([upper - 0.0, 0.0 - lower])
    assert (joint.rest - joint.lower, joint.upper - joint.rest) == pytest.approx(ends, abs=1e-5), "it opens to the farther end"
