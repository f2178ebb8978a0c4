"""Objects like a known one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from articulated import shape_of_boxes
from kinmo.core.joint import JointKind
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Body
from kinmo.scans.articulated_object import articulated_object
from kinmo.scans.object_variants import changed, draw_change
from scanned import FRONT, UP, cupboard, cupboard_object, hinge

TARGET = cupboard_object()
MIRROR = np.diag([-1.0, 1.0, 1.0])
"""Left for right, where y is up and +z the front."""


def changes(stretch: float = 1.5) -> st.SearchStrategy[np.ndarray]:
    return st.integers(0, 1000).map(lambda seed: draw_change(UP, stretch, np.random.default_rng(seed)))


def test_a_mirrored_object_moves_as_the_object_in_the_mirror() -> None:
    mobility, meshes = changed(TARGET.mobility, TARGET.meshes, MIRROR)
    values = {1: 0.3, 2: 0.7, 3: 0.4, 4: 0.1}
    screw = next(index for index, body in TARGET.mobility.movable() if body.joint and body.joint.kind is JointKind.SCREW)
    here = forward(TARGET.mobility, values, {screw: 0.5})
    there = forward(mobility, values, {screw: -0.5})
    for before, after, one, other in zip(here, there, TARGET.meshes, meshes, strict=True):
        expected = (one.vertices @ before[:3, :3].T + before[:3, 3]) @ MIRROR
        np.testing.assert_allclose(other.vertices @ after[:3, :3].T + after[:3, 3], expected, atol=1e-9)


@given(changes())
def test_what_lies_on_an_axis_or_inside_stays_there(change) -> None:
    mobility, meshes = changed(TARGET.mobility, TARGET.meshes, change)
    for body, before in zip(mobility.bodies, TARGET.mobility.bodies, strict=True):
        if body.joint is None or before.joint is None:
            continue
        assert np.linalg.norm(body.joint.direction) == pytest.approx(1.0)
        along = change @ (before.joint.pivot + 0.3 * before.joint.direction) - body.joint.pivot
        np.testing.assert_allclose(np.cross(along, body.joint.direction), 0.0, atol=1e-9)
    for mesh, before in zip(meshes, TARGET.meshes, strict=True):
        corners, old = mesh.vertices[mesh.faces], before.vertices[before.faces]
        expected = np.linalg.det(old).sum() * abs(np.linalg.det(change))
        assert np.linalg.det(corners).sum() == pytest.approx(expected)


@given(changes(1.25))
def test_a_change_stretches_the_object_along_its_own_directions_and_no_more_than_it_may(change) -> None:
    assert (np.abs(change) > 1e-12).sum() == 3
    lengths = np.abs(change.diagonal())
    assert (lengths <= 1.25 + 1e-9).all()
    assert (lengths >= 0.8 - 1e-9).all()
    assert change[1, 1] > 0 < change[2, 2]  # up stays up, and the front in front


def test_both_hands_occur() -> None:
    rng = np.random.default_rng(0)
    assert {np.sign(np.linalg.det(draw_change(UP, 1.2, rng))) for _ in range(20)} == {-1.0, 1.0}


def test_a_drawer_slides_as_much_farther_as_it_is_deeper_and_a_door_opens_as_wide() -> None:
    mobility, _ = changed(TARGET.mobility, TARGET.meshes, np.diag([1.0, 1.0, 2.0]))
    for body, before in zip(mobility.bodies, TARGET.mobility.bodies, strict=True):
        if body.joint is not None and before.joint is not None:
            factor = 2.0 if body.joint.kind is JointKind.PRISMATIC else 1.0
            assert body.joint.upper == pytest.approx(factor * before.joint.upper)


def test_the_parts_of_a_variant_are_in_the_order_of_all_objects_and_its_box_is_as_of_all() -> None:
    boxes = [((-1.0, 0.0, -1.0), (1.0, 2.0, 1.0)), ((-1.0, 0.0, 1.0), (-0.4, 2.0, 1.1)), ((-0.4, 0.0, 1.0), (1.0, 2.0, 1.1))]
    doors = [hinge((-1.0, 0.0, 1.0), -UP), hinge((1.0, 0.0, 1.0))]
    shape = shape_of_boxes(boxes, [Body(0, "carcass", (1,)), *(Body(i, "door", (i + 1,), 0, doors[i - 1]) for i in (1, 2))])
    as_it_is, mirrored = (articulated_object(shape, change=change) for change in (None, MIRROR))
    assert mirrored.structure == as_it_is.structure
    for target in (as_it_is, mirrored):
        assert target.part_extents.centers[1, 0] < target.part_extents.centers[2, 0]
        vertices = np.concatenate([mesh.vertices for mesh in target.meshes])
        assert np.linalg.norm(np.ptp(vertices, axis=0)) == pytest.approx(1.0)
    narrow = [target.part_extents.sizes[1:, 0].argmin() for target in (as_it_is, mirrored)]
    assert narrow == [0, 1]


def test_a_hinge_without_limits_has_its_usual_direction_in_the_mirror_too() -> None:
    shape = cupboard()
    assert shape.mobility is not None
    bodies = list(shape.mobility.bodies)
    endless = replace(hinge((0.875, 1.45, 1.0), FRONT), lower=None, upper=None)
    bodies[3] = replace(bodies[3], joint=endless)
    shape = replace(shape, mobility=replace(shape.mobility, bodies=tuple(bodies)))
    for change in (None, MIRROR):
        (knob,) = (j for j in articulated_object(shape, smallest=0.0, change=change).joints if not j.is_limited)
        np.testing.assert_allclose(knob.direction, FRONT, atol=1e-12)
