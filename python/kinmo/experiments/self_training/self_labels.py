"""Labels for scans of unlabelled objects, from predictions of networks (the paper's ANCSH (Semi), section 4.2)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.scans.object_structure import Extents, Structure
from kinmo.scans.poses.point_predictions import MIDDLE, PointPredictions, predicted_half_sizes, predicted_joints
from kinmo.scans.poses.scan_estimate import ScanEstimate
from kinmo.scans.rendering.labelled_frames import LabelledFrames

F64 = NDArray[np.float64]

UNSURE = "networks were not sure of it"  # reason why frames are skipped


@dataclass(frozen=True, eq=False)
class PredictedObject:
    """One object as networks predict it, to be written with its frames (`ScannedObject`), in the normalised frame."""

    id: str
    category: str
    structure: Structure
    joints: tuple[Joint, ...]
    part_extents: Extents

    @property
    def axis_aligned_shares(self) -> F64:
        """Axis-aligned shares [K] of the parts' surfaces: NaN, because they are unknown."""
        return np.full(self.structure.part_count, np.nan)


def is_sure(estimate: ScanEstimate, confidence: float) -> bool:
    """True if every part was found, and at least the share `confidence` of each part's points agrees on its pose."""
    is_found = estimate.poses.found.all() and np.isfinite(estimate.directions).all()
    return bool(is_found and estimate.inliers.min() >= confidence)


def self_label(
    shape_id: str,
    category: str,
    points: NDArray[np.float32],
    predictions: Sequence[PointPredictions],
    estimates: Sequence[ScanEstimate],
    *,
    structure: Structure,
    confidence: float,
) -> tuple[PredictedObject, LabelledFrames] | None:
    """Label the frames of one object that the networks are sure of (`is_sure`); None if there is none.

    Boxes and joints are medians over these frames. The canonical position of a point follows from the pose of its part, not
    from the prediction for the point alone. Part poses and joint states of the labelled frames are NaN.

    The F scans [F, n, 3] are in the camera frame, with predictions for the points and an estimate for each. `structure` is the
    one that the networks know.
    """
    sure = [row for row, estimate in enumerate(estimates) if is_sure(estimate, confidence)]
    if not sure:
        return None
    extents = _extents([predictions[row] for row in sure])
    joints = _joints([predictions[row] for row in sure], [estimates[row] for row in sure], structure)
    parts = np.stack([predictions[row].parts for row in sure])
    places = np.zeros((len(sure), *points.shape[1:]), np.float32)
    for frame, row in enumerate(sure):
        found = estimates[row].poses
        for part in range(structure.part_count):
            own = parts[frame] == part
            npcs = (points[row][own] - found.translations[part]) @ found.rotations[part] / found.scales[part]
            places[frame, own] = (npcs - MIDDLE) * extents.diagonals[part] + extents.centers[part]
    poses = np.full((len(sure), structure.part_count, 4, 4), np.nan)
    values, turns = np.full((2, len(sure), structure.part_count - 1), np.nan)
    skipped = Counter({UNSURE: len(estimates) - len(sure)})
    frames = LabelledFrames(points[sure], parts.astype(np.int16), places, poses, values, turns, skipped)
    return PredictedObject(shape_id, category, structure, joints, extents), frames


def _extents(predictions: Sequence[PointPredictions]) -> Extents:
    """Boxes of the parts: their diagonals are the predicted NAOCS sizes, their proportions those of the predicted boxes."""
    scales = np.median([own.part_scales for own in predictions], axis=0)
    shifts = np.median([own.part_shifts for own in predictions], axis=0)
    shapes = np.median([predicted_half_sizes(own) for own in predictions], axis=0)
    sizes = shapes / np.linalg.norm(shapes, axis=1, keepdims=True) * scales[:, None]
    return Extents(shifts + MIDDLE * scales[:, None] - MIDDLE, sizes)


def _joints(
    predictions: Sequence[PointPredictions], estimates: Sequence[ScanEstimate], structure: Structure
) -> tuple[Joint, ...]:
    """Joints with the median pivot and the mean direction of all frames."""
    parents = list(structure.parents)
    # directions [K - 1, 3] of each frame, in the frames of the parent parts
    found = [np.einsum("kji,kj->ki", own.poses.rotations[parents], own.directions) for own in estimates]
    directions = [_mean_direction(np.stack([own[row] for own in found])) for row in range(len(parents))]
    pivots = np.median([predicted_joints(own, structure)[1] for own in predictions], axis=0)
    axes = zip(structure.kinds, directions, pivots, strict=True)
    return tuple(Joint(kind, direction, pivot - MIDDLE) for kind, direction, pivot in axes)


def _mean_direction(directions: F64) -> F64:
    """Unit vector [3] along the line that fits unit vectors [n, 3] of any sign best, with the sign of most of them."""
    _, axes = np.linalg.eigh(directions.T @ directions)
    line = np.asarray(axes[:, -1])
    return -line if (directions @ line > 0.0).mean() < 0.5 else line
