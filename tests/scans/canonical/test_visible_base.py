"""Choice of a base where the file's base is too small to be seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import directions, shape_of_boxes, vectors
from hypothesis import given, settings
from hypothesis import strategies as st
from scanned_objects import FRONT, hinge, slider

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Shape
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.canonical.visible_base import relative_joint, with_visible_base

SAME = np.eye(3)
ends = st.floats(-1.0, 1.0)


def scissors(pin: float = 0.02, tip: float = 1.0) -> Shape:
    """Two bars that cross over a pin and turn about it, each opened by a quarter of a radian."""
    boxes = [
        ((-pin, -pin, -pin), (pin, pin, pin)),
        ((-0.3, -1.0, 0.0), (0.0, tip, 0.05)),
        ((0.0, -1.0, -0.05), (0.3, 1.0, 0.0)),
        ((0.28, -1.0, -0.05), (0.3, -0.98, 0.0)),
    ]
    legs = (Joint(JointKind.REVOLUTE, sign * FRONT, np.zeros(3), 0.0, 0.5, 0.25) for sign in (1.0, -1.0))
    left, right = (Body(i, "leg", (i + 1,), 0, joint) for i, joint in enumerate(legs, 1))
    knob = Body(3, "knob", (4,), 2, hinge((0.29, -0.99, 0.0), FRONT))
    return shape_of_boxes(boxes, [Body(0, "pin", (1,)), left, right, knob])


def test_one_leg_of_scissors_moves_against_the_other_with_combined_limits() -> None:
    found = articulated_object(scissors())
    assert str(found.structure) == "2 parts (R on 0)"
    (joint,) = found.joints
    assert joint.lower is not None
    assert joint.upper is not None
    assert joint.upper - joint.lower == pytest.approx(1.0)
    assert joint.rest == joint.lower, "closed"
    assert found.part_extents.centers[0, 0] < found.part_extents.centers[1, 0], "the left one is the base"
    np.testing.assert_allclose(abs(joint.direction @ FRONT), 1.0)


@pytest.mark.parametrize("legs", [2, 3])
@pytest.mark.parametrize("limits", [(0.0, 0.5), (None, None)])
def test_the_left_of_equal_legs_is_the_base_also_when_mirrored(legs: int, limits: tuple[float | None, float | None]) -> None:
    places = [-0.3, 0.3, 0.0][:legs]
    boxes = [((-0.02, -0.02, -0.02), (0.02, 0.02, 0.02)), *(((x - 0.1, -1.0, 0.0), (x + 0.1, 1.0, 0.05)) for x in places)]
    joint = Joint(JointKind.REVOLUTE, FRONT, np.zeros(3), *limits)
    bodies = [Body(0, "pin", (1,)), *(Body(i, "leg", (i + 1,), 0, joint) for i in range(1, legs + 1))]
    shape = shape_of_boxes(boxes, bodies)
    as_it_is, mirrored = (articulated_object(shape, variant_matrix=change) for change in (None, np.diag([-1.0, 1.0, 1.0])))
    assert mirrored.structure == as_it_is.structure
    assert str(mirrored.structure) == f"{legs} parts ({', '.join(['R on 0'] * (legs - 1))})"
    for found in (as_it_is, mirrored):
        assert found.part_extents.centers[0, 0] < found.part_extents.centers[1:, 0].min()
        assert 1 in found.mobility.bodies[0].leaves, "the pin is joined to the base"
        np.testing.assert_allclose([joint.direction for joint in found.joints], [as_it_is.joints[0].direction] * (legs - 1))
    assert [joint.lower for joint in mirrored.joints] == pytest.approx([joint.lower for joint in as_it_is.joints])


def test_a_base_that_is_large_enough_stays() -> None:
    assert str(articulated_object(scissors(pin=0.4)).structure) == "3 parts (R on 0, R on 0)"
    assert str(articulated_object(scissors(), min_part_size=0.0).structure) == "4 parts (R on 0, R on 0, R on 1)"


def test_the_larger_part_is_the_base() -> None:
    found = articulated_object(scissors(tip=-0.2))
    assert found.part_extents.diagonals[0] > found.part_extents.diagonals[1]


def test_a_part_without_a_base_moves_against_its_sibling() -> None:
    shape = scissors()
    assert shape.mobility is not None
    bodies = [
        Body(body.id, body.name, body.leaves if body.id else (), body.parent, body.joint) for body in shape.mobility.bodies
    ]
    assert str(articulated_object(replace(shape, mobility=Mobility(tuple(bodies)))).structure) == "2 parts (R on 0)"
    keeps_small = articulated_object(replace(shape, mobility=Mobility(tuple(bodies))), min_part_size=0.0)
    assert str(keeps_small.structure) == "3 parts (R on 0, R on 1)", "the knob is a part, the empty base is none"


def test_a_single_part_needs_a_base() -> None:
    shape = scissors()
    assert shape.mobility is not None
    pin, left, *_ = shape.mobility.bodies
    nothing = Body(0, "pin", (), None, None)
    alone = articulated_object(replace(shape, mobility=Mobility((pin, left))))
    assert str(alone.structure) == "2 parts (R on 0)", "as in the file"
    with pytest.raises(InputError, match="nothing stands still"):
        articulated_object(replace(shape, mobility=Mobility((nothing, left))))


def chained(first: int) -> Mobility:
    """Scissors as a chain: one leg hangs from the pin, the other from that leg."""
    shape = scissors()
    assert shape.mobility is not None
    pin, left, right, knob = shape.mobility.bodies
    one, other = (left, right) if first == 1 else (right, left)
    assert one.joint is not None
    assert other.joint is not None
    bodies = [
        pin,
        replace(one, id=1, parent=0),
        replace(other, id=2, parent=1, joint=relative_joint(other.joint, one.joint)),
        replace(knob, parent=1 if one is right else 2),
    ]
    return Mobility(tuple(bodies))


@pytest.mark.parametrize("first", [1, 2])
def test_scissors_as_a_chain_are_the_same_object(first: int) -> None:
    star, chain = articulated_object(scissors()), articulated_object(replace(scissors(), mobility=chained(first)))
    assert chain.structure == star.structure
    for one, other in zip(star.meshes, chain.meshes, strict=True):
        np.testing.assert_allclose(one.vertices.min(axis=0), other.vertices.min(axis=0), atol=1e-9)
        np.testing.assert_allclose(one.vertices.max(axis=0), other.vertices.max(axis=0), atol=1e-9)
    for value in (0.0, 0.3, 1.0):
        poses = []
        for found in (star, chain):
            (joint,) = found.joints
            assert joint.lower is not None
            poses.append(forward(found.mobility, {1: joint.lower + value}))
        np.testing.assert_allclose(poses[0], poses[1], atol=1e-9)


def test_the_only_child_of_a_pin_becomes_the_base() -> None:
    labelled = chained(1)
    mobility, meshes, base_joint = with_visible_base(labelled, tuple(scissors().meshes()), 0.2, SAME)
    assert [body.parent for body in mobility.bodies] == [None, 0, 1]
    assert len(meshes) == 3
    assert base_joint is labelled.bodies[1].joint


@st.composite
def pairs_of_joints(draw: st.DrawFn) -> tuple[Joint, Joint]:
    """Two hinges about one axis, or two sliders along one line, with independent signs."""
    kind = draw(st.sampled_from([JointKind.REVOLUTE, JointKind.PRISMATIC]))
    direction, pivot = draw(directions), draw(vectors)
    found = []
    for sign in (1.0, draw(st.sampled_from([1.0, -1.0]))):
        lower = draw(ends)
        upper = lower + draw(st.floats(0.0, 1.0))
        place = pivot + draw(ends) * direction
        found.append(Joint(kind, sign * direction, place, lower, upper, lower + draw(st.floats(0.0, 1.0)) * (upper - lower)))
    return found[0], found[1]


@settings(max_examples=60)
@given(pairs_of_joints(), ends, ends)
def test_a_relative_joint_gives_the_same_motion(joints: tuple[Joint, Joint], first: float, second: float) -> None:
    base, moving = joints
    both = Mobility((Body(0, "pin", (), None), Body(1, "a", (1,), 0, base), Body(2, "b", (2,), 0, moving)))
    own = relative_joint(moving, base)
    alone = Mobility((Body(0, "a", (1,), None), Body(1, "b", (2,), 0, own)))
    poses = forward(both, {1: first, 2: second})
    sign = np.sign(base.direction @ moving.direction)
    found = forward(alone, {1: second - sign * first})
    np.testing.assert_allclose(found[1], np.linalg.inv(poses[1]) @ poses[2], atol=1e-9)
    values = {(a, b): b - sign * a for a in (base.lower, base.upper) for b in (moving.lower, moving.upper)}
    np.testing.assert_allclose([own.lower, own.upper], [min(values.values()), max(values.values())], atol=1e-12)
    assert own.lower - 1e-12 <= own.rest <= own.upper + 1e-12


def test_a_joint_about_another_axis_stays() -> None:
    mine = hinge((0.0, 0.0, 0.0))
    for other in (hinge((0.1, 0.0, 0.0)), hinge((0.0, 0.0, 0.0), FRONT), slider(FRONT)):
        assert relative_joint(mine, other) is mine


def test_grandchildren_keep_their_parents() -> None:
    shape = scissors()
    assert shape.mobility is not None
    mobility, meshes, _ = with_visible_base(shape.mobility, tuple(shape.meshes()), 0.2, SAME)
    names = [body.name for body in mobility.bodies]
    assert names == ["leg", "leg", "knob"]
    knob = mobility.bodies[2]
    assert mobility.bodies[knob.parent or 0].leaves in ((3,), (1, 3))
    assert len(meshes[0].vertices) == 16, "pin and base are one mesh"
