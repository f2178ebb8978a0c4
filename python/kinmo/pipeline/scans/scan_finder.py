"""Trained networks as one object that finds parts, joints and their states in depth scans, one after another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from shlex import quote

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.workspace import DEFAULT_METHOD, Workspace
from kinmo.learning.model_folder import networks_digest
from kinmo.pipeline.scans.scan_networks import Cell, trained_by_all_methods, unfinished_by_all_methods
from kinmo.pipeline.scans.training_settings import PSEUDO_LABELLED
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.articulated_object import Structure
from kinmo.scans.outliers import are_strays
from kinmo.scans.pose_fitting import ScanEstimate
from kinmo.scans.scan_reader import LEAST_POINTS, count_places

F64 = NDArray[np.float64]

PREFERRED = ("semi-weakly", "dsg-net", "semi", "supervised", "ceiling")
"""Settings whose networks answer, the first that there is."""


@dataclass(frozen=True, eq=False)
class FoundInScan:
    """What there is to see in a scan of n points.

    `parts` [n] is the part of every point, 0 the base, -1 what is of none: the floor, and what `is_stray` [n], far from all
    other points. `estimate` says where the parts, their boxes and joints are, in the frame and the lengths of the scan.
    Networks saw the points `seen` [m, 3] and said that they are of `seen_parts` [m]; every other point has the part of the
    nearest of these.
    """

    parts: NDArray[np.int16]
    is_stray: NDArray[np.bool_]
    estimate: ScanEstimate
    seen: F64
    seen_parts: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ScanFinder:
    """Finds objects of one `category` in depth scans, one at a time and as fast as they come.

    `trained` says what its networks learnt from, and `weights` is a hash of theirs. docs/scans.md has an example.
    """

    network: Ancsh
    category: str
    trained: str
    weights: str

    @classmethod
    def load(
        cls, workspace: Workspace | Path | str, category: str, *, method: str | None = None, seed: int = 0, device: str = "auto"
    ) -> ScanFinder:
        """The networks that `kinmo train` has made for a category, by pseudo labels of `method` if it is given.

        Raises InputError if there are none, or they cannot be read.
        """
        place = workspace if isinstance(workspace, Workspace) else Workspace(Path(workspace))
        place, cell = networks_for(place, category, method, seed)
        weights = cell.weights(place)
        assert weights is not None, "trained_by_all_methods has those with weights"
        return cls(Ancsh.load(*weights, device=device), cell.category, cell.title(place), networks_digest(weights))

    @property
    def structure(self) -> Structure:
        """Of the objects that it finds: which part hangs by which, by what kind of joint."""
        return self.network.structure

    def find(self, points: NDArray[np.floating], *, seed: int = 0) -> FoundInScan:
        """Parts and joints of the object of which `points` [n, 3] were seen, in the frame of the camera.

        The camera looks along z, with x to the right and y down. What stands for nothing seen, such as (0, 0, 0), must not be
        among them; `read_scan` leaves it out. What comes out depends on where points are, in whatever order, and on `seed`
        alone. Raises ValueError for an array of another shape, for none, for points at no number or not before the camera, and
        for points at fewer than 32 places.
        """
        points = np.asarray(points, np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points):
            raise ValueError(f"expected points [n, 3], got {list(points.shape)}")
        if not np.isfinite(points).all() or not (points[:, 2] > 0.0).all():
            raise ValueError("expected points [n, 3] before the camera (z > 0): leave out what stands for nothing seen")
        if (count := count_places(points, LEAST_POINTS)) < LEAST_POINTS:
            raise ValueError(f"expected points [n, 3] at {LEAST_POINTS} places or more, got {count}")
        seen = _some_of(points, self.network.points, seed)
        is_stray = are_strays(points, seen)
        if is_stray.any():
            seen = _some_of(points[~is_stray], self.network.points, seed)
        diagonal = float(np.linalg.norm(np.ptp(seen, axis=0)))
        (answer,), (estimate,) = self.network.find([seen], [diagonal], seed=seed)
        seen_parts = np.asarray(answer.parts, np.int64)
        parts = np.where(is_stray, -1, seen_parts[cKDTree(seen).query(points, workers=-1)[1]])
        return FoundInScan(np.asarray(parts, np.int16), is_stray, estimate, seen, seen_parts)


def _some_of(points: NDArray[np.floating], count: int, seed: int) -> F64:
    """`count` of the places of points [n, 3], none more often than needed; the same in whatever order the points are."""
    ordered = points[np.lexsort(points.T)]
    is_other = np.any(ordered[1:] != ordered[:-1], axis=1)
    places = ordered[np.append(True, is_other)]
    rng = np.random.default_rng(seed)
    chosen = np.resize(rng.permutation(len(places)), count)
    return np.asarray(places[chosen], np.float64)


def networks_for(workspace: Workspace, category: str, method: str | None, seed: int) -> tuple[Workspace, Cell]:
    """Those that answer for a category, and the workspace that they are in. Raises InputError if nothing was trained for it."""
    trained, unfinished = trained_by_all_methods(workspace), unfinished_by_all_methods(workspace)
    if method is not None:
        trained, unfinished = (
            [(place, cell) for place, cell in found if place.method == method and cell.setting in PSEUDO_LABELLED]
            for found in (trained, unfinished)
        )
    fitting = [(place, cell) for place, cell in trained if same_category(cell.category, category)]
    if not fitting:
        if any(same_category(cell.category, category) for _, cell in unfinished):
            problem = (
                f"networks that find a {category} in scans are not trained to the end: the same kinmo train goes on with it"
            )
            raise InputError(workspace.models, problem)
        known = sorted({cell.category for _, cell in trained})
        near = did_you_mean(category, known)
        there = f"; there are those of {', '.join(known)}" if known else ""
        saw = f" and saw pseudo labels of --method {method}" if method else ""
        command = f"kinmo train all --category {quote(category)}" + (f" --method {method}" if method else "")
        problem = f"no networks that find a {category} in scans{saw}{near}{there}" + ("" if near else f": run {command} first")
        raise InputError(workspace.models, problem)
    return min(fitting, key=_rank(seed))


def _rank(seed: int) -> Callable[[tuple[Workspace, Cell]], tuple[bool, int, int, bool]]:
    """The least comes first."""

    def rank(trained: tuple[Workspace, Cell]) -> tuple[bool, int, int, bool]:
        place, cell = trained
        return cell.seed != seed, PREFERRED.index(cell.setting), cell.seed, place.method != DEFAULT_METHOD

    return rank
