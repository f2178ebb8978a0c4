"""Preparation of shapes: samples, boxes, distances, labels, and the normalised frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from datasets import BOXES, mobility, write_partnet_mobility
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.errors import InputError
from kinmo.core.motion_types import MotionType
from kinmo.core.normalisation import Normalisation, geometry_hash
from kinmo.core.shape import Mesh
from kinmo.features.prepared_shape import check_unchanged
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.readers import read_partnet_mobility


@pytest.fixture(scope="module")
def shape(tmp_path_factory):
    return read_partnet_mobility(write_partnet_mobility(tmp_path_factory.mktemp("prepare") / "4711"))


@pytest.fixture(scope="module")
def prepared(shape):
    return prepare_shape(shape, points=256)


def test_a_shape_with_other_parts_or_another_position_has_changed_since_preparation(shape, prepared):
    check_unchanged(shape, prepared)
    others = [moved(shape, 1.0, 0.01), moved(shape, 1.01, 0.0), replace(shape, parts=shape.parts[:-1])]
    for other in others:
        with pytest.raises(InputError, match="has changed since it was prepared: run kinmo prepare again"):
            check_unchanged(other, prepared)


def moved(shape, scale, shift):
    """A copy of a shape at another position and size."""
    meshes = [None if part.mesh is None else Mesh(part.mesh.vertices * scale + shift, part.mesh.faces) for part in shape.parts]
    parts = tuple(replace(part, mesh=mesh) for part, mesh in zip(shape.parts, meshes, strict=True))
    return replace(shape, parts=parts)


def test_the_normalised_frame_is_centred_and_has_the_diagonal_as_unit(shape, prepared):
    low, high = shape.bounds
    points = prepared.leaf_points.reshape(-1, 3) * prepared.diagonal + prepared.center
    assert np.all(points >= low - 1e-6) and np.all(points <= high + 1e-6)
    np.testing.assert_allclose(prepared.diagonal, np.linalg.norm(high - low))
    np.testing.assert_allclose(prepared.center, 0.5 * (low + high))


def test_the_arrays_have_matching_sizes(prepared):
    leaves, parts, edges = 5, 8, 10
    assert prepared.leaf_points.shape == prepared.leaf_normals.shape == (leaves, 256, 3)
    assert prepared.leaf_areas.shape == (leaves,)
    assert len(prepared.minimum_boxes) == len(prepared.symmetric_boxes) == len(prepared.aligned_boxes) == parts
    assert prepared.edges.shape == (edges, 2), "three pairs below the root, one each below frame and door, in both directions"
    assert prepared.edge_distances.shape == (edges,)
    assert prepared.edge_labels.types.shape == (edges,)


def test_samples_lie_on_their_leaves(prepared):
    low, high = map(np.array, BOXES["original-6"])
    points = prepared.leaf_points[4] * prepared.diagonal + prepared.center
    to_side = np.minimum(np.abs(points - low), np.abs(points - high)).min(axis=1)
    np.testing.assert_allclose(to_side, 0.0, atol=1e-6)


def test_aligned_boxes_enclose_all_leaves_of_a_part(prepared):
    box = prepared.aligned_boxes[7]
    low, high = map(np.array, BOXES["original-6"])
    np.testing.assert_allclose(box.center * prepared.diagonal + prepared.center, 0.5 * (low + high), atol=1e-12)
    np.testing.assert_allclose(
        np.abs(box.corners()).max(axis=0), np.abs(prepared.aligned_boxes[0].corners()).max(axis=0), atol=1
    )
    np.testing.assert_allclose(prepared.aligned_boxes[0].center, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(2 * prepared.aligned_boxes[0].half_extents), 1.0)


def test_distances_are_exact_and_symmetric(prepared):
    distance = {tuple(edge): d for edge, d in zip(prepared.edges.tolist(), prepared.edge_distances.tolist(), strict=True)}
    assert all(d == distance[j, i] for (i, j), d in distance.items())
    assert distance[4, 7] * prepared.diagonal == pytest.approx(np.hypot(0.02, 0.0), abs=1e-9), (
        "the drawer ends 2 cm below the door"
    )


def test_edge_labels_are_the_motions_of_the_parts(prepared):
    label = {
        tuple(edge): MotionType(t) for edge, t in zip(prepared.edges.tolist(), prepared.edge_labels.types.tolist(), strict=True)
    }
    assert label[4, 1] is MotionType.R_V_S
    assert label[7, 1] is MotionType.P_H
    assert label[1, 4] is label[4, 7] is MotionType.NONE
    assert label[5, 6] is label[2, 3] is MotionType.FIXED


def test_limits_and_pivots_are_normalised_and_can_be_restored(shape, prepared):
    drawer = prepared.mobility.bodies[2].joint
    assert drawer.upper == pytest.approx(0.6 / shape.diagonal)
    door = prepared.mobility.bodies[1].joint
    assert door.upper == pytest.approx(np.pi / 2)
    back = Normalisation.of(shape).undo_mobility(prepared.mobility)
    for ours, theirs in zip(back.bodies, shape.mobility.bodies, strict=True):
        if theirs.joint is not None:
            np.testing.assert_allclose(ours.joint.pivot, theirs.joint.pivot)
            assert ours.joint.upper == pytest.approx(theirs.joint.upper)


@settings(max_examples=10)
@given(st.floats(1e-3, 1e3), st.tuples(*[st.floats(-10, 10)] * 3))
def test_position_and_size_of_the_file_do_not_matter(shape, prepared, scale, shift):
    other = prepare_shape(moved(shape, scale, np.array(shift)), points=16)
    np.testing.assert_allclose(other.aligned_boxes.centers, prepared.aligned_boxes.centers, atol=1e-6)
    np.testing.assert_allclose(other.edge_distances, prepared.edge_distances, atol=1e-6)
    np.testing.assert_allclose(other.leaf_areas, prepared.leaf_areas, rtol=1e-6)


def test_samples_depend_on_the_seed_but_not_on_the_id(shape, prepared):
    again = prepare_shape(shape, points=256)
    np.testing.assert_array_equal(again.leaf_points, prepared.leaf_points)
    assert not np.array_equal(prepare_shape(shape, points=256, seed=1).leaf_points, prepared.leaf_points)
    np.testing.assert_array_equal(prepare_shape(replace(shape, id="other"), points=256).leaf_points, prepared.leaf_points)


def test_a_shape_without_mobility_has_no_labels(shape):
    prepared = prepare_shape(replace(shape, mobility=None), points=16)
    assert prepared.mobility is prepared.body_boxes is prepared.edge_labels is None
    assert prepared.body_types == {}


def test_a_single_part_has_no_edges(shape):
    leaf = replace(shape.parts[7], parent=None)
    prepared = prepare_shape(replace(shape, parts=(leaf,), mobility=None), points=16)
    assert prepared.edges.shape == (0, 2)
    assert prepared.edge_distances.shape == (0,)


def test_a_screw_joint_becomes_a_screw_label(tmp_path):
    bodies = mobility()
    bodies[2]["jointData"]["limit"]["rotates"] = True
    prepared = prepare_shape(read_partnet_mobility(write_partnet_mobility(tmp_path / "1", bodies)), points=16)
    assert MotionType.PR_H in prepared.edge_labels.types


def test_copies_with_another_order_or_segmentation_have_the_same_geometry_hash(shape):
    frame = Normalisation.of(shape)
    meshes = [frame.mesh(mesh) for mesh in shape.meshes()]
    reversed_ = [Mesh(mesh.vertices[::-1], len(mesh.vertices) - 1 - mesh.faces[::-1]) for mesh in meshes[::-1]]
    halves = [Mesh(mesh.vertices, faces) for mesh in meshes for faces in (mesh.faces[:4], mesh.faces[4:])]
    assert geometry_hash(meshes) == geometry_hash(reversed_) == geometry_hash(halves)
    changed = [Mesh(meshes[0].vertices + np.array([0, 1e-3, 0]), meshes[0].faces), *meshes[1:]]
    assert geometry_hash(meshes) != geometry_hash(changed)
