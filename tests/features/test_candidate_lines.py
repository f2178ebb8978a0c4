"""Candidate axes and the object's own frame."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo.core.box import Box
from kinmo.features.candidate_lines import Source, box_lines, candidate_lines, distinct_directions, merge_lines, object_frame

UP = np.array([0.0, 1.0, 0.0])
angles = st.floats(-np.pi, np.pi)


def cuboid_normals(angle: float) -> tuple[np.ndarray, np.ndarray]:
    turn = Rotation.from_rotvec(angle * UP).as_matrix()
    axes = np.vstack([np.eye(3), -np.eye(3)]) @ turn.T
    return axes, np.array([3.0, 1.0, 2.0, 3.0, 1.0, 2.0])


@given(angles)
def test_the_objects_frame_follows_its_flat_faces(angle: float) -> None:
    normals, weights = cuboid_normals(angle)
    frame = object_frame(normals, weights, UP)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(frame[2], UP)
    np.testing.assert_allclose(np.sort(np.abs(normals[[0, 2]] @ frame[:2].T), axis=1), [[0, 1], [0, 1]], atol=1e-6)


@given(angles, st.integers(0, 1000))
def test_round_surfaces_do_not_pull_the_frame_off_the_flat_ones(angle: float, seed: int) -> None:
    normals, weights = cuboid_normals(angle)
    around = np.random.default_rng(seed).uniform(0, 2 * np.pi, 200)
    round_side = np.column_stack([np.cos(around), np.zeros(200), np.sin(around)])
    frame = object_frame(np.vstack([normals, round_side]), np.concatenate([weights, np.full(200, 0.01)]), UP)
    assert np.abs(normals[0] @ frame[:2].T).max() > np.cos(np.radians(1.0))


def test_a_box_has_twelve_edges_and_three_centre_lines() -> None:
    box = Box(np.array([1.0, 2.0, 3.0]), np.eye(3), np.array([0.5, 0.3, 0.1]))
    directions, pivots, is_edge = box_lines(box)
    assert is_edge.sum() == 12
    assert len(directions) == 15
    corners = box.corners()
    for direction, pivot in zip(directions[is_edge], pivots[is_edge], strict=True):
        offset = corners - pivot
        on_line = np.linalg.norm(offset - np.outer(offset @ direction, direction), axis=1) < 1e-12
        assert on_line.sum() == 2
    np.testing.assert_allclose(pivots[~is_edge], np.tile(box.center, (3, 1)))


@settings(max_examples=50)
@given(st.integers(0, 10_000))
def test_merging_keeps_one_of_equal_lines_and_all_their_sources(seed: int) -> None:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(6, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    pivots = rng.normal(size=(6, 3))
    slid = pivots + rng.normal(size=(6, 1)) * directions
    sources = np.concatenate([np.zeros(6, int), np.full(6, Source.CONTACT_LINE)])
    merged = merge_lines(np.vstack([directions, -directions]), np.vstack([pivots, slid]), sources, np.zeros(3))
    assert len(merged) == 6
    assert merged.sources[:, [0, Source.CONTACT_LINE]].all()
    np.testing.assert_allclose(np.sum(merged.pivots * merged.directions, axis=1), 0.0, atol=1e-9)


def test_two_equal_boxes_add_no_candidates() -> None:
    box = Box(np.zeros(3), np.eye(3), np.array([0.5, 0.3, 0.1]))
    contact = np.array([[0.5, -0.3, 0.1], [0.5, 0.3, 0.1]])
    lines = candidate_lines(box, box, contact, np.ones(2) / 2)
    edges = lines.sources[:, Source.MINIMUM_BOX_EDGE]
    assert edges.sum() == 12
    assert lines.sources[edges][:, Source.ALIGNED_BOX_EDGE].all()
    assert lines.sources[edges][:, Source.CONTACT_LINE].sum() == 1
    assert len(distinct_directions(lines)) == 3
