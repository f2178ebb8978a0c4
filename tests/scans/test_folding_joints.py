"""Where scissors and the like are closed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from articulated import box_mesh, rotations
from hypothesis import given, settings
from hypothesis import strategies as st
from scanned import FRONT, hinge, slider

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import rotation_about
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, join
from kinmo.scans.canonical_pose import likely_canonical
from kinmo.scans.closed_pose import moved_by
from kinmo.scans.folding_joints import fold_of, folded, folds_of, laid_straight
from kinmo.scans.pseudo_label_closed_pose import likely_closed
from kinmo.synth.primitives import extrude

SAME = np.eye(3)
WIDEST = 1.2
AXIS = Joint(JointKind.REVOLUTE, FRONT, np.zeros(3))

openings = st.floats(0.0, 1.0)
middles = st.floats(-0.7, 0.7)
sides = st.sampled_from([1.0, -1.0])


def half(side: float, tail: float, ring: bool) -> Mesh:
    """One half of closed scissors, the screw at the origin and the blade upwards; its shank crosses over to the other side."""
    across, place = np.array([side, 1.0]), (0.0, 0.0, 0.015 * side)
    blade = extrude(np.array([[-0.05, -0.1], [0.0, 1.2], [0.1, 0.8], [0.1, -0.1]]) * across, 0.03, "z", place)
    shank = extrude(np.array([[0.0, 0.0], [-0.2, -tail], [-0.3, -tail], [-0.05, 0.0]]) * across, 0.03, "z", place)
    low, high = ((-0.5, -tail - 0.3, -0.03), (-0.1, -tail, 0.03)) if ring else ((-0.3, -tail, -0.03), (-0.2, -tail, 0.0))
    handle = box_mesh(low, high)
    return join(blade, shank, Mesh(handle.vertices * [side, 1.0, 1.0], handle.faces))


def turned(mesh: Mesh, angle: float) -> Mesh:
    return Mesh(moved_by(rotation_about(AXIS, angle), mesh.vertices), mesh.faces)


def scissors(opening: float, tilt: float, way: float, tail: float = 0.6) -> tuple[Mobility, tuple[Mesh, ...]]:
    """As a file may show them: one half by an unseen pin, the other one by that; limits that mean little."""
    left, right = half(1.0, tail, ring=True), half(-1.0, tail, ring=False)
    joint = replace(AXIS, direction=way * FRONT, lower=-0.1, upper=0.05)
    bodies = Body(0, "pin", (), None), Body(1, "left", (1,), 0, AXIS), Body(2, "right", (2,), 1, joint)
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    return Mobility(bodies), (nothing, turned(left, tilt), turned(right, tilt + opening))


@settings(max_examples=50)
@given(openings, middles, sides, st.floats(0.4, 0.9))
def test_scissors_are_closed_where_their_blades_meet_and_lie_along_an_axis(
    opening: float, middle: float, way: float, tail: float
) -> None:
    shown = scissors(opening, middle - 0.5 * opening, way, tail)
    mobility, meshes = likely_canonical(*shown, 0.15, SAME, WIDEST)
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
        moved_by(rotation_about(joint, angle), mesh.vertices)[np.argmin(mesh.vertices[:, 1])]
        for mesh, angle in ((meshes[0], 0.0), (meshes[1], 0.0), (meshes[1], 0.5))
    ]
    assert abs(handles[2] - handles[0])[0] > abs(handles[1] - handles[0])[0], "they go apart where it opens"


@given(st.floats(-0.7, 0.7), rotations, st.floats(-1.0, 1.0))
def test_a_fold_is_the_same_however_an_object_lies(opening: float, frame: np.ndarray, shift: float) -> None:
    _, (_, left, right) = scissors(opening, 0.0, 1.0)
    seen = fold_of(AXIS, right, left)
    joint = replace(AXIS, direction=frame @ FRONT, pivot=frame @ (shift * FRONT))
    moved = (Mesh(mesh.vertices @ frame.T, mesh.faces) for mesh in (right, left))
    found = fold_of(joint, *moved)
    assert seen is not None
    assert found is not None
    assert (found.closed, found.opens, found.crosses) == (pytest.approx(seen.closed, abs=1e-9), seen.opens, True)
    np.testing.assert_allclose(found.tips, frame @ seen.tips, atol=1e-9)


@given(st.floats(0.1, 1.4), sides)
def test_bars_with_a_pin_at_their_ends_fold_over_each_other_and_do_not_cross(opening: float, way: float) -> None:
    bar = box_mesh((-0.05, -0.05, 0.0), (0.05, 1.0, 0.1))
    fold = fold_of(AXIS, turned(bar, way * opening), bar)
    assert fold is not None
    assert not fold.crosses
    assert fold.closed == pytest.approx(-way * opening, abs=1e-6)
    assert fold.opens == way
    np.testing.assert_allclose(fold.tips, (0.0, 1.0, 0.0), atol=1e-9)


def test_what_no_tip_of_the_other_reaches_does_not_fold() -> None:
    bar = box_mesh((-0.05, 0.0, 0.0), (0.05, 1.0, 0.1))
    stub = box_mesh((-0.05, 0.0, 0.0), (0.05, 0.1, 0.1))
    assert fold_of(AXIS, stub, bar) is None


def test_equal_bars_open_to_where_they_are_free_for_longer() -> None:
    bar = box_mesh((-0.05, -1.0, 0.0), (0.05, 1.0, 0.1))
    fold = fold_of(AXIS, bar, bar)
    assert fold is not None
    assert fold.opens == 0.0
    for lower, upper, ends in ((-0.2, 0.5, (0.0, WIDEST)), (-0.5, 0.2, (-WIDEST, 0.0))):
        joint = folded(replace(AXIS, lower=lower, upper=upper), fold, WIDEST)
        assert (joint.lower, joint.upper) == pytest.approx(ends)
    with pytest.raises(ValueError, match="without limits"):
        folded(AXIS, fold, WIDEST)


def test_only_hinges_with_limits_along_that_of_the_pin_fold_over_the_base() -> None:
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
        assert list(folds_of(two, (left, right), AXIS)) == expected
    assert not folds_of(two, (left, right), slider(FRONT))


@given(openings, sides)
def test_a_half_that_is_fastened_to_the_pin_is_closed_as_well(opening: float, way: float) -> None:
    _, (_, left, right) = scissors(opening, 0.0, way)
    joint = replace(AXIS, direction=way * FRONT, lower=-0.1, upper=0.05)
    mobility = Mobility((Body(0, "left", (1,)), Body(1, "right", (2,), 0, joint)))
    found = likely_closed(mobility, (left, right), WIDEST).bodies[1].joint
    assert found is not None
    assert found.lower is not None
    assert found.upper is not None
    ends = np.array([found.lower, found.upper])
    assert np.abs(ends + way * opening).min() < math.radians(5.0)


@given(st.floats(-0.7, 0.7))
def test_an_object_lies_straight_where_its_tips_lie_along_an_axis(angle: float) -> None:
    axis = replace(AXIS, pivot=np.array([0.3, 0.2, 0.1]))
    pose = rotation_about(axis, angle)
    bar = box_mesh((0.2, -0.8, 0.0), (0.4, 1.4, 0.05))
    shown = Mesh(moved_by(pose, bar.vertices), bar.faces)
    fold = fold_of(axis, shown, shown)
    assert fold is not None
    mobility = Mobility((Body(0, "bar", (1,)),))
    _, (found,) = laid_straight(mobility, (shown,), axis, {1: fold})
    np.testing.assert_allclose(found.vertices, bar.vertices, atol=1e-9)


def test_where_a_fold_is_does_not_hang_on_how_finely_a_mesh_is_cut() -> None:
    _, (_, left, right) = scissors(0.4, 0.0, 1.0)
    seen = fold_of(AXIS, right, left)
    middles, count = right.vertices[right.faces].mean(axis=1), len(right.vertices)
    thirds = [
        np.column_stack([right.faces[:, i], right.faces[:, (i + 1) % 3], count + np.arange(len(middles))]) for i in range(3)
    ]
    finer = Mesh(np.concatenate([right.vertices, middles]), np.concatenate(thirds).astype(np.uint32))
    found = fold_of(AXIS, finer, left)
    assert seen is not None
    assert found is not None
    assert found.closed == pytest.approx(seen.closed, abs=math.radians(0.5))
