"""Variants of objects: mirrored and stretched."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from hypothesis import given
from hypothesis import strategies as st
from scanned_objects import FRONT, UP, cupboard, cupboard_object, hinge

from kinmo.core.joint import JointKind
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Body
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.canonical.object_variants import apply_variant, sample_variant_matrix

TARGET = cupboard_object()
MIRROR = np.diag([-1.0, 1.0, 1.0])
"""Reflection of left and right, where y is up and +z the front."""


def matrices(stretch: float = 1.5) -> st.SearchStrategy[np.ndarray]:
    return st.integers(0, 1000).map(lambda seed: sample_variant_matrix(UP, stretch, np.random.default_rng(seed)))


def test_a_mirrored_object_moves_like_its_mirror_image() -> None:
    mobility, meshes = apply_variant(TARGET.mobility, TARGET.meshes, MIRROR)
    values = {1: 0.3, 2: 0.7, 3: 0.4, 4: 0.1}
    screw = next(index for index, body in TARGET.mobility.movable() if body.joint and body.joint.kind is JointKind.SCREW)
    here = forward(TARGET.mobility, values, {screw: 0.5})
    there = forward(mobility, values, {screw: -0.5})
    for before, after, one, other in zip(here, there, TARGET.meshes, meshes, strict=True):
        expected = (one.vertices @ before[:3, :3].T + before[:3, 3]) @ MIRROR
        np.testing.assert_allclose(other.vertices @ after[:3, :3].T + after[:3, 3], expected, atol=1e-9)


@given(matrices())
def test_points_on_an_axis_and_volumes_are_mapped_with_the_object(matrix) -> None:
    mobility, meshes = apply_variant(TARGET.mobility, TARGET.meshes, matrix)
    for body, before in zip(mobility.bodies, TARGET.mobility.bodies, strict=True):
        if body.joint is None or before.joint is None:
            continue
        assert np.linalg.norm(body.joint.direction) == pytest.approx(1.0)
        along = matrix @ (before.joint.pivot + 0.3 * before.joint.direction) - body.joint.pivot
        np.testing.assert_allclose(np.cross(along, body.joint.direction), 0.0, atol=1e-9)
    for mesh, before in zip(meshes, TARGET.meshes, strict=True):
        corners, old = mesh.vertices[mesh.faces], before.vertices[before.faces]
        expected = np.linalg.det(old).sum() * abs(np.linalg.det(matrix))
        assert np.linalg.det(corners).sum() == pytest.approx(expected)


@given(matrices(1.25))
def test_an_object_is_stretched_along_its_own_directions_within_bounds(matrix) -> None:
    assert (np.abs(matrix) > 1e-12).sum() == 3
    lengths = np.abs(matrix.diagonal())
    assert (lengths <= 1.25 + 1e-9).all()
    assert (lengths >= 0.8 - 1e-9).all()
    assert matrix[1, 1] > 0 < matrix[2, 2]  # only left and right are mirrored


def test_variants_are_mirrored_and_not_mirrored() -> None:
    rng = np.random.default_rng(0)
    assert {np.sign(np.linalg.det(sample_variant_matrix(UP, 1.2, rng))) for _ in range(20)} == {-1.0, 1.0}


def test_stretching_scales_sliders_and_keeps_angles() -> None:
    mobility, _ = apply_variant(TARGET.mobility, TARGET.meshes, np.diag([1.0, 1.0, 2.0]))
    for body, before in zip(mobility.bodies, TARGET.mobility.bodies, strict=True):
        if body.joint is not None and before.joint is not None:
            factor = 2.0 if body.joint.kind is JointKind.PRISMATIC else 1.0
            assert body.joint.upper == pytest.approx(factor * before.joint.upper)


def test_a_mirrored_object_has_canonical_order_and_size() -> None:
    boxes = [((-1.0, 0.0, -1.0), (1.0, 2.0, 1.0)), ((-1.0, 0.0, 1.0), (-0.4, 2.0, 1.1)), ((-0.4, 0.0, 1.0), (1.0, 2.0, 1.1))]
    doors = [hinge((-1.0, 0.0, 1.0), -UP), hinge((1.0, 0.0, 1.0))]
    shape = shape_of_boxes(boxes, [Body(0, "carcass", (1,)), *(Body(i, "door", (i + 1,), 0, doors[i - 1]) for i in (1, 2))])
    as_it_is, mirrored = (articulated_object(shape, variant_matrix=matrix) for matrix in (None, MIRROR))
    assert mirrored.structure == as_it_is.structure
    for target in (as_it_is, mirrored):
        assert target.part_extents.centers[1, 0] < target.part_extents.centers[2, 0]
        vertices = np.concatenate([mesh.vertices for mesh in target.meshes])
        assert np.linalg.norm(np.ptp(vertices, axis=0)) == pytest.approx(1.0)
    narrow = [target.part_extents.sizes[1:, 0].argmin() for target in (as_it_is, mirrored)]
    assert narrow == [0, 1]


def test_a_hinge_without_limits_keeps_its_direction_when_mirrored() -> None:
    shape = cupboard()
    assert shape.mobility is not None
    bodies = list(shape.mobility.bodies)
    endless = replace(hinge((0.875, 1.45, 1.0), FRONT), lower=None, upper=None)
    bodies[3] = replace(bodies[3], joint=endless)
    shape = replace(shape, mobility=replace(shape.mobility, bodies=tuple(bodies)))
    for matrix in (None, MIRROR):
        (knob,) = (j for j in articulated_object(shape, min_part_size=0.0, variant_matrix=matrix).joints if not j.is_limited)
        np.testing.assert_allclose(knob.direction, FRONT, atol=1e-12)
