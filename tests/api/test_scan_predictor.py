"""Scans by the Python API: parts, joints and joint values in the frame of the points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scanned_workspace import FAMILY, Scanned

import kinmo
from kinmo.scans.files.scan_file import open_scans


@pytest.fixture(scope="module")
def predictor(scanned: Scanned) -> kinmo.ScanPredictor:
    return kinmo.ScanPredictor.load(scanned.workspace.path, FAMILY, device="cpu")


@pytest.fixture(scope="module")
def points(scanned: Scanned) -> np.ndarray:
    """Points of a test scan."""
    return np.asarray(open_scans(next(scanned.scans("test"))).read("points")[0], float)


def test_every_point_has_a_part_and_every_part_a_pose(predictor: kinmo.ScanPredictor, points: np.ndarray) -> None:
    found = predictor.predict(points)
    parts = 1 + len(predictor.structure.kinds)
    assert found.parts.shape == found.is_outlier.shape == (len(points),)
    assert found.parts.min() >= -1 and found.parts.max() < parts
    assert len(found.estimate.states) == len(predictor.structure.kinds)
    assert found.seen.shape == (len(found.seen_parts), 3)


def test_the_order_of_the_points_does_not_matter(predictor: kinmo.ScanPredictor, points: np.ndarray) -> None:
    order = np.random.default_rng(0).permutation(len(points))
    one, other = predictor.predict(points), predictor.predict(points[order])
    np.testing.assert_array_equal(one.parts[order], other.parts)
    np.testing.assert_array_equal(one.estimate.states, other.estimate.states)


@pytest.mark.parametrize(
    ("scan", "message"),
    [
        (np.zeros((0, 3)), "expected points"),
        (np.ones((40, 2)), r"expected points \[n, 3\], got \[40, 2\]"),
        (np.full((40, 3), np.nan), "leave out placeholders"),
        (-np.ones((40, 3)), "leave out placeholders"),
        (np.ones((40, 3)), "positions or more, got 1"),
    ],
)
def test_points_that_are_no_scan_are_refused(scan: np.ndarray, message: str, predictor: kinmo.ScanPredictor) -> None:
    with pytest.raises(ValueError, match=message):
        predictor.predict(scan)


def test_a_category_without_networks_names_the_command_to_run(scanned: Scanned, tmp_path: Path) -> None:
    with pytest.raises(kinmo.InputError, match="no networks for scans of safe"):
        kinmo.ScanPredictor.load(scanned.workspace, "safe")
    with pytest.raises(kinmo.InputError, match=f"run kinmo train all --category {FAMILY} first"):
        kinmo.ScanPredictor.load(tmp_path, FAMILY)
