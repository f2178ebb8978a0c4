"""Poses of parts from pairs of points, alone and tied to each other by joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from kinmo import _core

F64 = NDArray[np.float64]
THRESHOLD = 0.1


@dataclass(frozen=True, eq=False)
class Problem:
    """A tree of parts in a camera's frame: pairs of points, joints, and the true poses."""

    source: F64
    target: F64
    offsets: NDArray[np.int64]
    pairs: NDArray[np.uint32]
    kinds: NDArray[np.uint8]
    directions: F64
    rotations: F64
    scales: F64
    translations: F64

    @property
    def points(self) -> tuple[F64, F64, NDArray[np.int64]]:
        return self.source, self.target, self.offsets

    @property
    def ties(self) -> tuple[NDArray[np.uint32], NDArray[np.uint8], F64]:
        return self.pairs, self.kinds, self.directions


def problem(seed: int, parts: int = 3, count: int = 200, noise: float = 0.0, wrong: float = 0.0) -> Problem:
    """Parts that hang on earlier ones by revolute and prismatic joints."""
    rng = np.random.default_rng(seed)
    base, first = Rotation.random(random_state=rng), rng.uniform(-0.3, 0.3, 3) + [0, 0, 2]
    turns, shifts = [base], [first]
    pairs, kinds, directions = [], [], []
    for part in range(1, parts):
        parent, kind, axis = int(rng.integers(part)), int(rng.integers(2)), rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        turn = turns[parent] * Rotation.from_rotvec(axis * rng.uniform(-1.5, 1.5)) if kind == 0 else turns[parent]
        turns.append(turn)
        shifts.append(shifts[parent] + rng.uniform(-0.3, 0.3, 3))
        pairs.append((parent, part))
        kinds.append(kind)
        directions.append(axis)
    scales = rng.uniform(0.3, 1.0, parts)
    source = rng.uniform(-0.5, 0.5, (parts, count, 3))
    target = np.stack([s * turn.apply(p) + t for s, turn, t, p in zip(scales, turns, shifts, source, strict=True)])
    target += rng.normal(scale=noise, size=target.shape) if noise else 0.0
    lost = rng.random((parts, count)) < wrong
    target[lost] = rng.uniform(-1.0, 1.0, (int(lost.sum()), 3)) + first
    return Problem(
        source.reshape(-1, 3),
        target.reshape(-1, 3),
        np.arange(parts + 1, dtype=np.int64) * count,
        np.array(pairs, np.uint32).reshape(-1, 2),
        np.array(kinds, np.uint8),
        np.array(directions).reshape(-1, 3),
        np.stack([turn.as_matrix() for turn in turns]),
        scales,
        np.stack(shifts),
    )


def degrees_off(found: F64, true: F64) -> F64:
    turn = Rotation.from_matrix(found) * Rotation.from_matrix(true).inv()
    return np.degrees(turn.magnitude())


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_pairs_without_noise_give_the_poses_back(seed: int, parts: int) -> None:
    given_ = problem(seed, parts)
    (rotations, scales, translations), inliers = _core.find_similarities(
        *given_.points, hypotheses=200, threshold=THRESHOLD, seed=1
    )
    assert inliers.all()
    np.testing.assert_allclose(rotations, given_.rotations, atol=1e-9)
    np.testing.assert_allclose(scales, given_.scales, rtol=1e-9)
    np.testing.assert_allclose(translations, given_.translations, atol=1e-9)
    tied = _core.fit_constrained_poses(
        *given_.points, *given_.ties, rotations, scales, translations, frames=np.array([0, parts]), threshold=THRESHOLD
    )
    np.testing.assert_allclose(tied[0], given_.rotations, atol=1e-6)
    np.testing.assert_allclose(tied[2], given_.translations, atol=1e-6)


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_two_wrong_pairs_of_five_leave_the_poses_near_the_truth_and_joints_alike_in_both_parts(seed: int) -> None:
    given_ = problem(seed, 3, 300, noise=0.01, wrong=0.4)
    (rotations, scales, translations), _ = _core.find_similarities(*given_.points, hypotheses=2000, threshold=THRESHOLD, seed=1)
    assert degrees_off(rotations, given_.rotations).max() < 5.0
    frames = np.array([0, 3])
    tied = _core.fit_constrained_poses(
        *given_.points, *given_.ties, rotations, scales, translations, frames=frames, threshold=THRESHOLD
    )
    assert degrees_off(tied[0], given_.rotations).max() < 5.0
    for row, (first, second) in enumerate(given_.pairs):
        seen = tied[0][[first, second]] @ given_.directions[row]
        before = rotations[[first, second]] @ given_.directions[row]
        assert np.linalg.norm(seen[0] - seen[1]) < 0.2 * np.linalg.norm(before[0] - before[1]) + 1e-3


