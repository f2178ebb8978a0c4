"""Choice of the scans to train on, and of their points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from tiny_ancsh import LIKE_RELEASE, TINY, frame_with_differing_axes

from kinmo.scans.ancsh.scan_batches import ScanData, file_probabilities, min_trusted_share, sample_points
from kinmo.scans.files.scan_file import Role, ScanFile
from kinmo.scans.preprocessing.input_frame import InputFrame


def test_objects_with_true_labels_have_their_least_share() -> None:
    np.testing.assert_allclose(file_probabilities("abcd", [True, False, False, False], 0.5), [1 / 2, 1 / 6, 1 / 6, 1 / 6])
    for trusted in ([True, True, True, False], [True, True], [False, False]):
        np.testing.assert_allclose(file_probabilities(range(len(trusted)), trusted, 0.5), 1 / len(trusted))
    np.testing.assert_allclose(file_probabilities("abcd", [True, False, False, False], 0.0), 1 / 4)


def test_the_probability_of_an_object_does_not_depend_on_its_number_of_files() -> None:
    np.testing.assert_allclose(file_probabilities("aab", [True] * 3, 0.5), [1 / 4, 1 / 4, 1 / 2])
    np.testing.assert_allclose(file_probabilities("aabb", [True, True, False, False], 0.8), [0.4, 0.4, 0.1, 0.1])


@pytest.mark.parametrize(("balance", "shares"), [(0.0, (0.09, 0.9, 0.01)), (0.5, (0.222, 0.703, 0.074)), (1.0, (1 / 3,) * 3)])
def test_balance_draws_more_points_of_small_parts(balance: float, shares: tuple[float, ...]) -> None:
    rng = np.random.default_rng(0)
    parts = rng.permutation(np.repeat([0, 1, -1], [900, 9000, 100]))
    found = [np.bincount(parts[sample_points(parts, 20, balance, rng)] + 1, minlength=3) for _ in range(500)]
    none, first, second = np.sum(found, axis=0) / (20 * 500)
    assert (first, second, none) == pytest.approx(shares, abs=0.02)


@given(st.lists(st.integers(-1, 3), min_size=1, max_size=40), st.integers(1, 60), st.floats(0.0, 1.0), st.integers(0, 99))
def test_points_repeat_only_if_there_are_too_few(parts: list[int], count: int, balance: float, seed: int) -> None:
    found = sample_points(np.array(parts), count, balance, np.random.default_rng(seed))
    assert len(found) == count
    assert set(found) <= set(range(len(parts)))
    assert count > len(parts) or len(set(found)) == count


@pytest.mark.parametrize(("role", "min_share"), [("pseudo", 0.2), ("oracle", 0.2), ("unlabelled", 0.5)])
def test_true_labels_have_a_greater_share_beside_labels_by_networks(file: ScanFile, role: Role, min_share: float) -> None:
    other = replace(file, provenance=replace(file.provenance, role=role))
    assert min_trusted_share([file, other], replace(TINY, trusted=0.2, trusted_self_training=0.5)) == min_share


@pytest.mark.parametrize("points", [32, 128, 256])
def test_the_input_frame_comes_from_all_points_of_a_scan(file: ScanFile, points: int) -> None:
    config = replace(LIKE_RELEASE, points=points)
    batch = ScanData([file], [file], config).batch([(file, row) for row in range(8)], np.random.default_rng(0))
    for row in range(8):
        whole = file.read("points", row)
        seen = InputFrame.of(whole, "object").apply(whole)
        each = np.abs(batch.points[row].numpy()[:, None] - seen[None]).max(axis=-1).min(axis=1)
        np.testing.assert_allclose(each, 0.0, atol=1e-6)


def test_half_of_the_training_scans_have_the_axes_of_the_base(file: ScanFile) -> None:
    row = frame_with_differing_axes(file)
    data = ScanData([file], [file], replace(TINY, points=256))
    rng = np.random.default_rng(0)
    seen = [data.batch([(file, row)], rng).points[0].sort(dim=0).values for _ in range(40)]
    is_equal = np.array([torch.allclose(cloud, seen[0], atol=1e-5) for cloud in seen])
    assert 0.25 < is_equal.mean() < 0.75
    others = [cloud for cloud, equal in zip(seen, is_equal, strict=True) if not equal]
    assert all(torch.allclose(cloud, others[0], atol=1e-5) for cloud in others)
