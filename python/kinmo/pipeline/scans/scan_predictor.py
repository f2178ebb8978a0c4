"""Trained networks as one object that finds parts, joints and their states in depth scans."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from shlex import quote

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import networks_digest
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.scans.scan_networks import ScanRun, trained_runs, unfinished_runs
from kinmo.pipeline.scans.training_settings import Setting
from kinmo.scans.ancsh.ancsh_predictor import AncshPredictor
from kinmo.scans.files.scan_reader import MIN_POINTS, count_distinct_points
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.scan_estimate import ScanEstimate
from kinmo.scans.preprocessing.outliers import find_outliers

F64 = NDArray[np.float64]

PREFERRED: tuple[Setting, ...] = ("semi-weakly", "self-training", "supervised", "oracle")
"""Settings in the order in which their networks are chosen."""


@dataclass(frozen=True, eq=False)
class ScanPrediction:
    """Parts, joints and states found in a scan of n points.

    Attributes:
        parts: Part [n] of every point, int16: 0 is the base, -1 belongs to no part (the floor, outliers).
        is_outlier: [n], True for points far from all others.
        estimate: Poses and boxes of the parts, joints and their states, in the frame and units of the scan.
        seen: The points [m, 3] that the networks saw.
        seen_parts: Part [m] of these points; every other point has the part of the nearest one.
    """

    parts: NDArray[np.int16]
    is_outlier: NDArray[np.bool_]
    estimate: ScanEstimate
    seen: F64
    seen_parts: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ScanPredictor:
    """Finds objects of one category in depth scans, one scan at a time.

    Attributes:
        network: The networks.
        category: The category that they were trained for.
        trained: The labels and the seed that they were trained with, in words.
        weights: Hash of the networks.

    Example:
        >>> predictor = kinmo.ScanPredictor.load("workspace", "refrigerator")
        >>> prediction = predictor.predict(points)  # [n, 3], in the camera's frame
        >>> prediction.estimate.states  # joint values: radians for hinges, lengths for sliders
    """

    network: AncshPredictor
    category: str
    trained: str
    weights: str

    @classmethod
    def load(
        cls, workspace: Workspace | Path | str, category: str, *, method: str | None = None, seed: int = 0, device: str = "auto"
    ) -> ScanPredictor:
        """Load the networks of a category.

        Args:
            workspace: The workspace, or its folder.
            category: The category, in any spelling.
            method: Only networks that learned from pseudo labels of this method; None for the best ones.
            seed: Seed of the training, if there are several.
            device: Where networks run.

        Returns:
            The predictor.

        Raises:
            InputError: There are no such networks, or they cannot be read.
        """
        place = workspace if isinstance(workspace, Workspace) else Workspace(workspace)
        run = choose_run(place, category, method, seed)
        weights = run.weights(place)
        assert weights is not None, "choose_run returns trained runs"
        return cls(AncshPredictor.load(*weights, device=device), run.category, str(run), networks_digest(weights))

    @property
    def structure(self) -> Structure:
        """Parts and joints of the objects that the networks know."""
        return self.network.structure

    def predict(self, points: NDArray[np.floating], *, seed: int = 0) -> ScanPrediction:
        """Find the parts and joints of the object that a scan shows.

        The result depends on the positions of the points, not on their order, and on `seed`.

        Args:
            points: Points [n, 3] in the camera's frame: x to the right, y down, z forward. Placeholders for missing depths,
                such as (0, 0, 0), must be left out.
            seed: Seed for the choice of the points that the networks see.

        Returns:
            The prediction, in the frame and units of the points.

        Raises:
            ValueError: The array has another shape, is empty, holds values that are not finite, points behind the camera
                (z <= 0), or fewer than 32 different positions.
        """
        points = np.asarray(points, np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points):
            raise ValueError(f"expected points [n, 3], got {list(points.shape)}")
        if not np.isfinite(points).all() or not (points[:, 2] > 0.0).all():
            raise ValueError("expected points [n, 3] before the camera (z > 0): leave out placeholders for missing depths")
        if (count := count_distinct_points(points, MIN_POINTS)) < MIN_POINTS:
            raise ValueError(f"expected points [n, 3] at {MIN_POINTS} positions or more, got {count}")
        seen = _sample(points, self.network.points, seed)
        is_outlier = find_outliers(points, seen)
        if is_outlier.any():
            seen = _sample(points[~is_outlier], self.network.points, seed)
        diagonal = float(np.linalg.norm(np.ptp(seen, axis=0)))
        (prediction,), (estimate,) = self.network.predict([seen], [diagonal], seed=seed)
        seen_parts = np.asarray(prediction.parts, np.int64)
        parts = np.where(is_outlier, -1, seen_parts[cKDTree(seen).query(points, workers=-1)[1]])
        return ScanPrediction(np.asarray(parts, np.int16), is_outlier, estimate, seen, seen_parts)


def _sample(points: NDArray[np.floating], count: int, seed: int) -> F64:
    """`count` different positions of points [n, 3], repeated only if there are too few; independent of their order."""
    ordered = points[np.lexsort(points.T)]
    is_new = np.any(ordered[1:] != ordered[:-1], axis=1)
    places = ordered[np.append(True, is_new)]
    rng = np.random.default_rng(seed)
    chosen = np.resize(rng.permutation(len(places)), count)
    return np.asarray(places[chosen], np.float64)


def choose_run(workspace: Workspace, category: str, method: str | None, seed: int) -> ScanRun:
    """Choose the networks for a category in any spelling, preferably of a seed.

    With a `method`, only networks that learned from its pseudo labels fit. Raises InputError if nothing fitting is trained.
    """

    def rank(run: ScanRun) -> tuple[bool, int, int, bool]:
        return run.seed != seed, PREFERRED.index(run.setting), run.seed, run.method != DEFAULT_METHOD

    trained, unfinished = (
        [run for run in found if method is None or (run.setting == "semi-weakly" and run.method == method)]
        for found in (trained_runs(workspace), unfinished_runs(workspace))
    )
    fitting = [run for run in trained if same_category(run.category, category)]
    if fitting:
        return min(fitting, key=rank)
    if any(same_category(run.category, category) for run in unfinished):
        problem = f"the training of networks for {category} is not finished: run the same kinmo train again to finish it"
        raise InputError(workspace.models, problem)
    known = sorted({run.category for run in trained})
    near, there = did_you_mean(category, known), f"; there are networks for {', '.join(known)}" if known else ""
    labels = f" that learned from pseudo labels of {method}" if method else ""
    command = f"kinmo train all --category {quote(category)}" + (f" --method {method}" if method else "")
    problem = f"no networks for scans of {category}{labels}{near}{there}" + ("" if near else f": run {command} first")
    raise InputError(workspace.models, problem)
