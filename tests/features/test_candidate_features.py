"""Candidate joints of parts, and their features."""

from __future__ import annotations

import numpy as np
from cabinet_geometry import DOOR, DRAWER, FRAME, KNOB, UP, cabinet_geometry
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo.core.joint import JointKind
from kinmo.features.candidate_features import CandidateFeatures, compute_candidate_features, with_groups

GROUPS = [(FRAME,), (DOOR,), (KNOB,), (DRAWER,), (DOOR, KNOB)]
FEATURES = compute_candidate_features(cabinet_geometry(), GROUPS)
REVOLUTE = JointKind.REVOLUTE.code


@settings(max_examples=15)
@given(st.floats(-np.pi, np.pi), st.integers(0, 100), st.booleans())
def test_features_do_not_change_when_the_object_turns(angle: float, seed: int, freely: bool) -> None:
    turn = Rotation.random(rng=np.random.default_rng(seed)) if freely else Rotation.from_rotvec(angle * UP)
    turned = compute_candidate_features(cabinet_geometry(turn.as_matrix()), GROUPS)
    np.testing.assert_allclose(turned.group_features, FEATURES.group_features, atol=5e-3)
    np.testing.assert_allclose(turned.centers, FEATURES.centers @ turn.as_matrix().T, atol=1e-5)
    assert np.median(feature_changes(turned, turn.as_matrix())) < 0.02


def feature_changes(turned: CandidateFeatures, turn: np.ndarray) -> list[float]:
    """Largest change of the features of every candidate when the cabinet turns.

    Among lines within the tolerance of merging, another line may be kept: some candidates then have no counterpart.
    """
    changes = []
    for group in range(len(GROUPS)):
        ours, theirs = FEATURES.rows(group), turned.rows(group)
        directions, pivots = FEATURES.directions[ours] @ turn.T, FEATURES.pivots[ours] @ turn.T
        candidates = zip(FEATURES.kinds[ours], directions, pivots, FEATURES.features[ours], strict=True)
        for kind, direction, pivot, features in candidates:
            same = (turned.kinds[theirs] == kind) & (np.abs(turned.directions[theirs] @ direction) > 1 - 1e-5)
            same &= np.linalg.norm(turned.pivots[theirs] - pivot, axis=1) < 5e-3
            changes.append(np.abs(turned.features[theirs][same] - features).max(axis=1).min() if same.any() else np.inf)
    return changes


def candidate_near(kind: JointKind, group: int, direction: tuple[float, ...], point: tuple[float, ...]) -> int:
    """Row, within the group, of the candidate nearest to an axis."""
    rows = FEATURES.rows(group)
    offset = np.array(point) - FEATURES.pivots[rows]
    distances = np.linalg.norm(np.cross(offset, FEATURES.directions[rows]), axis=1)
    parallel = np.abs(FEATURES.directions[rows] @ np.array(direction)) > 0.99
    return int(np.argmin(np.where(parallel & (FEATURES.kinds[rows] == kind.code), distances, np.inf)))


def test_the_true_joints_are_among_the_candidates() -> None:
    hinge = FEATURES.rows(1).start + candidate_near(JointKind.REVOLUTE, 1, (0, 1, 0), (-0.23, 0, 0.15))
    assert np.linalg.norm(FEATURES.pivots[hinge][[0, 2]] - [-0.23, 0.15]) < 0.03
    slide = FEATURES.rows(3).start + candidate_near(JointKind.PRISMATIC, 3, (0, 0, 1), (0, 0, 0))
    assert abs(FEATURES.directions[slide][2]) > 0.99


def test_features_are_restored_from_their_arrays() -> None:
    restored = CandidateFeatures.of(FEATURES.arrays())
    np.testing.assert_array_equal(restored.features, FEATURES.features)
    np.testing.assert_array_equal(restored.offsets, FEATURES.offsets)
    np.testing.assert_allclose(restored.directions, FEATURES.directions, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(restored.directions, axis=1), 1.0)


def test_rows_of_the_groups_follow_each_other() -> None:
    counts = FEATURES.counts(range(len(FEATURES)))
    assert [FEATURES.rows(group).stop - FEATURES.rows(group).start for group in range(len(FEATURES))] == counts
    assert sum(counts) == len(FEATURES.features) == len(FEATURES.kinds)


def test_features_are_finite_even_for_a_part_without_surroundings() -> None:
    alone = compute_candidate_features(cabinet_geometry(), [(FRAME, DOOR, KNOB, DRAWER)])
    for found in (FEATURES, alone):
        assert np.isfinite(found.features).all()
        assert np.isfinite(found.group_features).all()
    assert FEATURES.features.shape[1] == alone.features.shape[1]


def test_features_of_parts_do_not_depend_on_the_bodies() -> None:
    leaves = [(FRAME,), (DOOR,), (KNOB,), (DRAWER,)]
    bare = compute_candidate_features(cabinet_geometry(), leaves)
    annotated = compute_candidate_features(cabinet_geometry(), [*leaves, (DOOR, KNOB), (FRAME, DRAWER)])
    np.testing.assert_array_equal(annotated.group_features[: len(leaves)], bare.group_features)
    np.testing.assert_array_equal(annotated.features[: len(bare.features)], bare.features)


def test_features_of_some_groups_join_to_those_of_all() -> None:
    first, second = (compute_candidate_features(cabinet_geometry(), groups) for groups in (GROUPS[:2], GROUPS[2:]))
    joined = first.joined(second)
    for name, values in FEATURES.arrays().items():
        np.testing.assert_array_equal(joined.arrays()[name], values)
    assert joined.group_of == {group: row for row, group in enumerate(GROUPS)}


def test_groups_that_are_known_are_not_computed_again() -> None:
    known = CandidateFeatures.of(compute_candidate_features(cabinet_geometry(), GROUPS[:3]).arrays())
    assert with_groups(known, cabinet_geometry(), GROUPS[:2]) is known
    assert with_groups(None, cabinet_geometry(), []) is None
    more = with_groups(known, cabinet_geometry(), [GROUPS[4], GROUPS[0], GROUPS[4]])
    assert more is not None and list(more.group_of) == [*GROUPS[:3], GROUPS[4]]
    np.testing.assert_array_equal(more.group_features[3], FEATURES.group_features[4])


def test_a_left_hinge_differs_from_a_right_hinge() -> None:
    """Only the features of the left and right side change when the cabinet is mirrored."""
    mirrored = compute_candidate_features(cabinet_geometry(np.diag([-1.0, 1.0, 1.0])), GROUPS)
    left, right = ((x, 0.0, 0.15) for x in (-0.23, 0.23))
    here = FEATURES.features[FEATURES.rows(1)][candidate_near(JointKind.REVOLUTE, 1, (0, 1, 0), left)]
    there = FEATURES.features[FEATURES.rows(1)][candidate_near(JointKind.REVOLUTE, 1, (0, 1, 0), right)]
    assert np.abs(here - there).max() > 0.5
    rows = mirrored.rows(1)
    distances = np.linalg.norm((mirrored.pivots[rows] - right)[:, [0, 2]], axis=1)
    upright = (np.abs(mirrored.directions[rows][:, 1]) > 0.99) & (mirrored.kinds[rows] == REVOLUTE)
    same_door = mirrored.features[rows][np.argmin(np.where(upright, distances, np.inf))]
    differing = np.flatnonzero(np.abs(same_door - here) > 0.05)
    np.testing.assert_allclose(same_door[differing], -here[differing], atol=0.05)
    assert len(differing) == 2
