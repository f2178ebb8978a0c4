"""Canonical pose: closed objects that open to the front."""

from __future__ import annotations

import math

import numpy as np
import pytest
from articulated import shape_of_boxes
from scanned_objects import FRONT, UP

from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import rotation_about
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Shape
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.canonical.canonical_pose import open_to_the_front

LEAF, FRAME = ((-0.5, 0.0, -0.02), (0.45, 2.0, 0.02)), ((-0.5, 2.0, -0.1), (0.5, 2.1, 0.1))


def door(way: float, hinged_at: float = -0.5) -> Shape:
    """A door in a frame, the same from both sides, that opens to the front (1) or to the back (-1)."""
    turn = way * np.sign(hinged_at) * UP
    joint = Joint(JointKind.REVOLUTE, turn, np.array([hinged_at, 0.0, 0.0]), 0.0, 1.5)
    return shape_of_boxes([FRAME, LEAF], [Body(0, "frame", (1,)), Body(1, "leaf", (2,), 0, joint)])


@pytest.mark.parametrize("hinged_at", [-0.5, 0.45])
def test_a_door_opens_to_the_front_whatever_its_file_shows(hinged_at: float) -> None:
    front, back = (articulated_object(door(way, hinged_at)) for way in (1.0, -1.0))
    for found in (front, back):
        (joint,) = found.joints
        middle = found.part_extents.centers[1]
        opened = rotation_about(joint, 0.5)[:3, :3] @ (middle - joint.pivot) - (middle - joint.pivot)
        assert opened @ FRONT > 0.0
    np.testing.assert_allclose(front.joints[0].pivot[0], -back.joints[0].pivot[0], atol=1e-9)
    as_in_file = articulated_object(door(-1.0), closes=False)
    np.testing.assert_allclose(as_in_file.joints[0].direction, door(-1.0).mobility.bodies[1].joint.direction)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "joint",
    [
        Joint(JointKind.PRISMATIC, UP - 0.5 * FRONT, np.zeros(3), 0.0, 1.0),
        Joint(JointKind.PRISMATIC, np.array([1.0, 0.0, 0.0]), np.zeros(3), 0.0, 1.0),
        Joint(JointKind.REVOLUTE, -UP, np.array([-0.5, 0.0, 0.0])),
    ],
)
def test_an_object_that_does_not_open_to_the_back_stays(joint: Joint) -> None:
    mobility = Mobility((Body(0, "frame", (1,)), Body(1, "leaf", (2,), 0, joint)))
    meshes = tuple(door(1.0).meshes())
    assert open_to_the_front(mobility, meshes, z_up_rotation(UP)) == (mobility, meshes)


def test_a_door_with_two_leaves_that_open_to_both_sides_stays() -> None:
    leaves = [
        Body(i, "leaf", (i + 1,), 0, Joint(JointKind.REVOLUTE, way * UP, np.array([-0.5, 0.0, 0.0]), 0.0, math.pi / 2))
        for i, way in ((1, 1.0), (2, -1.0))
    ]
    shape = shape_of_boxes([FRAME, LEAF, LEAF], [Body(0, "frame", (1,)), *leaves])
    assert shape.mobility is not None
    assert open_to_the_front(shape.mobility, tuple(shape.meshes()), z_up_rotation(UP))[0] is shape.mobility
