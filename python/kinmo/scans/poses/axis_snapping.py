"""Snapping of predicted joint directions to the axes of NAOCS, by the category prior."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.point_predictions import MAX_MISFIT, PointPredictions, joint_voters
from kinmo.scans.poses.scan_estimate import Poses

F64 = NDArray[np.float64]

MIN_SNAP_COSINE = np.cos(np.radians(20.0))
"""Cosine from which on a predicted direction may snap to an axis."""
MAX_COST_RATIO = 1.5
"""Largest ratio of the fitting cost with the axis to the one with the predicted direction at which the direction snaps."""
MIN_VOTERS = 2
"""Number of voters from which on their spread shows how reliable they are."""
CERTAINTY = 100.0
"""Ratio of the distance to the axis over the voters' spread from which on the prediction is certain. The common error of
predictions is a few times their spread at most."""


def snap_directions(
    predictions: Sequence[PointPredictions], directions: Sequence[F64], poses: Poses, structure: Structure, prior: CategoryPrior
) -> list[F64]:
    """Snap the joint directions [K - 1, 3] of each scan to the nearest axis of NAOCS.

    A joint that is along an axis in the category, and predicted within 20 degrees of one, snaps to it. It keeps its predicted
    direction if its voters agree far too well to be wrong, or if its two parts then fit their points clearly worse. `poses`
    are those of all parts of all scans, fitted without joints.
    """
    snapped = [own.copy() for own in directions]
    for frame, each in enumerate(predictions):
        for row in np.flatnonzero(prior.along_axes):
            direction = directions[frame][row]
            axis = _nearest_axis(direction)
            if axis is None or _is_certain(each.axes[joint_voters(each, row + 1)], direction, axis):
                continue
            parts = structure.parents[row], int(row) + 1
            rotations, scales, translations = (values[frame * structure.part_count + np.array(parts)] for values in poses)
            two = each, parts, (rotations, scales, translations), structure.kinds[row]
            are_found = np.isfinite(scales).all()
            if not (are_found and _cost(*two, axis) > MAX_COST_RATIO * _cost(*two, direction)):
                snapped[frame][row] = axis
    return snapped


def _nearest_axis(direction: F64) -> F64 | None:
    """The signed axis near a unit vector; None if there is none within 20 degrees."""
    nearest = np.argmax(np.abs(direction))
    if not abs(direction[nearest]) >= MIN_SNAP_COSINE:
        return None
    axis = np.zeros(3)
    axis[nearest] = np.sign(direction[nearest])
    return axis


def _is_certain(axes: F64, direction: F64, axis: F64) -> bool:
    """True if the predicted axes [n, 3] agree far better with each other than with the coordinate axis."""
    lengths = np.linalg.norm(axes, axis=1)
    if len(axes) < MIN_VOTERS or not lengths.all():
        return False
    spread = np.median(np.linalg.norm(axes / lengths[:, None] - direction, axis=1))
    return bool(np.linalg.norm(axis - direction) > CERTAINTY * spread)


def _cost(predictions: PointPredictions, parts: tuple[int, int], poses: Poses, kind: JointKind, direction: F64) -> float:
    """Fitting cost of two parts, tied by a joint, over the points that fit the `poses` of the parts alone."""
    clouds = []
    for part, *pose in zip(parts, *poses, strict=True):
        source, target = predictions.on_part(part)
        fits = _residuals(source, target, *pose) < MAX_MISFIT
        clouds.append((source[fits], target[fits]))
    source, target = (np.concatenate([cloud[side] for cloud in clouds]) for side in (0, 1))
    offsets = np.cumsum([0, *(len(own) for own, _ in clouds)], dtype=np.int64)
    tie = np.array([[0, 1]], np.uint32), np.array([kind.code], np.uint8), direction[None]
    frames = np.array([0, 2], np.int64)
    tied = _core.fit_constrained_poses(source, target, offsets, *tie, *poses, frames=frames, threshold=MAX_MISFIT)
    residuals = (_residuals(*cloud, *pose) for cloud, pose in zip(clouds, zip(*tied, strict=True), strict=True))
    return float(sum(np.minimum(each, MAX_MISFIT).sum() for each in residuals))


def _residuals(source: F64, target: F64, rotation: F64, scale: float, translation: F64) -> F64:
    return np.asarray(np.linalg.norm(scale * source @ rotation.T + translation - target, axis=1))
