"""Penetration of swept parts: motions with room and motions that collide."""

import math
from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.evaluation.penetration import PenetrationMeter

FRONT = np.array([0.0, 0, 1])


def penetrations(shape):
    """Penetration of every movable body of a shape."""
    meshes = list(shape.meshes())
    core = _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])
    return PenetrationMeter(core, shape.leaves).measure(shape.mobility)


def penetration(joint, boxes=(((0, 0, 0), (1, 1, 0.5)), ((0, 0, 0.5), (1, 1, 0.6)))):
    """Penetration of a panel in front of a block; `joint` moves the panel."""
    shape = shape_of_boxes(boxes, (Body(0, "body", (1,)), Body(1, "panel", (2,), 0, joint)))
    return penetrations(shape).get(1)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_drawer_is_free_outwards_and_collides_inwards(sign):
    slide = Joint(JointKind.PRISMATIC, sign * FRONT, np.zeros(3))
    out = replace(slide, lower=min(0.0, 0.4 * sign), upper=max(0.0, 0.4 * sign))
    assert penetration(out) == 0.0
    assert penetration(replace(out, lower=-out.upper, upper=-out.lower)) > 0.3


def test_a_door_that_opens_to_the_wrong_side_collides():
    door = Joint(JointKind.REVOLUTE, np.array([0.0, 1, 0]), np.array([0.0, 0, 0.6]), -1.5, 0.0)
    assert penetration(door) == 0.0
    assert penetration(replace(door, lower=0.0, upper=1.5)) > 0.3
    assert penetration(replace(door, lower=None, upper=None)) > 0.3


def test_the_range_is_relative_to_the_pose_of_the_file():
    slide = Joint(JointKind.PRISMATIC, FRONT, np.zeros(3), 0.0, 0.4)
    assert penetration(replace(slide, lower=0.3, upper=0.7, rest=0.3)) == penetration(slide)


def test_a_slider_without_limits_has_no_penetration():
    assert penetration(Joint(JointKind.PRISMATIC, FRONT, np.zeros(3))) is None


def test_a_part_takes_its_descendants_along():
    boxes = (((0, 0, 0), (1, 1, 0.5)), ((0, 0, 0.5), (1, 1, 0.6)), ((0.4, 0.4, 0.6), (0.6, 0.6, 0.7)))
    slide = Joint(JointKind.PRISMATIC, FRONT, np.zeros(3), 0.0, 0.4)
    knob = Joint(JointKind.REVOLUTE, FRONT, np.array([0.5, 0.5, 0]), 0.0, math.pi)
    bodies = (Body(0, "body", (1,)), Body(1, "drawer", (2,), 0, slide), Body(2, "knob", (3,), 1, knob))
    shape = shape_of_boxes(boxes, bodies)
    assert penetrations(shape)[1] == 0.0
