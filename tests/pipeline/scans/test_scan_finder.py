"""Scans that come one after another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scan_road import CATEGORY, FAMILY, HOW, Scanned
from trained_workspace import Recorder

from kinmo.pipeline.scans.predict_scans import PredictScans
from kinmo.pipeline.scans.scan_finder import ScanFinder
from kinmo.scans.files.scan_file import open_scans


def test_a_finder_says_of_points_what_the_command_does(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    np.savez(tmp_path / "seen.npz", points=points)
    said = PredictScans(tmp_path / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **HOW).run(Recorder()).data
    finder = ScanFinder.load(scanned.workspace.root, FAMILY, device="cpu")
    found = finder.find(points)
    assert (finder.weights, finder.trained, finder.category) == (said["weights"], said["trained"], said["category"])
    assert [int((found.parts == part["id"]).sum()) for part in said["parts"]] == [part["points"] for part in said["parts"]]
    states = [np.nan if joint["state"] is None else joint["state"] for joint in said["joints"]]
    np.testing.assert_array_equal(found.estimate.states, states)
    one_and_many = np.vstack([np.ones((10**5, 3)), points[:1]])
    for wrong in (points[:, :2], points[:0], np.full((40, 3), np.nan), -points, np.ones((40, 3)), one_and_many):
        with pytest.raises(ValueError, match=r"expected points \[n, 3\]"):
            finder.find(wrong)


def test_the_order_of_points_is_no_matter(scanned: Scanned) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    order = np.random.default_rng(0).permutation(len(points))
    finder = ScanFinder.load(scanned.workspace.root, FAMILY, device="cpu")
    found, shuffled = finder.find(points), finder.find(points[order])
    np.testing.assert_array_equal(shuffled.parts, found.parts[order])
    np.testing.assert_array_equal(shuffled.estimate.poses.rotations, found.estimate.poses.rotations)
    np.testing.assert_array_equal(shuffled.estimate.states, found.estimate.states)


def test_points_far_from_all_others_are_of_none_and_change_nothing(scanned: Scanned) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    finder = ScanFinder.load(scanned.workspace.root, FAMILY, device="cpu")
    alone, with_stray = finder.find(points), finder.find(np.vstack([points, points.mean(axis=0) + [0.0, 0.0, 50.0]]))
    np.testing.assert_array_equal(with_stray.is_stray, [False] * len(points) + [True])
    np.testing.assert_array_equal(with_stray.parts, [*alone.parts, -1])
    np.testing.assert_array_equal(with_stray.estimate.poses.rotations, alone.estimate.poses.rotations)
    np.testing.assert_array_equal(with_stray.estimate.states, alone.estimate.states)


def test_points_that_are_told_many_times_count_once(scanned: Scanned) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    finder = ScanFinder.load(scanned.workspace.root, FAMILY, device="cpu")
    nothing = np.tile([0.0, 0.0, 10.0], (10**5, 1))  # as some cameras write where nothing is seen
    once, often = (finder.find(np.vstack([points, nothing[:count]])) for count in (1, len(nothing)))
    np.testing.assert_array_equal(often.parts[: len(points)], once.parts[:-1])
    np.testing.assert_array_equal(often.estimate.poses.rotations, once.estimate.poses.rotations)
    np.testing.assert_array_equal(often.is_stray, [False] * len(points) + [True] * len(nothing))
