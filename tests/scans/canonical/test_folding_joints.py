"""Closed poses of scissors and other folding objects."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from articulated import box_mesh, rotations
from hypothesis import given, settings
from hypothesis import strategies as st
from scanned_objects import FRONT, hinge, slider

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import rotation_about
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, join
from kinmo.scans.canonical.canonical_pose import to_estimated_canonical_pose
from kinmo.scans.canonical.closed_pose import transform_points
from kinmo.scans.canonical.folding_joints import align_tips, find_folding_joint, find_folding_joints, with_folding_limits
from kinmo.scans.canonical.pseudo_label_closed_pose import estimate_closed_limits
from kinmo.synth.primitives import extrude

SAME = np.eye(3)
WIDEST = 1.2
AXIS = Joint(JointKind.REVOLUTE, FRONT, np.zeros(3))

openings = st.floats(0.0, 1.0)
middles = st.floats(-0.7, 0.7)
signs = st.sampled_from([1.0, -1.0])


def half(side: float, tail: float, ring: bool) -> Mesh:
    """One half of closed scissors: the pin at the origin, the blade above it, the handle below on the other side."""
    across, place = np.array([side, 1.0]), (0.0, 0.0, 0.015 * side)
    blade = extrude(np.array([[-0.05, -0.1], [0.0, 1.2], [0.1, 0.8], [0.1, -0.1]]) * across, 0.03, "z", place)
    shank = extrude(np.array([[0.0, 0.0], [-0.2, -tail], [-0.3, -tail], [-0.05, 0.0]]) * across, 0.03, "z", place)
    low, high = ((-0.5, -tail - 0.3, -0.03), (-0.1, -tail, 0.03)) if ring else ((-0.3, -tail, -0.03), (-0.2, -tail, 0.0))
    handle = box_mesh(low, high)
    return join(blade, shank, Mesh(handle.vertices * [side, 1.0, 1.0], handle.faces))


def turned(mesh: Mesh, angle: float) -> Mesh:
    return Mesh(transform_points(rotation_about(AXIS, angle), mesh.vertices), mesh.faces)


def scissors(opening: float, tilt: float, sign: float, tail: float = 0.6) -> tuple[Mobility, tuple[Mesh, ...]]:
    """Scissors in a file: one half hangs from an invisible pin, the other from that half; the limits are guesses."""
    left, right = half(1.0, tail, ring=True), half(-1.0, tail, ring=False)
    joint = replace(AXIS, direction=sign * FRONT, lower=-0.1, upper=0.05)
    bodies = Body(0, "pin", (), None), Body(1, "left", (1,), 0, AXIS), Body(2, "right", (2,), 1, joint)
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    return Mobility(bodies), (nothing, turned(left, tilt), turned(right, tilt + opening))


@settings(max_examples=50)
@given(openings, middles, signs, st.floats(0.4, 0.9))
def test_scissors_close_where_their_blades_meet_along_an_axis(opening: float, middle: float, sign: float, tail: float) -> None:
    shown = scissors(opening, middle - 0.5 * opening, sign, tail)
    mobility, meshes = to_estimated_canonical_pose(*shown, 0.15, SAME, WIDEST)
    (joint,) = [body.joint for _, body in mobility.movable() if body.joint is not None]
    assert joint.lower is not None
    assert joint.upper is not None
    assert joint.rest == joint.lower, "closed"
    assert joint.upper - joint.lower == pytest.approx(WIDEST)
    assert np.ptp(join(*meshes).vertices[:, 1]) == pytest.approx(1.2 + tail + 0.3, abs=0.02)
    tips = [mesh.vertices[np.argmax(mesh.vertices[:, 1])] for mesh in meshes]
    np.testing.assert_allclose(tips[0][:2], tips[1][:2], atol=0.05)
    np.testing.assert_allclose([tip[0] - joint.pivot[0] for tip in tips], 0.0, atol=0.05)
    handles = [
        transform_points(rotation_about(joint, angle), mesh.vertices)[np.argmin(mesh.vertices[:, 1])]
        for mesh, angle in ((meshes[0], 0.0), (meshes[1], 0.0), (meshes[1], 0.5))
    ]
    assert abs(handles[2] - handles[0])[0] > abs(handles[1] - handles[0])[0], "the handles go apart when the scissors open"


@given(st.floats(-0.7, 0.7), rotations, st.floats(-1.0, 1.0))
def test_a_folding_joint_turns_with_the_object(opening: float, frame: np.ndarray, shift: float) -> None:
    _, (_, left, right) = scissors(opening, 0.0, 1.0)
    seen = find_folding_joint(AXIS, right, left)
    joint = replace(AXIS, direction=frame @ FRONT, pivot=frame @ (shift * FRONT))
    moved = (Mesh(mesh.vertices @ frame.T, mesh.faces) for mesh in (right, left))
    found = find_folding_joint(joint, *moved)
    assert seen is not None
    assert found is not None
    assert (found.closed, found.opens, found.crosses) == (pytest.approx(seen.closed, abs=1e-9), seen.opens, True)
    np.testing.assert_allclose(found.tips, frame @ seen.tips, atol=1e-9)


@given(st.floats(0.1, 1.4), signs)
def test_bars_with_a_pin_at_their_ends_fold_but_do_not_cross(opening: float, sign: float) -> None:
    bar = box_mesh((-0.05, -0.05, 0.0), (0.05, 1.0, 0.1))
    folding = find_folding_joint(AXIS, turned(bar, sign * opening), bar)
    assert folding is not None
    assert not folding.crosses
    assert folding.closed == pytest.approx(-sign * opening, abs=1e-6)
    assert folding.opens == sign
    np.testing.assert_allclose(folding.tips, (0.0, 1.0, 0.0), atol=1e-9)


def test_a_part_with_shorter_tips_does_not_fold() -> None:
    bar = box_mesh((-0.05, 0.0, 0.0), (0.05, 1.0, 0.1))
    stub = box_mesh((-0.05, 0.0, 0.0), (0.05, 0.1, 0.1))
    assert find_folding_joint(AXIS, stub, bar) is None


def test_equal_bars_open_to_their_wider_side() -> None:
    bar = box_mesh((-0.05, -1.0, 0.0), (0.05, 1.0, 0.1))
    folding = find_folding_joint(AXIS, bar, bar)
    assert folding is not None
    assert folding.opens == 0.0
    for lower, upper, ends in ((-0.2, 0.5, (0.0, WIDEST)), (-0.5, 0.2, (-WIDEST, 0.0))):
        joint = with_folding_limits(replace(AXIS, lower=lower, upper=upper), folding, WIDEST)
        assert (joint.lower, joint.upper) == pytest.approx(ends)


def test_only_limited_hinges_parallel_to_the_pin_fold() -> None:
    mobility, (_, left, right) = scissors(0.5, 0.0, 1.0)
    hinged = mobility.bodies[2].joint
    assert hinged is not None
    for joint, expected in (
        (hinged, [1]),
        (replace(hinged, lower=None, upper=None), []),
        (hinge((0.0, 0.0, 0.0)), []),
        (slider(FRONT), []),
    ):
        two = Mobility((Body(0, "left", (1,)), Body(1, "right", (2,), 0, joint)))
        assert list(find_folding_joints(two, (left, right), AXIS)) == expected
    assert not find_folding_joints(two, (left, right), slider(FRONT))


@given(openings, signs)
def test_scissors_with_a_visible_half_as_base_close_too(opening: float, sign: float) -> None:
    _, (_, left, right) = scissors(opening, 0.0, sign)
    joint = replace(AXIS, direction=sign * FRONT, lower=-0.1, upper=0.05)
    mobility = Mobility((Body(0, "left", (1,)), Body(1, "right", (2,), 0, joint)))
    found = estimate_closed_limits(mobility, (left, right), WIDEST).bodies[1].joint
    assert found is not None
    assert found.lower is not None
    assert found.upper is not None
    ends = np.array([found.lower, found.upper])
    assert np.abs(ends + sign * opening).min() < math.radians(5.0)


@given(st.floats(-0.7, 0.7))
def test_a_folding_object_is_turned_until_its_tips_are_axis_aligned(angle: float) -> None:
    axis = replace(AXIS, pivot=np.array([0.3, 0.2, 0.1]))
    pose = rotation_about(axis, angle)
    bar = box_mesh((0.2, -0.8, 0.0), (0.4, 1.4, 0.05))
    shown = Mesh(transform_points(pose, bar.vertices), bar.faces)
    folding = find_folding_joint(axis, shown, shown)
    assert folding is not None
    mobility = Mobility((Body(0, "bar", (1,)),))
    _, (found,) = align_tips(mobility, (shown,), axis, {1: folding})
    np.testing.assert_allclose(found.vertices, bar.vertices, atol=1e-9)


def test_the_closed_pose_does_not_depend_on_the_triangulation() -> None:
    _, (_, left, right) = scissors(0.4, 0.0, 1.0)
    seen = find_folding_joint(AXIS, right, left)
    middles, count = right.vertices[right.faces].mean(axis=1), len(right.vertices)
    thirds = [
        np.column_stack([right.faces[:, i], right.faces[:, (i + 1) % 3], count + np.arange(len(middles))]) for i in range(3)
    ]
    finer = Mesh(np.concatenate([right.vertices, middles]), np.concatenate(thirds).astype(np.uint32))
    found = find_folding_joint(AXIS, finer, left)
    assert seen is not None
    assert found is not None
    assert found.closed == pytest.approx(seen.closed, abs=math.radians(0.5))