def similarities(source: F64, target: F64) -> tuple[F64, F64, F64]:
    """Turns, scales and shifts that fit pairs [..., n, 3] best (Umeyama 1991)."""
    middles = source.mean(-2), target.mean(-2)
    a, b = source - middles[0][..., None, :], target - middles[1][..., None, :]
    u, _, v_t = np.linalg.svd(np.swapaxes(b, -1, -2) @ a)
    u[..., 2] *= np.sign(np.linalg.det(u @ v_t))[..., None]
    turns = u @ v_t
    scales = np.sum((b @ turns) * a, axis=(-1, -2)) / np.sum(a * a, axis=(-1, -2))
    return turns, scales, middles[1] - scales[..., None] * np.einsum("...ij,...j->...i", turns, middles[0])


def searched_by_numpy(source: F64, target: F64, hypotheses: int, seed: int) -> tuple[F64, F64, F64]:
    """The similarity of three random pairs that most pairs agree with, fitted anew to these."""
    drawn = np.random.default_rng(seed).integers(0, len(source), (hypotheses, 3))
    turns, scales, shifts = similarities(source[drawn], target[drawn])
    moved = scales[:, None, None] * (source @ np.swapaxes(turns, -1, -2)) + shifts[:, None]
    near = np.linalg.norm(moved - target, axis=-1) < THRESHOLD
    best = near[near.sum(axis=1).argmax()]
    return similarities(source[best], target[best])


def test_with_noise_and_two_wrong_pairs_of_five_poses_are_no_worse_than_by_numpys_search() -> None:
    errors: dict[str, list[tuple[float, float, float]]] = {"core": [], "NumPy": []}
    for seed in range(40):
        given_ = problem(seed, 2, 200, noise=0.03, wrong=0.4)
        found, _ = _core.find_similarities(*given_.points, hypotheses=500, threshold=THRESHOLD, seed=seed)
        pairs = zip(given_.source.reshape(2, -1, 3), given_.target.reshape(2, -1, 3), strict=True)
        peer = tuple(map(np.stack, zip(*(searched_by_numpy(a, b, 500, seed) for a, b in pairs), strict=True)))
        for name, (turns, scales, shifts) in (("core", found), ("NumPy", peer)):
            away = np.linalg.norm(shifts - given_.translations, axis=-1)
            errors[name] += zip(degrees_off(turns, given_.rotations), abs(scales / given_.scales - 1.0), away, strict=True)
    core, peer = (np.percentile(values, [50, 95], axis=0) for values in errors.values())
    assert (core <= peer).all(), (core, peer)


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_constrained_poses_leave_no_more_residual_than_scipys_least_squares(seed: int) -> None:
    """The residuals of reference code: points about their middles, and the joint's direction once a point."""
    given_ = problem(seed, 2, 40, noise=0.02)
    frames = np.array([0, 2])
    found = _core.fit_constrained_poses(
        *given_.points,
        *given_.ties,
        given_.rotations,
        given_.scales,
        given_.translations,
        frames=frames,
        threshold=10.0,
    )
    clouds = [
        (s * (a - a.mean(0)), b - b.mean(0))
        for s, a, b in zip(given_.scales, given_.source.reshape(2, -1, 3), given_.target.reshape(2, -1, 3), strict=True)
    ]

    def residuals(vectors: F64) -> F64:
        turns = Rotation.from_rotvec(vectors.reshape(2, 3))
        own = [(turn.apply(a) - b).ravel() for turn, (a, b) in zip(turns, clouds, strict=True)]
        matrices = turns.as_matrix()
        shared = given_.directions[0] if given_.kinds[0] == 0 else np.sqrt(0.5) * np.eye(3)
        tie = np.sqrt(40.0) * ((matrices[0] - matrices[1]) @ shared.T).ravel()
        return np.concatenate([*own, tie])

    start = Rotation.from_matrix(given_.rotations).as_rotvec().ravel()
    peer = least_squares(residuals, start, method="lm", ftol=1e-12, xtol=1e-12)
    ours = residuals(Rotation.from_matrix(found[0]).as_rotvec().ravel())
    assert np.sum(ours**2) <= 2.0 * peer.cost * (1 + 1e-9) + 1e-12


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_poses_are_also_found_joint_by_joint(seed: int) -> None:
    given_ = problem(seed, 3, 150, wrong=0.2)
    first, second = _core.find_constrained_poses(
        *given_.points, *given_.ties, given_.scales, hypotheses=200, threshold=THRESHOLD, seed=5
    )
    for place, found in enumerate((first, second)):
        parts = given_.pairs[:, place]
        assert degrees_off(found[0], given_.rotations[parts]).max() < 2.0
        np.testing.assert_allclose(found[1], given_.scales[parts])


