"""Synthetic objects: other poses and sizes keep the object, and invalid objects are refused."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.synth.primitives import box, move, transform
from kinmo.synth.synth_object import Link, Motion, Node, SynthObject, hinge, slider, spinner


def chain(rest_door: float = 0.0, rest_drawer: float = 0.0) -> SynthObject:
    """A body, a drawer in it, and on the drawer a door with a knob."""
    root = Node("thing")
    body = Link("body", [root.add("body", box((2, 2, 2)))])
    drawer = Link("drawer", [root.add("drawer", box((1, 1, 2)))], body, slider((0, 0, 2), 0, 1.5, rest=rest_drawer))
    door_node = root.add("door", move(box((1, 1, 0.1)), (0, 0, 1)))
    door = Link("door", [door_node], drawer, hinge((0.5, 0, 1), (0, 1, 0), 0, 90, rest=rest_door))
    knob = Link(
        "knob", [root.add("knob", move(box((0.1, 0.1, 0.1)), (-0.4, 0, 1.1)))], door, spinner((-0.4, 0, 1.1), (0, 0, 1))
    )
    return SynthObject("Thing", root, [body, drawer, door, knob])


def motion_of(link: Link) -> Motion:
    assert link.motion is not None
    return link.motion


def test_child_links_move_with_their_parent() -> None:
    closed, opened = chain(), chain(60.0, 0.8)
    opened.apply_rest_pose()
    door, drawer = motion_of(closed.links[2]), motion_of(closed.links[1])
    expected = drawer.at(0.8) @ door.at(60.0)
    knob = transform(closed.links[3].nodes[0].pieces[0], expected)
    np.testing.assert_allclose(opened.links[3].nodes[0].pieces[0].vertices, knob.vertices, atol=1e-12)
    axis = motion_of(opened.links[3])
    np.testing.assert_allclose(axis.direction, expected[:3, :3] @ [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(axis.origin, (expected @ [-0.4, 0, 1.1, 1])[:3], atol=1e-12)


def test_limits_count_from_the_pose_of_the_file() -> None:
    obj = chain(60.0, 0.8)
    obj.apply_rest_pose()
    assert (motion_of(obj.links[2]).a, motion_of(obj.links[2]).b) == (-60.0, 30.0)
    assert motion_of(obj.links[1]).b == pytest.approx(0.7)
    before = obj.links[2].nodes[0].pieces[0].vertices
    obj.apply_rest_pose()
    assert obj.links[2].nodes[0].pieces[0].vertices is before, "a second call changes nothing"


def test_the_lower_limit_closes_the_part() -> None:
    closed, opened = chain(), chain(60.0)
    opened.apply_rest_pose()
    door = motion_of(opened.links[2])
    back = transform(opened.links[2].nodes[0].pieces[0], door.at(door.a))
    np.testing.assert_allclose(back.vertices, closed.links[2].nodes[0].pieces[0].vertices, atol=1e-12)


def test_scaling_scales_lengths_and_not_angles() -> None:
    obj = chain()
    low, high = obj.bounds()
    factor = 2.0 / np.linalg.norm(high - low)
    obj.normalise(2.0, (0.1, 0, 0))
    low, high = obj.bounds()
    assert np.linalg.norm(high - low) == pytest.approx(2.0)
    np.testing.assert_allclose(0.5 * (low + high), [0.1, 0, 0], atol=1e-12)
    assert motion_of(obj.links[1]).b == pytest.approx(1.5 * factor)
    assert motion_of(obj.links[2]).b == 90.0


def test_a_leaf_of_two_links_is_refused() -> None:
    obj = chain()
    obj.links[0].nodes.append(obj.links[1].nodes[0])
    with pytest.raises(ValueError, match="drawer"):
        obj.check()


def test_a_leaf_of_no_link_is_refused() -> None:
    obj = chain()
    obj.root.add("forgotten", box((1, 1, 1)))
    with pytest.raises(ValueError, match="forgotten"):
        obj.check()


def test_a_flat_object_has_its_base_as_the_last_node() -> None:
    base = Link("body", [Node("body", pieces=[box((1, 1, 1))])])
    knob = Link("knob", [Node("knob", pieces=[box((1, 1, 1))])], base, spinner((0, 0, 0), (0, 0, 1)))
    obj = SynthObject.flat("Thing", [base, knob])
    obj.check()
    assert [node.name for node in obj.root.children] == ["knob", "body"]
