"""Which scans, and which of their points, networks are trained on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from tiny_ancsh import SCAN_ALONE, TINY, turned_apart

from kinmo.scans.ancsh.scan_batches import ScanData, drawn, least_trusted, odds
from kinmo.scans.files.scan_file import Role, ScanFile
from kinmo.scans.preprocessing.input_frame import InputFrame, initial_axes


def test_objects_with_true_labels_have_their_share_of_a_batch() -> None:
    np.testing.assert_allclose(odds("abcd", [True, False, False, False], 0.5), [1 / 2, 1 / 6, 1 / 6, 1 / 6])
    for trusted in ([True, True, True, False], [True, True], [False, False]):
        np.testing.assert_allclose(odds(range(len(trusted)), trusted, 0.5), 1 / len(trusted))
    np.testing.assert_allclose(odds("abcd", [True, False, False, False], 0.0), 1 / 4)


def test_an_object_is_drawn_as_often_in_few_files_as_in_many() -> None:
    np.testing.assert_allclose(odds("aab", [True] * 3, 0.5), [1 / 4, 1 / 4, 1 / 2])
    np.testing.assert_allclose(odds("aabb", [True, True, False, False], 0.8), [0.4, 0.4, 0.1, 0.1])


@pytest.mark.parametrize(("balance", "shares"), [(0.0, (0.09, 0.9, 0.01)), (0.5, (0.222, 0.703, 0.074)), (1.0, (1 / 3,) * 3)])
def test_of_parts_that_scans_show_little_of_more_points_are_drawn(balance: float, shares: tuple[float, ...]) -> None:
    rng = np.random.default_rng(0)
    parts = rng.permutation(np.repeat([0, 1, -1], [900, 9000, 100]))
    found = [np.bincount(parts[drawn(parts, 20, balance, rng)] + 1, minlength=3) for _ in range(500)]
    none, first, second = np.sum(found, axis=0) / (20 * 500)
    assert (first, second, none) == pytest.approx(shares, abs=0.02)


@given(st.lists(st.integers(-1, 3), min_size=1, max_size=40), st.integers(1, 60), st.floats(0.0, 1.0), st.integers(0, 99))
def test_points_are_drawn_once_where_there_are_as_many(parts: list[int], count: int, balance: float, seed: int) -> None:
    found = drawn(np.array(parts), count, balance, np.random.default_rng(seed))
    assert len(found) == count
    assert set(found) <= set(range(len(parts)))
    assert count > len(parts) or len(set(found)) == count


@pytest.mark.parametrize(("beside", "least"), [("pseudo", 0.2), ("hidden", 0.2), ("unlabelled", 0.5)])
def test_what_networks_labelled_themselves_is_trusted_less(file: ScanFile, beside: Role, least: float) -> None:
    other = replace(file, provenance=replace(file.provenance, role=beside))
    assert least_trusted([file, other], replace(TINY, trusted=0.2, trusted_in_semi=0.5)) == least


@pytest.mark.parametrize("points", [32, 128, 256])
def test_few_points_of_a_scan_are_seen_where_and_as_large_as_all_of_them_are(file: ScanFile, points: int) -> None:
    config = replace(SCAN_ALONE, points=points)
    batch = ScanData([file], [file], config).batch([(file, row) for row in range(8)], np.random.default_rng(0))
    for row in range(8):
        whole = file.read("points", row)
        seen = InputFrame.of(whole, "scan").apply(whole)
        each = np.abs(batch.points[row].numpy()[:, None] - seen[None]).max(axis=-1).min(axis=1)
        np.testing.assert_allclose(each, 0.0, atol=1e-6)


def test_half_of_the_scans_to_train_on_are_seen_along_the_axes_of_the_base(file: ScanFile) -> None:
    row = turned_apart(file)
    data = ScanData([file], [file], replace(TINY, axes="base", points=256))
    rng = np.random.default_rng(0)
    seen = [data.batch([(file, row)], rng).points[0].sort(dim=0).values for _ in range(40)]
    likeness = np.array([torch.allclose(cloud, seen[0], atol=1e-5) for cloud in seen])
    assert 0.25 < likeness.mean() < 0.75
    others = [cloud for cloud, alike in zip(seen, likeness, strict=True) if not alike]
    assert all(torch.allclose(cloud, others[0], atol=1e-5) for cloud in others)


def test_networks_that_look_once_see_scans_along_the_axes_of_all_that_is_seen(file: ScanFile) -> None:
    row = turned_apart(file)
    config = replace(SCAN_ALONE, axes="manhattan", points=len(file.read("points", row)))
    batch = ScanData([file], [file], config).batch([(file, row)], np.random.default_rng(0))
    whole = file.read("points", row)
    (first,) = initial_axes(whole[None], "manhattan")
    seen = InputFrame.of(whole, "scan", rotation=first).apply(whole)
    np.testing.assert_allclose(np.sort(batch.points[0].numpy(), axis=0), np.sort(seen, axis=0), atol=1e-5)