def test_a_part_finds_the_same_pose_whatever_parts_follow() -> None:
    given_ = problem(3, 3, 100, wrong=0.3)
    options = {"hypotheses": 100, "threshold": THRESHOLD, "seed": 9}
    every, _ = _core.find_similarities(*given_.points, **options)
    alone, _ = _core.find_similarities(given_.source[:100], given_.target[:100], np.array([0, 100]), **options)
    np.testing.assert_array_equal(every[0][0], alone[0][0])


def test_parts_that_nothing_determines_are_nan() -> None:
    line = np.linspace(0, 1, 10)[:, None] * [1.0, 2.0, 3.0]
    (rotations, scales, translations), inliers = _core.find_similarities(
        line, line, np.array([0, 8, 8, 10]), hypotheses=10, threshold=0.1, seed=0
    )
    assert np.isnan(rotations).all()
    assert np.isnan(scales).all()
    assert np.isnan(translations).all()
    assert not inliers.any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"offsets": np.array([0, 5])}, "offsets"),
        ({"offsets": np.array([0, 7, 5, 10])}, "offsets"),
        ({"target": np.zeros((3, 3))}, "target"),
        ({"source": np.full((10, 3), np.nan)}, "source"),
        ({"threshold": 0.0}, "threshold"),
        ({"hypotheses": 0}, "hypotheses"),
    ],
)
def test_bad_arguments_are_refused_by_name(change: dict[str, object], message: str) -> None:
    whole = {"source": np.zeros((10, 3)), "target": np.zeros((10, 3)), "offsets": np.array([0, 10])}
    whole |= {"hypotheses": 5, "threshold": 0.1, "seed": 0} | change
    with pytest.raises(ValueError, match=message):
        _core.find_similarities(**whole)


def test_a_joint_between_two_objects_is_refused() -> None:
    given_ = problem(0, 2, 10)
    poses = given_.rotations, given_.scales, given_.translations
    with pytest.raises(ValueError, match="row 0 ties parts of two frames"):
        _core.fit_constrained_poses(*given_.points, *given_.ties, *poses, frames=np.array([0, 1, 2]), threshold=0.1)


@pytest.mark.parametrize("scale", [1e-13, 1.0, 1e13])
def test_targets_may_be_far_smaller_or_larger_than_sources(scale: float) -> None:
    source = np.random.default_rng(0).normal(size=(40, 3))
    (rotations, scales, _), inliers = _core.find_similarities(
        source, source * scale, np.array([0, 40]), hypotheses=50, threshold=0.01 * scale, seed=0
    )
    np.testing.assert_allclose(rotations, np.eye(3)[None], atol=1e-6)
    np.testing.assert_allclose(scales, scale, rtol=1e-6)
    assert inliers.all()
