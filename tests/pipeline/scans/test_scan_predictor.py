"""The predictor for scans that come one after another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scanned_workspace import CPU, FAMILY, Scanned
from trained_workspace import Recorder

from kinmo.pipeline.scans.predict_scans import PredictScans
from kinmo.pipeline.scans.scan_predictor import ScanPredictor
from kinmo.scans.files.scan_file import open_scans


@pytest.fixture
def points(scanned: Scanned) -> NDArray[np.float64]:
    """One test scan."""
    return open_scans(next(scanned.scans("test"))).read("points", 0)


@pytest.fixture
def predictor(scanned: Scanned) -> ScanPredictor:
    return ScanPredictor.load(scanned.workspace.path, FAMILY, device="cpu")


def test_the_predictor_and_the_command_give_the_same_result(
    predictor: ScanPredictor, points: NDArray[np.float64], scanned: Scanned, tmp_path: Path
) -> None:
    np.savez(tmp_path / "seen.npz", points=points)
    data = PredictScans(tmp_path / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **CPU).run(Recorder()).data
    found = predictor.predict(points)
    assert (predictor.weights, predictor.trained, predictor.category) == (data["weights"], data["trained"], data["category"])
    assert [int((found.parts == part["id"]).sum()) for part in data["parts"]] == [part["points"] for part in data["parts"]]
    states = [np.nan if joint["state"] is None else joint["state"] for joint in data["joints"]]
    np.testing.assert_array_equal(found.estimate.states, states)


def test_arrays_that_are_no_scan_are_refused(predictor: ScanPredictor, points: NDArray[np.float64]) -> None:
    one_and_many = np.vstack([np.ones((10**5, 3)), points[:1]])
    for wrong in (points[:, :2], points[:0], np.full((40, 3), np.nan), -points, np.ones((40, 3)), one_and_many):
        with pytest.raises(ValueError, match=r"expected points \[n, 3\]"):
            predictor.predict(wrong)


def test_the_order_of_points_does_not_matter(predictor: ScanPredictor, points: NDArray[np.float64]) -> None:
    order = np.random.default_rng(0).permutation(len(points))
    found, shuffled = predictor.predict(points), predictor.predict(points[order])
    np.testing.assert_array_equal(shuffled.parts, found.parts[order])
    np.testing.assert_array_equal(shuffled.estimate.poses.rotations, found.estimate.poses.rotations)
    np.testing.assert_array_equal(shuffled.estimate.states, found.estimate.states)


def test_an_outlier_belongs_to_no_part_and_changes_nothing(predictor: ScanPredictor, points: NDArray[np.float64]) -> None:
    outlier = points.mean(axis=0) + [0.0, 0.0, 50.0]
    alone, together = predictor.predict(points), predictor.predict(np.vstack([points, outlier]))
    np.testing.assert_array_equal(together.is_outlier, [False] * len(points) + [True])
    np.testing.assert_array_equal(together.parts, [*alone.parts, -1])
    np.testing.assert_array_equal(together.estimate.poses.rotations, alone.estimate.poses.rotations)
    np.testing.assert_array_equal(together.estimate.states, alone.estimate.states)


def test_repeated_points_count_once(predictor: ScanPredictor, points: NDArray[np.float64]) -> None:
    nothing = np.tile([0.0, 0.0, 10.0], (10**5, 1))  # some cameras write this for missing depths
    once, often = (predictor.predict(np.vstack([points, nothing[:count]])) for count in (1, len(nothing)))
    np.testing.assert_array_equal(often.parts[: len(points)], once.parts[:-1])
    np.testing.assert_array_equal(often.estimate.poses.rotations, once.estimate.poses.rotations)
    np.testing.assert_array_equal(often.is_outlier, [False] * len(points) + [True] * len(nothing))
