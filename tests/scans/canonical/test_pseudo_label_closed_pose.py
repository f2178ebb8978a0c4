"""Closed poses of joints with guessed limits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from articulated import box_mesh
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scanned_objects import FRONT, UP, cupboard

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import joint_motion
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, join
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.canonical.hinge_openings import with_sampled_openings
from kinmo.scans.canonical.pseudo_label_closed_pose import MIN_PROTRUSION, estimate_closed_limits

QUARTER = 0.5 * math.pi
BODY = box_mesh((-1.0, 0.0, -1.0), (1.0, 2.0, 0.8))


def door(width: float, handle: float) -> Mesh:
    """A door before the body, hinged at the left, with a handle at its free end."""
    panel = box_mesh((-1.0, 0.0, 0.8), (width - 1.0, 2.0, 0.9))
    return join(panel, box_mesh((width - 1.2, 0.5, 0.9), (width - 1.15, 1.5, 0.9 + handle)))


def hinged(mesh: Mesh, open_by: float, lower: float, upper: float, side: float) -> tuple[Mobility, tuple[Mesh, Mesh]]:
    """A file that shows the door open; the limits count from there, about an axis that points up or down."""
    joint = Joint(JointKind.REVOLUTE, side * UP, np.array([-1.0, 0.0, 0.8]))
    pose = joint_motion(joint, -side * open_by)
    shown = Mesh(mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces)
    ends = (lower, upper) if side < 0 else (-upper, -lower)
    joint = replace(joint, lower=ends[0], upper=ends[1])
    return Mobility((Body(0, "body", (1,)), Body(1, "door", (2,), 0, joint))), (BODY, shown)


def ends_of(mobility: Mobility, side: float) -> tuple[float, float]:
    """Limits of the door; opening is positive."""
    joint = mobility.bodies[1].joint
    assert joint is not None
    assert joint.lower is not None
    assert joint.upper is not None
    return (joint.lower, joint.upper) if side < 0 else (-joint.upper, -joint.lower)


@settings(max_examples=60)
@given(
    st.floats(1.2, 2.0),
    st.floats(0.01, 0.2),
    st.floats(0.0, 1.4),
    st.floats(0.0, QUARTER),
    st.floats(0.6, QUARTER),
    st.sampled_from([1.0, -1.0]),
)
def test_a_door_closes_before_the_body_whatever_its_pose_and_guessed_limits(
    width: float, handle: float, open_by: float, back: float, forth: float, side: float
) -> None:
    assume(back <= open_by + 0.5 or open_by < 0.03)
    mobility, meshes = hinged(door(width, handle), open_by, -back, forth, side)
    lower, upper = ends_of(estimate_closed_limits(mobility, meshes, QUARTER), side)
    assert lower == pytest.approx(-open_by, abs=1e-3)
    assert upper - lower == pytest.approx(min(forth + open_by, QUARTER), abs=2e-3)


def test_a_known_end_beyond_the_guessed_range_stays_known() -> None:
    mobility, meshes = hinged(door(1.9, 0.1), 0.7, -0.7, 1.3, 1.0)
    opened = with_sampled_openings(estimate_closed_limits(mobility, meshes, QUARTER), QUARTER, (0.3,), np.random.default_rng(0))
    lower, upper = ends_of(opened, 1.0)
    assert upper - lower == pytest.approx(QUARTER, abs=1e-3), "not .3, as for hinges without a known end"


@pytest.mark.parametrize("tip", [[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])
def test_a_part_without_an_axis_aligned_pose_keeps_its_limits(tip: list[float]) -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 30, endpoint=False)
    ring = np.stack([np.cos(angles), np.zeros(30), np.sin(angles)], axis=1)
    cone = Mesh(np.concatenate([ring, [tip]]), np.array([[i, (i + 1) % 30, 30] for i in range(30)], np.uint32))
    mobility, (body, _) = hinged(door(1.0, 0.1), 0.0, -0.3, 0.5, 1.0)
    assert estimate_closed_limits(mobility, (body, cone), QUARTER).bodies[1].joint is mobility.bodies[1].joint


def test_hinges_without_limits_and_screws_stay_as_they_are() -> None:
    mobility, meshes = hinged(door(1.0, 0.1), 0.3, -0.3, 0.5, 1.0)
    joint = mobility.bodies[1].joint
    assert joint is not None
    for other in (replace(joint, lower=None, upper=None), replace(joint, kind=JointKind.SCREW)):
        changed = replace(mobility, bodies=(mobility.bodies[0], replace(mobility.bodies[1], joint=other)))
        assert estimate_closed_limits(changed, meshes, QUARTER).bodies[1].joint is other


@given(st.floats(0.0, 0.9), st.floats(0.3, 0.8), st.sampled_from([1.0, -1.0]), st.sampled_from([1.0, -1.0]))
def test_an_open_drawer_closes_where_it_stops_protruding(out: float, width: float, side: float, way: float) -> None:
    assume(abs(out - MIN_PROTRUSION) > 1e-6)
    drawer = box_mesh((-0.5, 0.5, out - 0.2), (0.5, 1.0, out + 0.8))
    ends = sorted((0.0, way * width))
    joint = Joint(JointKind.PRISMATIC, side * FRONT, np.zeros(3), ends[0], ends[1])
    mobility = Mobility((Body(0, "body", (1,)), Body(1, "drawer", (2,), 0, joint)))
    found = estimate_closed_limits(mobility, (BODY, drawer), QUARTER).bodies[1].joint
    assert found is not None
    if out < MIN_PROTRUSION:
        assert found is joint
    else:
        expected = sorted((-side * out, side * (max(width, out) - out)))
        assert (found.lower, found.upper) == pytest.approx(tuple(expected), abs=1e-9)


def test_guessed_limits_do_not_decide_the_closed_pose_of_an_object() -> None:
    shape = cupboard()
    assert shape.mobility is not None
    bodies = list(shape.mobility.bodies)
    place = next(index for index, body in enumerate(bodies) if body.name == "door")
    joint = bodies[place].joint
    assert joint is not None
    bodies[place] = replace(bodies[place], joint=replace(joint, lower=-1.2, upper=1.0))
    found = articulated_object(replace(shape, mobility=Mobility(tuple(bodies))), max_guessed_opening=QUARTER)
    true = articulated_object(shape)
    for mesh, other in zip(found.meshes, true.meshes, strict=True):
        np.testing.assert_allclose(mesh.vertices, other.vertices, atol=1e-6)
