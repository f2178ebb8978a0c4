"""Amodal boxes of parts: predicted boxes, fitted to the sides that a scan shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.scans.poses.point_predictions import MIDDLE, PointPredictions, predicted_half_sizes

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
Poses = tuple[F64, F64, F64]
"""Rotations [P, 3, 3], scales [P] and translations [P, 3] from NPCS to the input frame. P counts all parts of some scans, one
scan after the other. Parts that were not found are NaN."""


def predicted_boxes(predictions: Sequence[PointPredictions], poses: Poses) -> tuple[F64, F64]:
    """Amodal boxes as predicted.

    Args:
        predictions: Predictions for some scans.
        poses: Poses of all their P parts.

    Returns:
        Centers and half extents [P, 3] in the input frame.
    """
    rotations, scales, translations = poses
    half_extents = np.concatenate([predicted_half_sizes(each) for each in predictions]) * scales[:, None]
    return np.einsum("p,pij,j->pi", scales, rotations, MIDDLE) + translations, half_extents


def fitted_boxes(predictions: Sequence[PointPredictions], poses: Poses, threshold: float) -> tuple[F64, F64]:
    """Amodal boxes with their visible sides moved to where the scan shows them (`_core.adjust_amodal_boxes`).

    Args:
        predictions: Predictions for some scans.
        poses: Poses of all their P parts.
        threshold: Largest distance between a point and its predicted position, in the input frame. Other points do not count.

    Returns:
        Centers and half extents [P, 3] in the input frame.
    """
    centers, half_extents = predicted_boxes(predictions, poses)
    is_known = np.asarray(np.isfinite(centers).all(axis=1) & np.isfinite(half_extents).all(axis=1))
    count = len(centers) // len(predictions)
    rows = [slice(frame * count, (frame + 1) * count) for frame in range(len(predictions))]
    owners = [_owners(each, [of[row] for of in poses], threshold) for each, row in zip(predictions, rows, strict=True)]
    moved, _, fitted = _core.adjust_amodal_boxes(
        np.concatenate([each.points for each in predictions]),
        np.cumsum([0, *(len(each.points) for each in predictions)], dtype=np.int64),
        np.concatenate(owners),
        np.stack([each.frame.apply(np.zeros(3)).astype(np.float64) for each in predictions]),
        np.where(is_known[:, None], centers, 0.0),
        np.where(is_known[:, None, None], np.swapaxes(poses[0], 1, 2), np.eye(3)),
        np.where(is_known[:, None], half_extents, 0.0),
        frames=np.arange(len(predictions) + 1, dtype=np.int64) * count,
    )
    return np.where(is_known[:, None], moved, centers), np.where(is_known[:, None], fitted, half_extents)


def _owners(predictions: PointPredictions, poses: Sequence[F64], threshold: float) -> I64:
    """Part [n] of each point; -1 for a point that does not fit the pose of its part."""
    rotations, scales, translations = poses
    part = np.maximum(predictions.parts, 0)
    places = scales[part, None] * np.einsum("nij,nj->ni", rotations[part], predictions.npcs) + translations[part]
    fits = (predictions.parts >= 0) & (np.linalg.norm(places - predictions.points, axis=1) < threshold)
    return np.where(fits, predictions.parts, -1)
